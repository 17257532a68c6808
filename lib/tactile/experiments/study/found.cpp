#include "tactile/experiments/study/found.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "tactile/experiments/milliseconds.hpp"

namespace tactile::study {
namespace {

/// "88.3 % [81.3, 94.5]"
std::string text_of(const results::Figure& figure, double factor, const std::string& unit, int digits = 1) {
  if (!std::isfinite(figure.value)) return "an unknown share";
  const auto number = [&](double value) { return fmt::format("{:.{}f}", factor * value, digits); };
  const std::string text = number(figure.value) + unit;
  return figure.has_interval() ? text + fmt::format(" [{}, {}]", number(*figure.low), number(*figure.high)) : text;
}

std::string accuracy_sentence(const results::Evaluation& reported, microseconds history) {
  const results::Figure& accuracy = reported.accuracy.mean;
  std::string text = fmt::format(
      "With t_h {} ms LeNet predicts {} of the samples correctly, on {} runs that it did not learn from (mean over {} objects, {} "
      "training{})",
      experiments::ms_text(history), text_of(accuracy, 100, " %"), reported.simulated ? "simulated" : "real", accuracy.n,
      accuracy.trainings, accuracy.trainings == 1 ? "" : "s");
  const auto best = std::max_element(reported.baselines.begin(), reported.baselines.end(), [](const auto& a, const auto& b) {
    return a.accuracy.mean.value < b.accuracy.mean.value;
  });
  if (best != reported.baselines.end())
    text += fmt::format("; the best baseline, {}, {}", best->name, text_of(best->accuracy.mean, 100, " %"));
  return text + ".";
}

std::string delay_sentence(const results::DetectorScore& network) {
  const results::DelaySummary &press = network.press.all, &slip = network.slip.all;
  const auto within = [](const results::CensoredQuantile& quantile) {
    return (quantile.is_lower_bound ? "no less than " : "") + text_of(quantile.ms, 1, " ms", 0);
  };
  return fmt::format("Half of the presses are detected within {}, half of the slips within {}; {} and {} are missed.",
                     within(press.median_of_all_ms), within(slip.median_of_all_ms), text_of(press.missed, 100, " %"),
                     text_of(slip.missed, 100, " %"));
}

}  // namespace

std::vector<std::string> found_in(const results::Evaluation& reported, microseconds history,
                                  const results::UnseenComparison& unseen, const std::string& claims) {
  const results::FalseAlarmTable& alarms = reported.network.false_alarms;
  const results::Figure& change = unseen.mean.difference;
  return {accuracy_sentence(reported, history), delay_sentence(reported.network),
          fmt::format("Outside labelled touches there are {} false alarms per minute, and {} of the time without touch is in alarm.",
                      text_of(alarms.outside_labels_per_min, 1, ""), text_of(alarms.none_in_alarm_share, 100, " %")),
          unseen.objects.empty()
              ? std::string("No object was held out of training.")
              : fmt::format("On objects that it has never seen the accuracy changes by {} (mean over {} objects).",
                            text_of(change, 100, " points"), change.n),
          claims};
}

}  // namespace tactile::study
