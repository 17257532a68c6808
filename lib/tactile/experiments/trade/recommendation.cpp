#include "tactile/experiments/trade/recommendation.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>
#include <vector>

namespace tactile::trade {
namespace {

const results::CensoredQuantile& delay_of(const DelayLimit& limit, const results::TradeResult& figures) {
  return limit.p90 ? figures.whole_runs.p90_ms : figures.whole_runs.median_ms;
}

bool all_met(const TradeConstraints& constraints, const results::TradeResult& figures,
             const std::function<bool(const results::Figure&, double, bool at_least)>& is_met) {
  return (!constraints.at_most_us || is_met(figures.us_p99, *constraints.at_most_us, false)) &&
         (!constraints.at_least_accuracy || is_met(figures.accuracy, *constraints.at_least_accuracy, true)) &&
         (!constraints.at_most_false_alarms_per_min ||
          is_met(figures.whole_runs.alarms_per_min, *constraints.at_most_false_alarms_per_min, false)) &&
         (!constraints.at_most_delay ||
          (!delay_of(*constraints.at_most_delay, figures).is_lower_bound &&  // it falls on what was never detected
           is_met(delay_of(*constraints.at_most_delay, figures).ms, constraints.at_most_delay->ms, false))) &&
         (!constraints.at_most_missed || is_met(figures.whole_runs.missed, *constraints.at_most_missed, false));
}

/// The distance of a figure from its limit, in halves of its interval; 0 without an interval.
double margin(const results::Figure& figure, double limit, bool at_least) {
  const std::optional<double>& bound = at_least ? figure.low : figure.high;
  if (!bound) return 0;
  const double room = std::abs(figure.value - limit), doubt = std::abs(figure.value - *bound);
  return doubt > 0 ? room / doubt : std::numeric_limits<double>::infinity();
}

/// The least margin over all constraints, for a setting whose values meet them.
double least_margin(const TradeConstraints& constraints, const results::TradeResult& figures) {
  double least = std::numeric_limits<double>::infinity();
  all_met(constraints, figures, [&](const results::Figure& figure, double limit, bool at_least) {
    least = std::min(least, margin(figure, limit, at_least));
    return true;
  });
  return least;
}

std::string delay_text(const results::CensoredQuantile& delay) {
  return std::string(delay.is_lower_bound ? "at least " : "") + text_of(delay.ms, " ms", ".2f");
}

std::string measured_text(const results::TradeResult& figures) {
  const std::string note = results::note_on_intervals(
      {figures.accuracy, figures.us_p50, figures.us_p99, figures.us_p999, measured(figures.whole_runs.median_ms),
       measured(figures.whole_runs.p90_ms), figures.whole_runs.missed, figures.whole_runs.alarms_per_min});
  return fmt::format(
      "an accuracy of {}. A tick takes {} in half of the ticks, {} in 99 of 100 and {} in 999 of 1000; other programs "
      "interrupted {:.2g} % of them. The delay is {} in half of the presses and slips and {} in 90 % of them; {} are missed or "
      "early. There are {} false alarms per minute outside "
      "of touches, with those in releases and in motion without labels.{}",
      text_of(scaled(figures.accuracy, 100), " %", ".2f"), text_of(figures.us_p50, " us", ".0f"),
      text_of(figures.us_p99, " us", ".0f"), text_of(figures.us_p999, " us", ".0f"), 100 * figures.interrupted,
      delay_text(figures.whole_runs.median_ms), delay_text(figures.whole_runs.p90_ms),
      text_of(scaled(figures.whole_runs.missed, 100), " %", ".1f"), text_of(figures.whole_runs.alarms_per_min, "", ".2f"),
      note.empty() ? "" : " " + note);
}

/// Whether only the time is against a setting, and the time is the machine's: without other programs, the 99 % quantile would lie
/// between the median and what was measured.
bool may_meet_on_an_idle_machine(const TradeConstraints& constraints, results::TradeResult figures) {
  if (!figures.is_disturbed() || meets(constraints, figures)) return false;
  figures.us_p99 = figures.us_p50;
  return meets(constraints, figures);
}

constexpr std::string_view how_to_time_again =
    "Where other programs interrupt more than 1 % of the ticks, the p99 is the machine's. On an idle machine, remove the folders "
    "'times' and 'trial' of the trade, and run the same command again.";

/// Why the measurement does not confirm a setting; empty if it does.
std::string why_not_confirmed(const TradeConstraints& constraints, const results::TradeResult& reported) {
  if (meets_in_interval(constraints, reported)) return {};
  if (may_meet_on_an_idle_machine(constraints, reported))
    return fmt::format("the machine was too busy to time it. {}", how_to_time_again);
  if (!meets(constraints, reported)) return "on the runs to report on, its values do not meet the constraints";
  const bool has_intervals = all_met(constraints, reported, [](const results::Figure& figure, double limit, bool at_least) {
    static_cast<void>(limit), static_cast<void>(at_least);
    return figure.has_interval();
  });
  return has_intervals ? "its values meet the constraints, but not its whole 95 % intervals"
                       : "there is no 95 % interval to confirm it with";
}

/// Whether the trial meets the limit of time; without a limit, the tick is the limit.
bool meets_in_detect(const TradeConstraints& constraints, const results::TradeResult& figures,
                     const std::optional<LiveTrial>& trial) {
  return !trial || trial->us_p99 <= std::min(constraints.at_most_us.value_or(figures.tick_us), figures.tick_us);
}

std::string of_runs(bool simulated) { return simulated ? " On simulated runs, which say nothing about real ones." : ""; }

std::string trial_text(const std::optional<LiveTrial>& trial) {
  if (!trial) return {};
  return fmt::format(
      " In 'tactile detect' over loopback it took {:.0f} us in half of {} ticks, {:.0f} us in 99 of 100 and {:.0f} us in 999 of "
      "1000, and {:.2f} % of the ticks were skipped or late.",
      trial->us_p50, trial->ticks, trial->us_p99, trial->us_p999, 100 * trial->missed_share);
}

}  // namespace

void to_json(nlohmann::json& json, const TradeConstraints& constraints) {
  const auto number = [](const std::optional<double>& value) { return value ? nlohmann::json(*value) : nlohmann::json(); };
  json = {{"at_most_us", number(constraints.at_most_us)},
          {"at_least_accuracy", number(constraints.at_least_accuracy)},
          {"at_most_false_alarms_per_min", number(constraints.at_most_false_alarms_per_min)},
          {"at_most_delay_ms", constraints.at_most_delay ? nlohmann::json(constraints.at_most_delay->ms) : nlohmann::json()},
          {"delay_of",
           constraints.at_most_delay ? nlohmann::json(constraints.at_most_delay->p90 ? "p90" : "median") : nlohmann::json()},
          {"at_most_missed", number(constraints.at_most_missed)}};
}

std::string text_of(const TradeConstraints& constraints) {
  std::vector<std::string> words;
  if (constraints.at_most_us) words.push_back(fmt::format("at most {:g} us a tick", *constraints.at_most_us));
  if (constraints.at_least_accuracy)
    words.push_back(fmt::format("an accuracy of at least {:g} %", 100 * *constraints.at_least_accuracy));
  if (constraints.at_most_false_alarms_per_min)
    words.push_back(fmt::format("at most {:g} false alarms per minute", *constraints.at_most_false_alarms_per_min));
  if (constraints.at_most_delay)
    words.push_back(fmt::format("a delay of at most {:g} ms in {} of the presses and slips", constraints.at_most_delay->ms,
                                constraints.at_most_delay->p90 ? "90 %" : "half"));
  if (constraints.at_most_missed)
    words.push_back(fmt::format("at most {:g} % of presses and slips missed or early", 100 * *constraints.at_most_missed));
  return words.empty() ? "no constraint" : fmt::format("{}", fmt::join(words, " and "));
}

bool keeps_up(const results::TradeResult& figures) { return figures.us_p99.value <= figures.tick_us; }

bool meets(const TradeConstraints& constraints, const results::TradeResult& figures) {
  return keeps_up(figures) && all_met(constraints, figures, [](const results::Figure& figure, double limit, bool at_least) {
           return at_least ? figure.value >= limit : figure.value <= limit;  // false for NaN
         });
}

bool meets_in_interval(const TradeConstraints& constraints, const results::TradeResult& figures) {
  return meets(constraints, figures) &&
         all_met(constraints, figures, [](const results::Figure& figure, double limit, bool at_least) {
           const std::optional<double>& bound = at_least ? figure.low : figure.high;
           return bound && (at_least ? *bound >= limit : *bound <= limit);
         });
}

std::optional<TradeChoice> choose(const TradeConstraints& constraints, std::span<const results::TradeResult> settings) {
  const bool prefers_speed = constraints.at_least_accuracy && !constraints.at_most_us;
  const auto rank = [&](const results::TradeResult& figures) {
    const double accuracy = -figures.accuracy.value, us = figures.us_p99.value;
    return prefers_speed ? std::tuple(us, accuracy, figures.whole_runs.median_ms.ms.value)
                         : std::tuple(accuracy, figures.whole_runs.median_ms.ms.value, us);
  };
  for (const bool in_interval : {true, false}) {
    const auto goes_first = [&](const results::TradeResult& a, const results::TradeResult& b) {
      const double doubt_a = in_interval ? 0 : -least_margin(constraints, a),
                   doubt_b = in_interval ? 0 : -least_margin(constraints, b);
      return doubt_a != doubt_b ? doubt_a < doubt_b : rank(a) < rank(b);
    };
    std::optional<TradeChoice> best;
    for (std::size_t i = 0; i < settings.size(); ++i) {
      if (!std::isfinite(settings[i].accuracy.value) || !std::isfinite(settings[i].us_p99.value)) continue;
      if (!(in_interval ? meets_in_interval(constraints, settings[i]) : meets(constraints, settings[i]))) continue;
      if (!best || goes_first(settings[i], settings[best->index])) best = TradeChoice{i, in_interval};
    }
    if (best) return best;
  }
  return std::nullopt;
}

Recommendation recommend(const TradeConstraints& constraints, const std::string& setting, const results::TradeResult& reported,
                         const std::optional<LiveTrial>& trial, bool simulated) {
  std::string why = why_not_confirmed(constraints, reported);
  if (why.empty() && !meets_in_detect(constraints, reported, trial))
    why = fmt::format("it is too slow in 'tactile detect', where 99 of 100 ticks must take at most {:g} us",
                      std::min(constraints.at_most_us.value_or(reported.tick_us), reported.tick_us));
  const std::string measured = fmt::format("On runs that its trainings neither learned from nor were chosen on, it has {}{}",
                                           measured_text(reported), trial_text(trial));
  if (why.empty()) return {true, fmt::format("For {} use {}. {}{}", text_of(constraints), setting, measured, of_runs(simulated))};
  return {false, fmt::format(
                     "The setting chosen for {}, {}, is not confirmed: {}{} {} No other setting is tried on these runs: the best "
                     "of many tries proves nothing.{}",
                     text_of(constraints), setting, why, why.ends_with('.') ? "" : ".", measured, of_runs(simulated))};
}

std::string why_none(const TradeConstraints& constraints, std::span<const results::TradeResult> compared,
                     std::size_t not_compared, bool simulated) {
  if (!constraints.any())
    return "No constraint given; expected --at-most-us, --at-least-accuracy, --at-most-false-alarms-per-min, --at-most-delay-ms "
           "or --at-most-missed for a recommendation.";
  const std::string others =
      not_compared == 0
          ? ""
          : fmt::format(" {} settings with fewer trainings were not compared: their intervals are too narrow.", not_compared);
  double interrupted = 0;
  for (const results::TradeResult& figures : compared) {
    if (may_meet_on_an_idle_machine(constraints, figures)) interrupted = std::max(interrupted, figures.interrupted);
  }
  if (interrupted > 0)
    return fmt::format(
        "The machine was too busy to find a setting that gives {}: other programs interrupted up to {:.2g} % of the ticks of a "
        "setting. {}{}{}",
        text_of(constraints), 100 * interrupted, how_to_time_again, others, of_runs(simulated));
  return fmt::format("No measured setting gives {}, not even on the runs to choose on.{}{}", text_of(constraints), others,
                     of_runs(simulated));
}

}  // namespace tactile::trade
