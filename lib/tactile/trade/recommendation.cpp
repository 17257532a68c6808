#include "tactile/trade/recommendation.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>
#include <vector>

namespace tactile {
namespace {

bool all_met(const TradeWish& wish, const TradeFigures& figures,
             const std::function<bool(const Figure&, double, bool at_least)>& is_met) {
  return (!wish.at_most_us || is_met(figures.us_p99, *wish.at_most_us, false)) &&
         (!wish.at_least_accuracy || is_met(figures.accuracy, *wish.at_least_accuracy, true)) &&
         (!wish.at_most_false_alarms_per_min || is_met(figures.false_alarms_per_min, *wish.at_most_false_alarms_per_min, false));
}

/// How far a figure is on the right side of its limit, in halves of its interval; 0 where there is none.
double margin(const Figure& figure, double limit, bool at_least) {
  const std::optional<double>& bound = at_least ? figure.low : figure.high;
  if (!bound) return 0;
  const double room = std::abs(figure.value - limit), doubt = std::abs(figure.value - *bound);
  return doubt > 0 ? room / doubt : std::numeric_limits<double>::infinity();
}

/// The least margin of all that is wished, by a setting whose values meet it.
double least_margin(const TradeWish& wish, const TradeFigures& figures) {
  double least = std::numeric_limits<double>::infinity();
  all_met(wish, figures, [&](const Figure& figure, double limit, bool at_least) {
    least = std::min(least, margin(figure, limit, at_least));
    return true;
  });
  return least;
}

std::string interval_text(const Figure& figure, double factor, const char* format_of, const char* unit) {
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

void to_json(nlohmann::json& json, const TradeWish& wish) {
  const auto number = [](const std::optional<double>& value) { return value ? nlohmann::json(*value) : nlohmann::json(); };
  json = {{"at_most_us", number(wish.at_most_us)},
          {"at_least_accuracy", number(wish.at_least_accuracy)},
          {"at_most_false_alarms_per_min", number(wish.at_most_false_alarms_per_min)}};
}

std::string text_of(const TradeWish& wish) {
  std::vector<std::string> words;
  if (wish.at_most_us) words.push_back(fmt::format("at most {:g} us a tick", *wish.at_most_us));
  if (wish.at_least_accuracy) words.push_back(fmt::format("an accuracy of at least {:g} %", 100 * *wish.at_least_accuracy));
  if (wish.at_most_false_alarms_per_min)
    words.push_back(fmt::format("at most {:g} false alarms per minute", *wish.at_most_false_alarms_per_min));
  return words.empty() ? "nothing" : fmt::format("{}", fmt::join(words, " and "));
}

bool keeps_up(const TradeFigures& figures) { return figures.us_p99.value <= figures.tick_us; }

bool meets(const TradeWish& wish, const TradeFigures& figures) {
  return keeps_up(figures) && all_met(wish, figures, [](const Figure& figure, double limit, bool at_least) {
           return at_least ? figure.value >= limit : figure.value <= limit;  // neither of NaN
         });
}

bool meets_in_interval(const TradeWish& wish, const TradeFigures& figures) {
  return meets(wish, figures) && all_met(wish, figures, [](const Figure& figure, double limit, bool at_least) {
           const std::optional<double>& bound = at_least ? figure.low : figure.high;
           return bound && (at_least ? *bound >= limit : *bound <= limit);
         });
}

std::optional<TradeChoice> choose(const TradeWish& wish, std::span<const TradeFigures> settings) {
  const bool wants_fast = wish.at_least_accuracy && !wish.at_most_us;
  const auto rank = [&](const TradeFigures& figures) {
    const double accuracy = -figures.accuracy.value, us = figures.us_p99.value;
    return wants_fast ? std::tuple(us, accuracy, figures.delay_us.value) : std::tuple(accuracy, figures.delay_us.value, us);
  };
  for (const bool in_interval : {true, false}) {
    const auto goes_first = [&](const TradeFigures& a, const TradeFigures& b) {
      const double doubt_a = in_interval ? 0 : -least_margin(wish, a), doubt_b = in_interval ? 0 : -least_margin(wish, b);
      return doubt_a != doubt_b ? doubt_a < doubt_b : rank(a) < rank(b);
    };
    std::optional<TradeChoice> best;
    for (std::size_t i = 0; i < settings.size(); ++i) {
      if (!std::isfinite(settings[i].accuracy.value) || !std::isfinite(settings[i].us_p99.value)) continue;
      if (!(in_interval ? meets_in_interval(wish, settings[i]) : meets(wish, settings[i]))) continue;
      if (!best || goes_first(settings[i], settings[best->index])) best = TradeChoice{i, in_interval};
    }
    if (best) return best;
  }
  return std::nullopt;
}

Recommendation recommend(const TradeWish& wish, const std::optional<std::string>& setting, const TradeFigures& again,
                         bool simulated) {
  Recommendation recommendation{.setting = setting, .met = false, .sentence = {}};
  const std::string of_runs = simulated ? " On simulated runs, which say nothing about real ones." : "";
  if (!wish.any()) {
    recommendation.sentence =
        "No wish was stated; expected --at-most-us, --at-least-accuracy or --at-most-false-alarms-per-min for a recommendation.";
  } else if (!setting) {
    recommendation.sentence =
        fmt::format("No setting that was measured gives {}, already on the runs to choose on.{}", text_of(wish), of_runs);
  } else if (meets_in_interval(wish, again)) {
    recommendation.met = true;
    recommendation.sentence = fmt::format("For {} take {}: measured again on runs that it was not chosen on it has {}.{}",
                                          text_of(wish), *setting, measured_text(again), of_runs);
  } else {
    recommendation.sentence = fmt::format(
        "The setting chosen for {}, {}, does not surely give it: measured again on runs that it was not chosen on it has {}, and "
        "all of the 95 % interval must meet the wish. No other was tried on them, for the best of many tries proves nothing.{}",
        text_of(wish), *setting, measured_text(again), of_runs);
  }
  return recommendation;
}

}  // namespace tactile
