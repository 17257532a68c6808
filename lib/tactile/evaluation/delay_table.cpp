#include "tactile/evaluation/delay_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/infinite.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/evaluation/detection_delay.hpp"

namespace tactile::evaluation {
namespace {

bool is_detected(const results::TouchOutcome& touch) { return touch.outcome == results::DetectionOutcome::detected; }

/// Calls `use` with the delay of each touch, or how long it could be, and whether it is detected.
template <class Use>
void for_each_time(const results::Cell& cell, Delay of, Use use) {
  for (const results::TouchOutcome& touch : cell.touches) {
    if ((of == Delay::press && touch.touch != Touch::press) || (of == Delay::slip && touch.touch != Touch::slip)) continue;
    if (of == Delay::from_gross && !touch.gross_ms) continue;
    use(of == Delay::from_gross ? *cell.gross_delay_ms(touch) : cell.delay_ms(touch), is_detected(touch));
  }
}

/// Calls `use` with the delay of each touch; that of one that is not detected is infinite.
template <class Use>
void for_each_delay(const results::Cell& cell, Delay of, Use use) {
  for_each_time(cell, of, [&](double ms, bool detected) { use(detected ? ms : infinite); });
}

Delay delay_of(Touch touch) { return touch == Touch::press ? Delay::press : Delay::slip; }

/// Of the detected touches [ms].
std::vector<double> detected_delays(std::span<const results::Cell> cells, const RunsByObject& drawn, Touch touch) {
  std::vector<double> delays;
  for (const std::vector<std::size_t>& unit : drawn) {
    for (const std::size_t i : unit) {
      for_each_delay(cells[i], delay_of(touch), [&](double ms) {
        if (ms != infinite) delays.push_back(ms);
      });
    }
  }
  return delays;
}

double mean_of(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// The mean over trainings: those that are judged on the same touches do not count them more than once.
double standard_error_of(std::span<const results::Cell> cells, const RunsByObject& chosen, Touch touch) {
  std::map<std::size_t, RunsByObject> of_trainings;
  for (const std::vector<std::size_t>& unit : chosen) {
    for (const std::size_t i : unit) of_trainings[cells[i].training].push_back({i});
  }
  std::vector<double> errors;
  for (const auto& of_training : of_trainings) {
    const std::vector<double> delays = detected_delays(cells, of_training.second, touch);
    if (delays.size() < 2) continue;
    const double mean = mean_of(delays);
    double squares = 0;
    for (const double delay : delays) squares += (delay - mean) * (delay - mean);
    const auto n = static_cast<double>(delays.size());
    errors.push_back(std::sqrt(squares / (n - 1) / n));
  }
  return mean_of(errors);
}

/// The shortest delay of detected touches, and the longest that touches have, or could have had.
struct Span {
  double shortest = infinite, longest = -infinite;

  Span(std::span<const results::Cell> cells, const RunsByObject& chosen, Delay of) {
    for (const std::vector<std::size_t>& unit : chosen) {
      for (const std::size_t i : unit) {
        for_each_time(cells[i], of, [&](double ms, bool detected) {
          if (detected) shortest = std::min(shortest, ms);
          longest = std::max(longest, ms);
        });
      }
    }
  }

  Range range(double lowest) const {
    return {.lowest = lowest,
            .highest = std::max(longest, in_ms(DelayOptions{}.window)),
            .step = shortest == infinite || lowest == -infinite ? 0 : shortest};
  }
};

results::DelaySummary summary_of(std::span<const results::Cell> cells, const RunFigures& figures, Touch touch) {
  results::DelaySummary summary;
  const RunsByObject chosen = all_of(figures.units());
  for (const std::vector<std::size_t>& unit : chosen) {
    for (const std::size_t i : unit) {
      for (const results::TouchOutcome& one : cells[i].touches) {
        if (one.touch != touch) continue;
        ++summary.intervals;
        summary.misses += one.outcome == results::DetectionOutcome::missed ? 1 : 0;
        summary.early += one.outcome == results::DetectionOutcome::early ? 1 : 0;
      }
    }
  }
  summary.sem_ms = standard_error_of(cells, chosen, touch);
  const Range range = Span(cells, chosen, delay_of(touch)).range(0);
  const auto of_detected = [&](double (*value)(std::span<const double>)) {
    return figures.of_all(
        [&, value](const RunsByObject& drawn) -> std::optional<double> {
          const std::vector<double> delays = detected_delays(cells, drawn, touch);
          return delays.empty() ? std::nullopt : std::optional(value(delays));
        },
        range);
  };
  summary.mean_ms = of_detected(mean_of);
  summary.median_ms = of_detected([](std::span<const double> delays) { return quantile(delays, 0.5); });
  const auto share_missed = [&](const RunsByObject& drawn) -> std::optional<double> {
    double missed = 0, touches = 0;
    for (const std::vector<std::size_t>& unit : drawn) {
      for (const std::size_t i : unit) {
        for (const results::TouchOutcome& one : cells[i].touches) {
          touches += one.touch == touch ? 1 : 0;
          missed += one.touch == touch && one.outcome == results::DetectionOutcome::missed ? 1 : 0;
        }
      }
    }
    return touches > 0 ? std::optional(missed / touches) : std::nullopt;
  };
  const double one_touch = static_cast<double>(result_count(figures.units())) / static_cast<double>(summary.intervals);
  summary.missed = figures.of_all(share_missed, {0, 1, one_touch});
  summary.median_of_all_ms = delay_quantile(cells, figures, 0.5, delay_of(touch));
  summary.quantile_of_all_ms = delay_quantile(cells, figures, 0.9, delay_of(touch));
  return summary;
}

}  // namespace

results::CensoredQuantile delay_quantile(std::span<const results::Cell> cells, const RunFigures& figures, double q, Delay of) {
  const RunsByObject all = all_of(figures.units());
  const Span span(cells, all, of);
  const auto raw = [&](const RunsByObject& drawn) -> std::optional<double> {
    std::vector<double> delays;
    for (const std::vector<std::size_t>& unit : drawn) {
      for (const std::size_t i : unit) for_each_delay(cells[i], of, [&](double ms) { delays.push_back(ms); });
    }
    return delays.empty() ? std::nullopt : std::optional(nearest_rank_quantile(delays, q));
  };
  const Range range = span.range(of == Delay::from_gross ? -infinite : cells.empty() ? 0 : cells.front().tick_ms);
  results::CensoredQuantile found{.ms = figures.of_all(
                                      [&](const RunsByObject& drawn) -> std::optional<double> {
                                        const auto ms = raw(drawn);
                                        return ms ? std::optional(std::min(*ms, span.longest)) : std::nullopt;
                                      },
                                      range)};
  const auto of_all = raw(all);
  found.is_lower_bound = of_all && *of_all == infinite;
  if (found.is_lower_bound) found.ms.low = found.ms.high = std::nullopt;  // that of a limit says nothing of the delay
  return found;
}

results::DelayTable delay_table(std::span<const results::Cell> cells, Touch touch, const results::BootstrapOptions& options) {
  const auto has_one = [touch](const results::Cell& cell) {
    return std::any_of(cell.touches.begin(), cell.touches.end(),
                       [touch](const results::TouchOutcome& one) { return one.touch == touch; });
  };
  results::DelayTable table;
  for (const std::string& object : objects_of(cells, has_one)) {
    const RunFigures of_object(cells, &options,
                               [&](const results::Cell& cell) { return has_one(cell) && cell.object == object; });
    table.objects[object] = summary_of(cells, of_object, touch);
  }
  table.all = summary_of(cells, RunFigures(cells, &options, has_one), touch);
  return table;
}

}  // namespace tactile::evaluation
