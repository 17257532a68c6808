#include "tactile/results/found.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace tactile::results {
namespace {

std::string percent_of(const Figure& figure, std::string_view unit = " %", std::string_view format = ".1f") {
  return text_of(scaled(figure, 100), unit, format);
}

/// "40 ms", or "30, 40 or 50 ms" where trainings chose several
std::string histories_text(std::vector<microseconds> histories) {
  std::sort(histories.begin(), histories.end());
  histories.erase(std::unique(histories.begin(), histories.end()), histories.end());
  std::string text;
  for (std::size_t i = 0; i < histories.size(); ++i)
    text += (i == 0                      ? ""
             : i + 1 == histories.size() ? " or "
                                         : ", ") +
            fmt::format("{}", static_cast<double>(histories[i].count()) / 1000);
  return text + " ms";
}

std::string accuracy_sentence(const Evaluation& reported, const std::vector<microseconds>& histories) {
  const Figure& accuracy = reported.accuracy.mean;
  std::string text = fmt::format(
      "With a t_h of {} the model predicts {} of the samples correctly, on {} runs that it did not learn from (mean over {} "
      "objects, {} training{})",
      histories_text(histories), percent_of(accuracy), reported.simulated ? "simulated" : "real", accuracy.n, accuracy.trainings,
      accuracy.trainings == 1 ? "" : "s");
  const auto best = std::max_element(reported.baselines.begin(), reported.baselines.end(),
                                     [](const auto& a, const auto& b) { return a.accuracy.mean.value < b.accuracy.mean.value; });
  if (best != reported.baselines.end())
    text += fmt::format("; the best baseline, {}, {}", best->name, percent_of(best->accuracy.mean));
  return text + ".";
}

std::string delay_sentence(const DetectorScore& network) {
  const DelaySummary &press = network.press.all, &slip = network.slip.all;
  const auto within = [](const CensoredQuantile& quantile) {
    return (quantile.is_lower_bound ? "no less than " : "") + text_of(quantile.ms, " ms", ".0f");
  };
  return fmt::format(
      "Half of the presses are detected within {}, half of the slips within {}; {} of the presses and {} of the "
      "slips are missed.",
      within(press.median_of_all_ms), within(slip.median_of_all_ms), percent_of(press.missed), percent_of(slip.missed));
}

std::string false_alarm_sentence(const WholeRuns& whole) {
  const OperatingPoint& point = whole.decided;
  return fmt::format(
      "False alarms, on {} whole runs of all kinds: {} per minute outside of touches, which is {:.1f} % of that time.",
      whole.runs.size(), text_of(point.alarms_per_min, ""), 100 * point.in_alarm);
}

}  // namespace

std::vector<std::string> found_in(const Evaluation& reported, const std::vector<microseconds>& histories,
                                  const UnseenComparison& unseen, const std::string& claims) {
  const Figure& change = unseen.mean.difference;
  std::vector<std::string> sentences{
      accuracy_sentence(reported, histories), delay_sentence(reported.network), false_alarm_sentence(reported.whole_runs),
      unseen.objects.empty()
          ? std::string("No object was held out of training.")
          : fmt::format("On objects that it has never seen the accuracy changes by {} (mean over {} object{}).",
                        percent_of(change, " points"), change.n, change.n == 1 ? "" : "s"),
      claims};
  const DetectorScore& network = reported.network;
  std::string note = note_on_intervals({reported.accuracy.mean, network.press.all.median_of_all_ms.ms, network.press.all.missed,
                                        network.slip.all.median_of_all_ms.ms, network.slip.all.missed,
                                        reported.whole_runs.decided.alarms_per_min, change});
  if (!note.empty()) sentences.push_back(std::move(note));
  return sentences;
}

}  // namespace tactile::results
