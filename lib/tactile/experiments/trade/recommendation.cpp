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

bool all_met(const TradeConstraints& constraints, const TradeFigures& figures,
             const std::function<bool(const results::Figure&, double, bool at_least)>& is_met) {
  return (!constraints.at_most_us || is_met(figures.us_p99, *constraints.at_most_us, false)) &&
         (!constraints.at_least_accuracy || is_met(figures.accuracy, *constraints.at_least_accuracy, true)) &&
         (!constraints.at_most_false_alarms_per_min ||
          is_met(figures.false_alarms_per_min, *constraints.at_most_false_alarms_per_min, false));
}

/// The distance of a figure from its limit, in halves of its interval; 0 without an interval.
double margin(const results::Figure& figure, double limit, bool at_least) {
  const std::optional<double>& bound = at_least ? figure.low : figure.high;
  if (!bound) return 0;
  const double room = std::abs(figure.value - limit), doubt = std::abs(figure.value - *bound);
  return doubt > 0 ? room / doubt : std::numeric_limits<double>::infinity();
}

/// The least margin over all constraints, for a setting whose values meet them.
double least_margin(const TradeConstraints& constraints, const TradeFigures& figures) {
  double least = std::numeric_limits<double>::infinity();
  all_met(constraints, figures, [&](const results::Figure& figure, double limit, bool at_least) {
    least = std::min(least, margin(figure, limit, at_least));
    return true;
  });
  return least;
}

std::string interval_text(const results::Figure& figure, double factor, const char* format_of, const char* unit) {
  if (!std::isfinite(figure.value)) return "unknown";
  const auto number = [&](double value) { return fmt::format(fmt::runtime(format_of), factor * value); };
  std::string text = number(figure.value) + unit;
  if (figure.has_interval()) return text + fmt::format(" [{}, {}]", number(*figure.low), number(*figure.high));
  return text + " (no interval)";
}

std::string measured_text(const TradeFigures& figures) {
  return fmt::format(
      "an accuracy of {}, a computing time of {} in 99 of 100 ticks ({} in half of them), a mean delay of {} and "
      "{} false alarms per minute",
      interval_text(figures.accuracy, 100, "{:.2f}", " %"), interval_text(figures.us_p99, 1, "{:.0f}", " us"),
      interval_text(figures.us_p50, 1, "{:.0f}", " us"), interval_text(figures.delay_us, 1e-3, "{:.2f}", " ms"),
      interval_text(figures.false_alarms_per_min, 1, "{:.2f}", ""));
}

}  // namespace

void to_json(nlohmann::json& json, const TradeConstraints& constraints) {
  const auto number = [](const std::optional<double>& value) { return value ? nlohmann::json(*value) : nlohmann::json(); };
  json = {{"at_most_us", number(constraints.at_most_us)},
          {"at_least_accuracy", number(constraints.at_least_accuracy)},
          {"at_most_false_alarms_per_min", number(constraints.at_most_false_alarms_per_min)}};
}

std::string text_of(const TradeConstraints& constraints) {
  std::vector<std::string> words;
  if (constraints.at_most_us) words.push_back(fmt::format("at most {:g} us a tick", *constraints.at_most_us));
  if (constraints.at_least_accuracy)
    words.push_back(fmt::format("an accuracy of at least {:g} %", 100 * *constraints.at_least_accuracy));
  if (constraints.at_most_false_alarms_per_min)
    words.push_back(fmt::format("at most {:g} false alarms per minute", *constraints.at_most_false_alarms_per_min));
  return words.empty() ? "no constraint" : fmt::format("{}", fmt::join(words, " and "));
}

bool keeps_up(const TradeFigures& figures) { return figures.us_p99.value <= figures.tick_us; }

bool meets(const TradeConstraints& constraints, const TradeFigures& figures) {
  return keeps_up(figures) && all_met(constraints, figures, [](const results::Figure& figure, double limit, bool at_least) {
           return at_least ? figure.value >= limit : figure.value <= limit;  // false for NaN
         });
}

bool meets_in_interval(const TradeConstraints& constraints, const TradeFigures& figures) {
  return meets(constraints, figures) &&
         all_met(constraints, figures, [](const results::Figure& figure, double limit, bool at_least) {
           const std::optional<double>& bound = at_least ? figure.low : figure.high;
           return bound && (at_least ? *bound >= limit : *bound <= limit);
         });
}

std::optional<TradeChoice> choose(const TradeConstraints& constraints, std::span<const TradeFigures> settings) {
  const bool prefers_speed = constraints.at_least_accuracy && !constraints.at_most_us;
  const auto rank = [&](const TradeFigures& figures) {
    const double accuracy = -figures.accuracy.value, us = figures.us_p99.value;
    return prefers_speed ? std::tuple(us, accuracy, figures.delay_us.value) : std::tuple(accuracy, figures.delay_us.value, us);
  };
  for (const bool in_interval : {true, false}) {
    const auto goes_first = [&](const TradeFigures& a, const TradeFigures& b) {
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

Recommendation recommend(const TradeConstraints& constraints, const std::optional<std::string>& setting,
                         const TradeFigures& again, bool simulated) {
  Recommendation recommendation{.setting = setting, .met = false, .sentence = {}};
  const std::string of_runs = simulated ? " On simulated runs, which say nothing about real ones." : "";
  if (!constraints.any()) {
    recommendation.sentence =
        "No constraint given; expected --at-most-us, --at-least-accuracy or --at-most-false-alarms-per-min for a recommendation.";
  } else if (!setting) {
    recommendation.sentence =
        fmt::format("No measured setting gives {}, not even on the runs to choose on.{}", text_of(constraints), of_runs);
  } else if (meets_in_interval(constraints, again)) {
    recommendation.met = true;
    recommendation.sentence = fmt::format("For {} use {}. Measured again, on runs that it was not chosen on, it has {}.{}",
                                          text_of(constraints), *setting, measured_text(again), of_runs);
  } else {
    recommendation.sentence = fmt::format(
        "The setting chosen for {}, {}, is not confirmed. Measured again, on runs that it was not chosen on, it has {}. The "
        "whole 95 % interval must meet the constraints. No other setting is tried on these runs: the best of many tries proves "
        "nothing.{}",
        text_of(constraints), *setting, measured_text(again), of_runs);
  }
  return recommendation;
}

}  // namespace tactile::trade
