#include "tactile/experiments/trade/usual_judgement.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace tactile::trade {
namespace {

constexpr double margin_of_shares = 0.01, margin_of_delay_us = 1000, margin_of_episodes = 1;

bool is_faster(const results::TradeDifference& difference) {
  const auto is_below = [](const results::Figure& us) { return us.high && *us.high < 0; };
  return is_below(difference.us_p50) && is_below(difference.us_p99);
}

/// Fewer trainings decide nothing, as in a study.
constexpr std::size_t fewest_trainings = 5;

/// Whether the differences have what the rule needs.
bool is_testable(const results::TradeDifference& difference) {
  return difference.accuracy.trainings >= fewest_trainings && difference.us_p50.has_interval() &&
         difference.us_p99.has_interval() && difference.accuracy.has_interval() && difference.delay_us.has_interval() &&
         difference.missed.has_interval() && difference.episodes_per_min.has_interval();
}

bool is_better(const results::TradeDifference& difference) {
  const auto at_most = [](const results::Figure& figure, double most) { return figure.high && *figure.high <= most; };
  return is_faster(difference) && difference.accuracy.low && *difference.accuracy.low >= -margin_of_shares &&
         at_most(difference.delay_us, margin_of_delay_us) && at_most(difference.missed, margin_of_shares) &&
         at_most(difference.episodes_per_min, margin_of_episodes);
}

std::string text_of(const TradePoint& point, const TradeSetting& usual) {
  const results::TradeDifference& difference = *point.difference;
  return fmt::format(
      "{} (time in half of the ticks {}, accuracy {}, delay {}, misses {}, false alarms {})", text_of(point.setting, usual),
      text_of(difference.us_p50, " us", "+.0f"), text_of(scaled(difference.accuracy, 100), " points", "+.1f"),
      text_of(scaled(difference.delay_us, 1e-3), " ms", "+.1f"), text_of(scaled(difference.missed, 100), " points", "+.1f"),
      text_of(difference.episodes_per_min, " per minute", "+.1f"));
}

/// What the rule found of the settings that it could test, and what it could not test.
std::string outcome_of_rule(std::size_t tested, std::size_t untested, std::size_t usual_trainings,
                            const std::vector<std::string>& better) {
  const std::string needed =
      fmt::format("{} trainings of both settings, and a 95 % interval of each difference", fewest_trainings);
  if (tested == 0)
    return fmt::format(
        "Whether another setting is better could not be tested: that needs {}. The usual setting has {} training{}.", needed,
        usual_trainings, usual_trainings == 1 ? "" : "s");
  std::string text =
      better.empty()
          ? fmt::format(
                "None of the tested settings ({}) is better by the whole 95 % intervals: faster, and at most 1 point "
                "less accurate, 1 ms later, with 1 point more misses and 1 more false alarm a minute. This is no evidence for "
                "another default.",
                tested)
          : fmt::format("Better than it by the whole 95 % intervals of their differences: {}.", fmt::join(better, "; "));
  if (untested > 0) text += fmt::format(" {} other settings could not be tested: that needs {}.", untested, needed);
  return text;
}

}  // namespace

std::string judgement_of_usual(std::span<const TradePoint> points, const TradeSetting& usual) {
  if (points.size() < 2) return {};
  std::size_t tested = 0, untested = 0;
  std::vector<std::string> better;
  const TradePoint* nearest = nullptr;
  for (const TradePoint& point : points) {
    if (!point.difference || !point.setting.sparse) continue;
    ++(is_testable(*point.difference) ? tested : untested);
    if (is_testable(*point.difference) && is_better(*point.difference)) better.push_back(text_of(point, usual));
    const auto accuracy = [](const TradePoint& one) { return one.difference->accuracy.value; };
    if (is_faster(*point.difference) && (nearest == nullptr || accuracy(point) > accuracy(*nearest))) nearest = &point;
  }
  const std::string on_front = text_of(points.front().front_probability);
  std::string text =
      (on_front.empty()
           ? fmt::format("How probable it is that the usual setting is on a front is unknown: that needs {} objects. ",
                         fewest_objects)
           : fmt::format("The usual setting is {}. ", on_front)) +
      outcome_of_rule(tested, untested, points.front().networks.size(), better);
  if (!better.empty() || nearest == nullptr) return text;
  const results::TradeDifference& difference = *nearest->difference;
  const std::string note = results::note_on_intervals(
      {difference.us_p50, difference.accuracy, difference.delay_us, difference.missed, difference.episodes_per_min});
  return fmt::format("{} The most accurate of those that are faster by the whole intervals: {}.{}", text,
                     text_of(*nearest, usual), note.empty() ? "" : " " + note);
}

}  // namespace tactile::trade
