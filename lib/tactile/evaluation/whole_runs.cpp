#include "tactile/evaluation/whole_runs.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/infinite.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/evaluation/detection_delay.hpp"

namespace tactile::evaluation {
namespace {

constexpr std::size_t fewest_worlds = 3;

bool are_worlds(std::span<const results::Cell> cells) {
  std::set<std::string_view> worlds;
  for (const results::Cell& cell : cells) worlds.insert(cell.world);
  return worlds.size() >= fewest_worlds;
}

/// The cells by what intervals are over. A world has trainings of its own: their effect is in that of the worlds.
std::vector<results::JudgedRun> units_of(std::span<const results::Cell> cells) {
  const bool by_world = are_worlds(cells);
  std::vector<results::JudgedRun> units;
  for (const results::Cell& cell : cells) {
    if (by_world) {
      units.push_back({cell.world, cell.object + "/" + cell.run + "#" + std::to_string(cell.training)});
    } else {
      units.push_back({cell.world + "/" + cell.object, cell.run, cell.training});
    }
  }
  return units;
}

/// Sums over cells.
struct Sums {
  double alarms = 0, outside_s = 0, in_alarm_s = 0, wrong = 0, lifts = 0, lifts_with_slip = 0, touches = 0, missed = 0,
         within_50_ms = 0;

  void add(const results::Cell& cell) {
    alarms += static_cast<double>(cell.alarm_count());
    outside_s += cell.outside_s;
    in_alarm_s += cell.in_alarm_s;
    wrong += static_cast<double>(cell.wrong_class);
    if (cell.false_slips) {
      ++lifts;
      lifts_with_slip += *cell.false_slips > 0 ? 1 : 0;
    }
    touches += static_cast<double>(cell.touches.size());
    for (const results::TouchOutcome& touch : cell.touches) {
      const bool is_detected = touch.outcome == results::DetectionOutcome::detected;
      missed += is_detected ? 0 : 1;
      within_50_ms += is_detected && cell.delay_ms(touch) <= 50 ? 1 : 0;
    }
  }
};

std::optional<double> ratio(double count, double of) { return of > 0 ? std::optional(count / of) : std::nullopt; }

/// Which delays: of all touches, of one class, or of slips from gross slip.
enum class Delay : std::uint8_t { all, press, slip, from_gross };

/// Makes the figures of some cells.
class Figures {
 public:
  /// @param options  nothing: no intervals
  Figures(std::span<const results::Cell> cells, const results::BootstrapOptions* options) : cells_(cells), options_(options) {
    const auto units = units_of(cells);
    const auto objects = results_by_object(std::span<const results::JudgedRun>(units), [](const auto&) { return true; });
    // Of one object, intervals are over its runs.
    is_one_object_ = objects.size() == 1;
    units_ = without_names(objects);
    for (const results::Cell& cell : cells) {
      for (const results::TouchOutcome& touch : cell.touches) {
        if (touch.outcome != results::DetectionOutcome::detected) longest_ms_ = std::max(longest_ms_, touch.ms);
      }
      sums_.add(cell);
    }
  }

  const Sums& sums() const { return sums_; }

  results::Figure of_sums(const std::function<std::optional<double>(const Sums&)>& value, const Range& range) const {
    return figure([&](const RunsByObject& drawn) { return value(sums_of(drawn)); }, range);
  }

  results::CensoredQuantile quantile(double q, Delay of) const {
    double shortest = infinite, longest = 0;  // of detected ones
    const auto see = [&](double ms) {
      if (ms == infinite) return;
      shortest = std::min(shortest, ms);
      longest = std::max(longest, ms);
    };
    for (const results::Cell& cell : cells_) for_each_delay(cell, of, see);
    longest = std::max(longest, longest_ms_);
    const auto at = [&](const RunsByObject& drawn) -> std::optional<double> {
      const auto ms = quantile_of(drawn, q, of);
      return ms ? std::optional(std::min(*ms, longest)) : std::nullopt;
    };
    const Range range = of == Delay::from_gross ? Range{.highest = std::max(longest, in_ms(DelayOptions{}.window))}
                                                : Range{.lowest = cells_.front().tick_ms,
                                                        .highest = std::max(longest, in_ms(DelayOptions{}.window)),
                                                        .step = shortest == infinite ? 0 : shortest};
    results::CensoredQuantile found{.ms = figure(at, range)};
    const auto of_all = quantile_of(all_of(units_), q, of);
    found.is_lower_bound = of_all && *of_all == infinite;
    if (found.is_lower_bound) found.ms.low = found.ms.high = std::nullopt;  // that of a limit says nothing of the delay
    return found;
  }

  /// What one more event changes of one result of `of` in the sum.
  double step(double of) const { return of > 0 ? static_cast<double>(result_count(units_)) / of : 0; }

  /// The exact interval of a count ends the interval of its rate, at least.
  void widen_by_count(results::Figure& per_min) const {
    if (!per_min.high || sums_.outside_s <= 0) return;
    const double each = most_results_of_a_run(units_);
    const auto count = static_cast<std::uint64_t>(std::ceil(sums_.alarms / each));
    per_min.high = std::max(*per_min.high, poisson_upper_bound(count, options_->confidence) / (sums_.outside_s / 60 / each));
  }

 private:
  template <class Use>
  void for_each(const RunsByObject& drawn, Use use) const {
    for (const auto& object : drawn) {
      for (const std::size_t i : object) use(cells_[i]);
    }
  }

  Sums sums_of(const RunsByObject& drawn) const {
    Sums sums;
    for_each(drawn, [&](const results::Cell& cell) { sums.add(cell); });
    return sums;
  }

  static std::optional<double> nearest_rank(std::vector<double>& values, double q) {
    if (values.empty()) return std::nullopt;
    const auto n = static_cast<double>(values.size());
    const auto rank = static_cast<std::ptrdiff_t>(std::max(1.0, std::ceil(q * n - 1e-9))) - 1;
    std::nth_element(values.begin(), values.begin() + rank, values.end());
    return values[static_cast<std::size_t>(rank)];
  }

  std::optional<double> quantile_of(const RunsByObject& drawn, double q, Delay of) const {
    std::vector<double> delays;
    for_each(drawn, [&](const results::Cell& cell) { for_each_delay(cell, of, [&](double ms) { delays.push_back(ms); }); });
    return nearest_rank(delays, q);
  }

  /// Touches that are not detected are later than all others: infinite.
  template <class Use>
  static void for_each_delay(const results::Cell& cell, Delay of, Use use) {
    for (const results::TouchOutcome& touch : cell.touches) {
      if ((of == Delay::press && touch.touch != Touch::press) || (of == Delay::slip && touch.touch != Touch::slip)) continue;
      if (of == Delay::from_gross && !touch.gross_ms) continue;
      use(touch.outcome != results::DetectionOutcome::detected ? infinite
          : of == Delay::from_gross                            ? *cell.gross_delay_ms(touch)
                                                               : cell.delay_ms(touch));
    }
  }

  results::Figure figure(const Statistic& statistic, const Range& range) const {
    if (options_ == nullptr) return {.value = statistic(all_of(units_)).value_or(std::numeric_limits<double>::quiet_NaN())};
    return is_one_object_ ? figure_of_object(units_.front(), statistic, *options_, range)
                          : figure_over_objects(units_, statistic, *options_, range);
  }

  std::span<const results::Cell> cells_;
  const results::BootstrapOptions* options_;
  CrossedResults units_;
  bool is_one_object_ = false;
  double longest_ms_ = 0;  // in which a touch that is not detected could be
  Sums sums_;
};

std::uint64_t in_whole(double count) { return static_cast<std::uint64_t>(std::llround(count)); }

void add_counts(results::OperatingPoint& point, std::span<const results::Cell> cells, const Sums& sums) {
  point.threshold = cells.front().threshold;
  point.alarms = in_whole(sums.alarms);
  point.outside_min = sums.outside_s / 60;
  point.in_alarm = ratio(sums.in_alarm_s, sums.outside_s).value_or(point.in_alarm);
  point.touches = in_whole(sums.touches);
  point.wrong_classes = in_whole(sums.wrong);
  point.lifts = in_whole(sums.lifts);
  point.lifts_with_slip = in_whole(sums.lifts_with_slip);
  for (const results::Cell& cell : cells) {
    for (const results::TouchOutcome& touch : cell.touches) {
      point.misses += touch.outcome == results::DetectionOutcome::missed ? 1 : 0;
      point.early += touch.outcome == results::DetectionOutcome::early ? 1 : 0;
    }
  }
}

results::OperatingPoint point_of(std::span<const results::Cell> cells, const results::BootstrapOptions* options) {
  const Figures figures(cells, options);
  const Sums& sums = figures.sums();
  results::OperatingPoint point;
  add_counts(point, cells, sums);
  point.alarms_per_min =
      figures.of_sums([](const Sums& of) { return ratio(60 * of.alarms, of.outside_s); },
                      {.lowest = 0, .highest = 60'000 / cells.front().tick_ms, .step = figures.step(sums.outside_s / 60)});
  if (options != nullptr) figures.widen_by_count(point.alarms_per_min);
  point.median_ms = figures.quantile(0.5, Delay::all);
  point.p90_ms = figures.quantile(0.9, Delay::all);
  point.press_median_ms = figures.quantile(0.5, Delay::press);
  point.press_p90_ms = figures.quantile(0.9, Delay::press);
  point.slip_median_ms = figures.quantile(0.5, Delay::slip);
  point.slip_p90_ms = figures.quantile(0.9, Delay::slip);
  point.gross_median_ms = figures.quantile(0.5, Delay::from_gross);
  const auto share = [&](double Sums::*count, double Sums::*of, double highest) {
    return figures.of_sums([=](const Sums& in) { return ratio(in.*count, in.*of); },
                           {.lowest = 0, .highest = highest, .step = figures.step(sums.*of)});
  };
  point.within_50_ms = share(&Sums::within_50_ms, &Sums::touches, 1);
  point.missed = share(&Sums::missed, &Sums::touches, 1);
  point.wrong_class = share(&Sums::wrong, &Sums::touches, infinite);
  point.false_slips = share(&Sums::lifts_with_slip, &Sums::lifts, 1);
  return point;
}

/// Cells of one answer with the same threshold; those of the verdicts as they were decided come first.
std::map<double, std::vector<results::Cell>> by_threshold(std::span<const results::Cell> cells, bool confirmed) {
  std::map<double, std::vector<results::Cell>> groups;
  for (const results::Cell& cell : cells) {
    if (cell.confirmed == confirmed) groups[cell.threshold.value_or(-infinite)].push_back(cell);
  }
  return groups;
}

}  // namespace

results::OperatingPoint operating_point(std::span<const results::Cell> cells, const results::BootstrapOptions& options) {
  return point_of(cells, &options);
}

results::OperatingPoint operating_values(std::span<const results::Cell> cells) { return point_of(cells, nullptr); }

results::WholeRuns whole_runs(std::span<const results::Cell> cells, unsigned threads, const results::BootstrapOptions& options) {
  results::WholeRuns whole;
  whole.units = are_worlds(cells) ? "worlds" : "objects";
  std::set<std::string> runs, by_truth;
  std::map<std::string, std::vector<results::Cell>> objects;
  const auto groups = by_threshold(cells, false), confirmed = by_threshold(cells, true);
  std::vector<std::function<void()>> figures;
  for (const auto& [threshold, group] : groups) {
    if (threshold != -infinite) {
      whole.curve.push_back(operating_values(group));
      continue;
    }
    for (const results::Cell& cell : group) {
      runs.insert(cell.object + "/" + cell.run);
      if (cell.by_truth) by_truth.insert(cell.object + "/" + cell.run);
      objects[cell.object].push_back(cell);
      for (const auto& [cause, alarms] : cell.alarms) whole.causes[cause] += alarms;
    }
    figures.emplace_back([&whole, &group = group, &options] { whole.decided = operating_point(group, options); });
  }
  whole.runs.assign(runs.begin(), runs.end());
  whole.by_truth.assign(by_truth.begin(), by_truth.end());
  for (const auto& [object, of_object] : objects) {
    figures.emplace_back(
        [&into = whole.objects[object], &of_object = of_object, &options] { into = operating_point(of_object, options); });
  }
  for (const double rate : calm_rates) {
    whole.calm.push_back({rate, std::nullopt});
    // Up to the first threshold, from above, that has more.
    const auto first_more = std::find_if(whole.curve.rbegin(), whole.curve.rend(), [rate](const results::OperatingPoint& point) {
      return !(point.alarms_per_min.value <= rate);
    });
    if (first_more == whole.curve.rbegin()) continue;
    whole.calm.back().point = *std::prev(first_more);
  }
  for (results::CalmPoint& calm : whole.calm) {
    if (calm.point) figures.emplace_back([&] { calm.point = operating_point(groups.at(*calm.point->threshold), options); });
  }
  for (const auto& [threshold, group] : confirmed) {
    if (threshold == -infinite) {
      figures.emplace_back([&whole, &group = group, &options] { whole.confirmed = operating_point(group, options); });
    } else {
      whole.confirmed_curve.push_back(operating_values(group));
    }
  }
  parallel_for(figures.size(), threads, [&](std::size_t i) { figures[i](); });
  return whole;
}

}  // namespace tactile::evaluation
