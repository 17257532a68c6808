#include "tactile/evaluation/whole_runs.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "tactile/core/infinite.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/evaluation/delay_table.hpp"
#include "tactile/evaluation/run_figures.hpp"

namespace tactile::evaluation {
namespace {

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

/// Makes the figures of some cells.
class Figures {
 public:
  /// @param options  null: no intervals
  Figures(std::span<const results::Cell> cells, const results::BootstrapOptions* options)
      : cells_(cells), options_(options), figures_(cells, options, [](const results::Cell&) { return true; }) {
    for (const results::Cell& cell : cells) sums_.add(cell);
  }

  const Sums& sums() const { return sums_; }

  results::Figure of_sums(const std::function<std::optional<double>(const Sums&)>& value, const Range& range) const {
    return figures_.of_all(
        [&](const RunsByObject& drawn) {
          Sums sums;
          for (const std::vector<std::size_t>& unit : drawn) {
            for (const std::size_t i : unit) sums.add(cells_[i]);
          }
          return value(sums);
        },
        range);
  }

  results::CensoredQuantile quantile(double q, Delay of) const { return delay_quantile(cells_, figures_, q, of); }

  /// What one more event changes of one result of `of` in the sum.
  double step(double of) const { return of > 0 ? static_cast<double>(result_count(figures_.units())) / of : 0; }

  /// The exact interval of a count ends the interval of its rate, at least.
  void widen_by_count(results::Figure& per_min) const {
    if (options_ == nullptr || !per_min.high || sums_.outside_s <= 0) return;
    const double each = most_results_of_a_run(figures_.units());
    const auto count = static_cast<std::uint64_t>(std::ceil(sums_.alarms / each));
    per_min.high = std::max(*per_min.high, poisson_upper_bound(count, options_->confidence) / (sums_.outside_s / 60 / each));
  }

 private:
  std::span<const results::Cell> cells_;
  const results::BootstrapOptions* options_;
  RunFigures figures_;
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
  figures.widen_by_count(point.alarms_per_min);
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
  if (!cells.front().confirmed) point.wrong_class = share(&Sums::wrong, &Sums::touches, infinite);
  point.false_slips = share(&Sums::lifts_with_slip, &Sums::lifts, 1);
  return point;
}

/// Cells of one answer with the same threshold; those of the verdicts as they were decided come first, under `as_decided`.
using Groups = std::map<double, std::vector<results::Cell>>;
constexpr double as_decided = -infinite;

Groups by_threshold(std::span<const results::Cell> cells, bool confirmed) {
  Groups groups;
  for (const results::Cell& cell : cells) {
    if (cell.confirmed == confirmed) groups[cell.threshold.value_or(as_decided)].push_back(cell);
  }
  return groups;
}

std::vector<results::OperatingPoint> curve_of(const Groups& groups) {
  std::vector<results::OperatingPoint> curve;
  for (const auto& [threshold, group] : groups) {
    if (threshold != as_decided) curve.push_back(operating_values(group));
  }
  return curve;
}

/// Without intervals. A threshold that detects nothing is no answer.
std::vector<results::CalmPoint> calm_points(std::span<const results::OperatingPoint> curve) {
  std::vector<results::CalmPoint> all;
  for (const double rate : calm_rates) {
    all.push_back({rate, std::nullopt});
    // Up to the first threshold, from above, that has more.
    const auto first_more = std::find_if(curve.rbegin(), curve.rend(), [rate](const results::OperatingPoint& point) {
      return !(point.alarms_per_min.value <= rate);
    });
    if (first_more == curve.rbegin()) continue;
    const results::OperatingPoint& lowest = *std::prev(first_more);
    if (lowest.touches == 0 || lowest.misses + lowest.early < lowest.touches) all.back().point = lowest;
  }
  return all;
}

using Work = std::vector<std::function<void()>>;

/// To make each of the points again, with intervals.
void add_intervals(Work& work, std::vector<results::CalmPoint>& calm, const Groups& groups,
                   const results::BootstrapOptions& options) {
  for (results::CalmPoint& one : calm) {
    if (one.point) work.emplace_back([&] { one.point = operating_point(groups.at(*one.point->threshold), options); });
  }
}

}  // namespace

results::OperatingPoint operating_point(std::span<const results::Cell> cells, const results::BootstrapOptions& options) {
  return point_of(cells, &options);
}

results::OperatingPoint operating_values(std::span<const results::Cell> cells) { return point_of(cells, nullptr); }

results::WholeRuns whole_runs(std::span<const results::Cell> cells, unsigned threads, const results::BootstrapOptions& options) {
  results::WholeRuns whole;
  whole.units = RunFigures(cells, nullptr, [](const results::Cell&) { return true; }).unit_name();
  const bool is_one_world =
      std::all_of(cells.begin(), cells.end(), [&](const results::Cell& cell) { return cell.world == cells.front().world; });
  std::set<std::string> runs, by_truth;
  std::map<std::string, std::vector<results::Cell>> objects;
  const Groups groups = by_threshold(cells, false), confirmed = by_threshold(cells, true);
  Work figures;
  if (const auto decided = groups.find(as_decided); decided != groups.end()) {
    for (const results::Cell& cell : decided->second) {
      const std::string name = (is_one_world ? "" : cell.world + "/") + cell.object + "/" + cell.run;
      runs.insert(name);
      if (cell.by_truth) by_truth.insert(name);
      objects[cell.object].push_back(cell);
      for (const auto& [cause, alarms] : cell.alarms) whole.causes[cause] += alarms;
    }
    figures.emplace_back([&whole, &group = decided->second, &options] { whole.decided = operating_point(group, options); });
  }
  whole.runs.assign(runs.begin(), runs.end());
  whole.by_truth.assign(by_truth.begin(), by_truth.end());
  for (const auto& [object, of_object] : objects) {
    figures.emplace_back(
        [&into = whole.objects[object], &of_object = of_object, &options] { into = operating_point(of_object, options); });
  }
  whole.curve = curve_of(groups);
  whole.calm = calm_points(whole.curve);
  add_intervals(figures, whole.calm, groups, options);
  whole.confirmed_curve = curve_of(confirmed);
  if (const auto decided = confirmed.find(as_decided); decided != confirmed.end())
    figures.emplace_back([&whole, &group = decided->second, &options] { whole.confirmed = operating_point(group, options); });
  parallel_for(figures.size(), threads, [&](std::size_t i) { figures[i](); });
  return whole;
}

results::Baseline baseline_of(std::span<const results::Cell> cells, unsigned threads, const results::BootstrapOptions& options) {
  const Groups groups = by_threshold(cells, false);
  results::Baseline baseline{.decided = {}, .calm = calm_points(curve_of(groups))};
  Work figures{[&] { baseline.decided = operating_point(groups.at(as_decided), options); }};
  add_intervals(figures, baseline.calm, groups, options);
  parallel_for(figures.size(), threads, [&](std::size_t i) { figures[i](); });
  return baseline;
}

}  // namespace tactile::evaluation
