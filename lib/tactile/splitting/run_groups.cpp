#include "tactile/splitting/run_groups.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <span>
#include <utility>

#include "tactile/alignment/felt_moves.hpp"
#include "tactile/labels/brightening.hpp"

namespace tactile::splitting {
namespace {

using alignment::Burst;
using alignment::EventRate;
using Bursts = std::vector<Burst>;

/// Divides bursts where they are quiet for `quiet_bins`. A group of slow rises alone joins the nearer neighbour.
RunGroups divided(const EventRate& rate, const Bursts& all, std::size_t quiet_bins) {
  RunGroups groups;
  for (const Burst& burst : all) {
    if (!burst.slow && alignment::is_after_effect(burst, rate, all)) {
      groups.brief.push_back(burst);
    } else if (groups.runs.empty() || burst.begin - std::min(burst.begin, groups.runs.back().bursts.back().end) >= quiet_bins) {
      groups.runs.push_back({.bursts = {burst}, .kinds = {}});
    } else {
      groups.runs.back().bursts.push_back(burst);
    }
  }
  const auto is_slow = [](const RunGroup& run) {
    return std::all_of(run.bursts.begin(), run.bursts.end(), [](const Burst& b) { return b.slow; });
  };
  for (std::size_t i = 0; i < groups.runs.size();) {
    if (!is_slow(groups.runs[i]) || groups.runs.size() == 1) {
      ++i;
      continue;
    }
    const Bursts& slow = groups.runs[i].bursts;
    const bool joins_next =
        i == 0 || (i + 1 < groups.runs.size() && groups.runs[i + 1].bursts.front().begin - slow.back().end <
                                                     slow.front().begin - groups.runs[i - 1].bursts.back().end);
    Bursts& other = groups.runs[joins_next ? i + 1 : i - 1].bursts;
    other.insert(joins_next ? other.begin() : other.end(), slow.begin(), slow.end());
    groups.runs.erase(groups.runs.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return groups;
}

/// The lift of a run by the IMU, if it shows one: the last motion that it felt during a burst that may be a slip. A camera on the
/// stage also feels the press.
std::optional<std::vector<ArmMove>> felt_lift(std::span<const events::ImuSample> imu, const EventRate& rate, const Bursts& run,
                                              std::span<const double> undoes) {
  constexpr microseconds around = 1s;
  const auto at = [&](CameraTime t) {
    return std::lower_bound(imu.begin(), imu.end(), t, [](const events::ImuSample& s, CameraTime time) { return s.t < time; });
  };
  const std::span<const events::ImuSample> samples(at(before(rate.begin_of(run.front().begin), around)),
                                                   at(after(rate.begin_of(run.back().end), around)));
  std::vector<alignment::CameraSpan> moves = alignment::felt_moves(samples);
  std::reverse(moves.begin(), moves.end());
  for (const alignment::CameraSpan& felt : moves) {
    const ArmMove move{.start = felt.begin, .end = felt.end, .uncertainty = 30ms};
    for (std::size_t i = 1; i < run.size(); ++i) {
      const bool may_slip = undoes[i] <= TouchesOptions{}.releases && !alignment::is_after_effect(run[i], rate, run);
      if (may_slip && move_around({move}, rate, run[i]) != nullptr) return std::vector{move};
    }
  }
  return std::nullopt;
}

/// Whether the last touch of a run is a press: the object is still held.
bool ends_in_press(const RunGroup& run) {
  const auto last = std::find_if(run.kinds.rbegin(), run.kinds.rend(), [](BurstKind kind) {
    return kind == BurstKind::press || kind == BurstKind::slip || kind == BurstKind::release;
  });
  return last != run.kinds.rend() && *last == BurstKind::press;
}

/// Classifies the bursts of runs, and joins runs whose press continues.
class Grouping {
 public:
  Grouping(events::RecordingReader& recording, std::int32_t stream, const EventRate& rate, const LongActivity& activity,
           const DeviceClockSearch& robot, std::vector<RunGroup> runs)
      : rate_(rate), activity_(activity), robot_(robot) {
    Bursts all;
    for (const RunGroup& run : runs) all.insert(all.end(), run.bursts.begin(), run.bursts.end());
    std::vector<labels::Brightening> changes = labels::brightenings_of(recording, stream, rate, all);
    if (!robot.lifts) imu_ = imu_of(recording, stream);
    auto next = changes.begin();
    for (RunGroup& group : runs) {
      Run& run = runs_.emplace_back(Run{.group = std::move(group), .changes = {}});
      for (std::size_t i = 0; i < run.group.bursts.size(); ++i) run.changes.push_back(std::move(*next++));
      classify(run);
    }
  }

  void join_holds() {
    for (std::size_t i = 0; i + 1 < runs_.size();) {
      if (ends_in_press(runs_[i].group) && was_seen_between(runs_[i].group, runs_[i + 1].group) && !begins_with_press(i + 1)) {
        Run& run = runs_[i];
        Run& next = runs_[i + 1];
        run.group.bursts.insert(run.group.bursts.end(), next.group.bursts.begin(), next.group.bursts.end());
        std::move(next.changes.begin(), next.changes.end(), std::back_inserter(run.changes));
        runs_.erase(runs_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
        classify(run);
      } else {
        ++i;
      }
    }
  }

  std::vector<RunGroup> runs() const {
    std::vector<RunGroup> all;
    for (const Run& run : runs_) all.push_back(run.group);
    return all;
  }

 private:
  struct Run {
    RunGroup group;
    std::vector<labels::Brightening> changes;  ///< of each burst
  };

  void classify(Run& run) const {
    RunGroup& group = run.group;
    std::vector<double> undoes;  // how far it reverses all before it
    labels::Brightening so_far(run.changes.front().size());
    for (const labels::Brightening& change : run.changes) {
      undoes.push_back(-labels::correlation_of(change, so_far));
      labels::add(so_far, change);
    }
    const auto lifts = robot_.lifts ? robot_.lifts : felt_lift(imu_, rate_, group.bursts, undoes);
    group.kinds = kinds_of(rate_, group.bursts, lifts, robot_.taps.value_or(std::vector<ArmMove>()), undoes);
  }

  /// What the first burst of a run changes; a slow one only if there is no other.
  static const labels::Brightening& first_change(const Run& run) {
    const Bursts& bursts = run.group.bursts;
    const auto first = std::find_if(bursts.begin(), bursts.end(), [](const Burst& burst) { return !burst.slow; });
    return run.changes[first == bursts.end() ? 0 : static_cast<std::size_t>(first - bursts.begin())];
  }

  /// Whether a run begins as a press does: it changes the picture as the run before it did, or as the start of the next run that
  /// ends in no press, or of the last one before it.
  bool begins_with_press(std::size_t index) const {
    const labels::Brightening& change = first_change(runs_[index]);
    const auto is_like = [&](const labels::Brightening& press) {
      return labels::correlation_of(change, press) > TouchesOptions{}.deepens;
    };
    labels::Brightening before(change.size());
    for (const labels::Brightening& part : runs_[index - 1].changes) labels::add(before, part);
    if (is_like(before)) return true;
    for (std::size_t i = index + 1; i < runs_.size(); ++i) {
      if (!ends_in_press(runs_[i].group)) return is_like(first_change(runs_[i]));
    }
    for (std::size_t i = index - 1; i-- > 0;) {
      if (!ends_in_press(runs_[i].group)) return is_like(first_change(runs_[i]));
    }
    return false;
  }

  /// Whether the time between two runs was recorded. Noise shows it: only a pause has no events, unless the sensor is silent.
  bool was_seen_between(const RunGroup& first, const RunGroup& second) const {
    constexpr double surely_some = 20;  // events: a Poisson process has none with a probability of 2e-9
    const std::size_t begin = first.bursts.back().end, end = second.bursts.front().begin;
    return std::none_of(activity_.pauses.begin(), activity_.pauses.end(), [&](const Burst& pause) {
      const std::size_t from = std::max(pause.begin, begin), until = std::min(pause.end, end);
      return from < until && activity_.quiet.mean * static_cast<double>(until - from) > surely_some;
    });
  }

  std::vector<Run> runs_;
  const EventRate& rate_;
  const LongActivity& activity_;
  const DeviceClockSearch& robot_;
  std::vector<events::ImuSample> imu_;
};

}  // namespace

RunGroups grouped_runs(events::RecordingReader& recording, std::int32_t stream, const EventRate& rate, const Bursts& all,
                       const LongActivity& activity, std::size_t quiet_bins, const DeviceClockSearch& robot) {
  RunGroups groups = divided(rate, all, quiet_bins);
  Grouping grouping(recording, stream, rate, activity, robot, std::move(groups.runs));
  grouping.join_holds();
  groups.runs = grouping.runs();
  return groups;
}

}  // namespace tactile::splitting
