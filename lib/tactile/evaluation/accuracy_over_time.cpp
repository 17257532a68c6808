#include "tactile/evaluation/accuracy_over_time.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <optional>

#include "tactile/core/error.hpp"
#include "tactile/evaluation/accuracy.hpp"

namespace tactile::evaluation {
namespace {

/// What of a run's counts is meant.
using Part = std::function<TickCount(const OverTimeOfRun&)>;

TickCount& operator+=(TickCount& a, const TickCount& b) {
  a.ticks += b.ticks;
  a.right += b.right;
  a.intervals += b.intervals;
  return a;
}

/// Counts ticks of one interval at a time, so that it knows how many intervals have one.
void count(TickCount& counts, bool right, bool& seen) {
  ++counts.ticks;
  counts.right += right ? 1 : 0;
  counts.intervals += seen ? 0 : 1;
  seen = true;
}

TickCount sum_of(std::span<const RunOverTime> runs, std::span<const std::size_t> chosen, const Part& part) {
  TickCount sum;
  for (const std::size_t i : chosen) sum += part(runs[i].counts);
  return sum;
}

std::optional<double> share_of(const TickCount& counts) {
  if (counts.ticks == 0) return std::nullopt;
  return static_cast<double>(counts.right) / static_cast<double>(counts.ticks);
}

Statistic mean_share(std::span<const RunOverTime> runs, const Part& part) {
  return mean_over_objects(
      [runs, part](std::span<const std::size_t> of_object) { return share_of(sum_of(runs, of_object, part)); });
}

Statistic mean_difference(std::span<const RunOverTime> runs, const Part& a, const Part& b) {
  return mean_over_objects([runs, a, b](std::span<const std::size_t> of_object) -> std::optional<double> {
    const auto first = share_of(sum_of(runs, of_object, a)), second = share_of(sum_of(runs, of_object, b));
    if (!first || !second) return std::nullopt;
    return *second - *first;
  });
}

/// The runs in which the part has a tick, by object; n of a figure counts no others.
std::map<std::string, CrossedObject> runs_with(std::span<const RunOverTime> runs, const Part& part) {
  return results_by_object(runs, [&](const RunOverTime& run) { return part(run.counts).ticks > 0; });
}

/// [0, 1], in steps of one tick of a run.
Range range_of_shares(std::span<const RunOverTime> runs, const Part& part) {
  double ticks = 0, with_ticks = 0;
  for (const RunOverTime& run : runs) {
    const TickCount counts = part(run.counts);
    ticks += static_cast<double>(counts.ticks);
    with_ticks += counts.ticks > 0 ? 1 : 0;
  }
  return {0, 1, ticks > 0 ? with_ticks / ticks : 0};
}

/// The parts of intervals whose shares are reported.
struct Parts {
  Part first, later, last, last_of_long, before_last, after;
};

/// Ticks not right of those that there are.
Part wrong_of(const Part& part) {
  return [part](const OverTimeOfRun& run) {
    TickCount count = part(run);
    count.right = count.ticks - count.right;
    return count;
  };
}

template <class MakeFigure>
results::ShareOverTime shares_of(std::span<const RunOverTime> runs, std::span<const std::size_t> counted, const Parts& parts,
                                 MakeFigure figure) {
  const auto share = [&](const Part& part) { return figure(part, mean_share(runs, part), range_of_shares(runs, part)); };
  const std::uint64_t intervals = sum_of(runs, counted, parts.last).intervals;
  return {share(parts.first),
          share(parts.later),
          share(parts.last),
          share(parts.before_last),
          figure(parts.before_last, mean_difference(runs, parts.before_last, parts.last_of_long),
                 {-1, 1, range_of_shares(runs, parts.last_of_long).step}),
          share(wrong_of(parts.after)),
          intervals,
          intervals - sum_of(runs, counted, parts.before_last).intervals};
}

results::AccuracyOverTime accuracy_of_touches(std::span<const RunOverTime> runs, const std::vector<Touch>& touches,
                                              const results::OverTimeOptions& options,
                                              const results::BootstrapOptions& bootstrap) {
  // The part is named of one class's counts; classes that count together are summed.
  const auto part = [&touches](std::function<TickCount(const OverTimeCounts&)> of_class) -> Part {
    return [&touches, of_class = std::move(of_class)](const OverTimeOfRun& run) {
      TickCount sum;
      for (const Touch touch : touches) sum += of_class(run[static_cast<std::size_t>(touch)]);
      return sum;
    };
  };
  const Parts parts{part([](const OverTimeCounts& counts) { return counts.first; }),
                    part([](const OverTimeCounts& counts) { return counts.later; }),
                    part([](const OverTimeCounts& counts) { return counts.last; }),
                    part([](const OverTimeCounts& counts) { return counts.last_of_long; }),
                    part([](const OverTimeCounts& counts) { return counts.before_last; }),
                    part([](const OverTimeCounts& counts) { return counts.after; })};

  results::AccuracyOverTime accuracy;
  std::vector<std::size_t> every_run(runs.size());
  std::iota(every_run.begin(), every_run.end(), std::size_t{0});
  accuracy.all = shares_of(runs, every_run, parts, [&](const Part& of, const Statistic& statistic, const Range& range) {
    return figure_over_objects(without_names(runs_with(runs, of)), statistic, bootstrap, range);
  });
  for (const auto& object : runs_with(runs, parts.first)) {
    accuracy.objects[object.first] =
        shares_of(runs, indexes_of(object.second), parts, [&](const Part& of, const Statistic& statistic, const Range& range) {
          const auto with = runs_with(runs, of);
          const auto found = with.find(object.first);
          return found == with.end() ? results::Figure{} : figure_of_object(found->second, statistic, bootstrap, range);
        });
  }

  const auto curve = [&](std::vector<TickCount> OverTimeCounts::*bins) {
    std::vector<results::OverTimeBin> curve_bins;
    const auto longest = static_cast<std::size_t>(options.longest / options.bin);
    for (std::size_t i = 0; i < longest; ++i) {
      const Part of_bin =
          part([bins, i](const OverTimeCounts& counts) { return i < (counts.*bins).size() ? (counts.*bins)[i] : TickCount{}; });
      results::OverTimeBin bin{
          options.bin * static_cast<std::int64_t>(i), options.bin * static_cast<std::int64_t>(i + 1), {}, 0, 0};
      const CrossedResults with = without_names(runs_with(runs, of_bin));
      for (const auto& object : all_of(with)) {
        const TickCount counts = sum_of(runs, object, of_bin);
        bin.ticks += counts.ticks;
        bin.intervals += counts.intervals;
      }
      bin.accuracy = figure_over_objects(with, mean_share(runs, of_bin), bootstrap, range_of_shares(runs, of_bin));
      curve_bins.push_back(bin);
    }
    while (!curve_bins.empty() && curve_bins.back().ticks == 0) curve_bins.pop_back();
    return curve_bins;
  };
  accuracy.since_onset = curve(&OverTimeCounts::since_onset);
  accuracy.before_end = curve(&OverTimeCounts::before_end);
  return accuracy;
}

}  // namespace

OverTimeOfRun over_time_of(const TickRange& ticks, std::span<const Touch> verdicts, std::span<const TouchInterval> intervals,
                           const results::OverTimeOptions& options, std::span<const TouchInterval> elsewhere) {
  if (static_cast<std::int64_t>(verdicts.size()) != ticks.count) {
    throw Error("accuracy over time: " + std::to_string(verdicts.size()) + " verdicts for " + std::to_string(ticks.count) +
                " ticks; expected one for each");
  }
  const auto bins = static_cast<std::size_t>(options.longest / options.bin);
  OverTimeOfRun run;
  for (const TouchInterval& interval : intervals) {
    OverTimeCounts& counts = run[static_cast<std::size_t>(interval.touch)];
    bool in_first = false, in_later = false, in_last = false, in_last_of_long = false, in_before_last = false, in_after = false;
    const auto is_ahead_of_last = [&](CameraTime t) { return interval.contains(t) && between(t, interval.end) >= options.last; };
    bool is_long = false;
    for (std::int64_t k = 0; k < ticks.count && !is_long; ++k) is_long = is_ahead_of_last(ticks.at(k));
    std::vector<bool> in_since(bins), in_before(bins);
    const auto count_in = [&](std::vector<TickCount>& curve, std::vector<bool>& seen_in, std::int64_t place, bool right) {
      if (place < 0 || place >= static_cast<std::int64_t>(bins)) return;
      const auto bin = static_cast<std::size_t>(place);
      if (curve.size() <= bin) curve.resize(bin + 1);
      bool seen = seen_in[bin];
      count(curve[bin], right, seen);
      seen_in[bin] = seen;
    };
    for (std::int64_t k = 0; k < ticks.count; ++k) {
      const CameraTime t = ticks.at(k);
      const auto holds_it = [t](const TouchInterval& other) { return other.contains(t); };
      if (t > interval.end && t <= after(interval.end, options.after) &&
          std::none_of(intervals.begin(), intervals.end(), holds_it) &&
          std::none_of(elsewhere.begin(), elsewhere.end(), holds_it))
        count(counts.after, verdicts[static_cast<std::size_t>(k)] == Touch::none, in_after);
      if (!interval.contains(t)) continue;
      const bool right = verdicts[static_cast<std::size_t>(k)] == interval.touch;
      const microseconds since = between(interval.start, t), left = between(t, interval.end);
      count(since <= options.first ? counts.first : counts.later, right, since <= options.first ? in_first : in_later);
      if (left < options.last) count(counts.last, right, in_last);
      if (is_long && left < options.last) count(counts.last_of_long, right, in_last_of_long);
      if (left >= options.last) count(counts.before_last, right, in_before_last);
      count_in(counts.since_onset, in_since, (since - microseconds{1}) / options.bin, right);
      count_in(counts.before_end, in_before, left / options.bin, right);
    }
  }
  for (OverTimeCounts& counts : run) counts.since_onset.shrink_to_fit(), counts.before_end.shrink_to_fit();
  return run;
}

results::OverTime accuracy_over_time(std::span<const RunOverTime> runs, const results::OverTimeOptions& options,
                                     const results::BootstrapOptions& bootstrap) {
  return {options, accuracy_of_touches(runs, {Touch::press}, options, bootstrap),
          accuracy_of_touches(runs, {Touch::slip}, options, bootstrap),
          accuracy_of_touches(runs, {Touch::press, Touch::slip}, options, bootstrap)};
}

}  // namespace tactile::evaluation
