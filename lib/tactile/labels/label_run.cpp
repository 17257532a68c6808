#include "tactile/labels/label_run.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tactile/core/sha256.hpp"
#include "tactile/robot/motion_phases.hpp"

namespace tactile {
namespace {

/// How well a burst's rate follows the lift's speed when their starts are laid over each other, -1 to 1: the correlation over
/// both lengths and a margin around them.
double likeness(const EventRate& rate, const QuietRate& quiet, const Burst& burst, const RobotLog& log, const MotionPhase& lift) {
  constexpr microseconds step = 4ms;
  constexpr microseconds margin = 150ms;
  const CameraTime burst_start = rate.begin_of(burst.begin);
  const microseconds length = std::max(between(burst_start, rate.begin_of(burst.end)), lift.end - lift.start);
  const auto bins_per_step = static_cast<std::size_t>(step / rate.bin);

  double n = 0, r_sum = 0, v_sum = 0, rr_sum = 0, vv_sum = 0, rv_sum = 0;
  auto row = log.states.begin();
  for (microseconds u = -margin; u <= length + margin; u += step) {
    while (row != log.states.end() && row->t < lift.start + u) ++row;
    const std::int64_t first_bin = between(rate.begin, after(burst_start, u)) / rate.bin;
    if (row == log.states.end() || first_bin < 0 || static_cast<std::size_t>(first_bin) + bins_per_step > rate.counts.size())
      continue;
    double count = 0;
    for (std::size_t i = 0; i < bins_per_step; ++i) count += rate.counts[static_cast<std::size_t>(first_bin) + i];
    // The square root tames the ringing, which is far above what the speed alone gives.
    const double r = std::sqrt(std::max(0.0, count - quiet.mean * static_cast<double>(bins_per_step)));
    const double v = std::hypot(row->tcp_speed[0], row->tcp_speed[1], row->tcp_speed[2]);
    n += 1;
    r_sum += r;
    v_sum += v;
    rr_sum += r * r;
    vv_sum += v * v;
    rv_sum += r * v;
  }
  const double spread = (n * rr_sum - r_sum * r_sum) * (n * vv_sum - v_sum * v_sum);
  const double correlation = spread > 0 ? (n * rv_sum - r_sum * v_sum) / std::sqrt(spread) : 0.0;
  const double burst_length = static_cast<double>(between(burst_start, rate.begin_of(burst.end)).count());
  const double lift_length = static_cast<double>((lift.end - lift.start).count());
  return correlation * std::min(burst_length, lift_length) / std::max(burst_length, lift_length);
}

/// The share of all bursts' events that are in none after this one, squared: after a slip the skin rests, and what follows it is
/// small.
double explained_by(std::size_t burst_index, const std::vector<Burst>& bursts) {
  double until = 0, all = 0;
  for (std::size_t i = 0; i < bursts.size(); ++i) {
    all += bursts[i].events;
    until += i <= burst_index ? bursts[i].events : 0.0;
  }
  const double share = all > 0 ? until / all : 1.0;
  return share * share;
}

struct LiftMatch {
  std::size_t burst_index = 0;
  double quality = 0;  ///< likeness times the share of events explained, squared
  double ratio = 0;    ///< to the second best
};

LiftMatch match_lift(const EventRate& rate, const QuietRate& quiet, const std::vector<Burst>& bursts, const RobotLog& log,
                     const MotionPhase& lift) {
  LiftMatch match{.burst_index = 0, .quality = -1, .ratio = 0};
  double second = 0;
  for (std::size_t i = 0; i < bursts.size(); ++i) {
    const double found = likeness(rate, quiet, bursts[i], log, lift) * explained_by(i, bursts);
    if (found > match.quality) {
      second = std::max(second, match.quality);
      match.burst_index = i;
      match.quality = found;
    } else {
      second = std::max(second, found);
    }
  }
  match.ratio = second > 0 ? match.quality / second : std::numeric_limits<double>::infinity();
  return match;
}

UncertainTime end_of(const EventRate& rate, const QuietRate& quiet, const Burst& burst, microseconds quiet_for,
                     const ActivityOptions& options) {
  const CameraTime end = std::min(rate.begin_of(first_quiet_bin(rate, quiet, burst.begin, quiet_for, options)), rate.last);
  // Motion fades into the noise: the marker still creeps when its events no longer stand out.
  return {end, before(end, 10ms), std::min(after(end, 20ms), CameraTime::max())};
}

LabelledInterval labelled(Touch touch, const UncertainTime& start, const UncertainTime& end) {
  return {.id = {},
          .touch = touch,
          .start = start,
          .end = end,
          .source = "events",
          .evidence = {.events = start.at, .robot = {}, .video = {}, .imu = {}},
          .confirmed = false};
}

/// The lift: of all phases the one that rises most.
std::optional<MotionPhase> lift_in(const RobotLog& log) {
  const std::vector<MotionPhase> phases = motion_phases(log);
  const auto highest = std::max_element(
      phases.begin(), phases.end(), [](const MotionPhase& a, const MotionPhase& b) { return a.height_change < b.height_change; });
  return highest == phases.end() || highest->height_change <= 0 ? std::nullopt : std::optional(*highest);
}

/// Where slip start and slip end put the robot's clock, apart by how much longer the slip is than the lift.
FittedClock clock_from(const LabelledInterval& slip, const MotionPhase& lift, const RobotLog& log) {
  constexpr double least_residual_us = 10'000.0;
  const std::int64_t start_offset = us_of(slip.start.at) - us_of(lift.start);
  const std::int64_t end_offset = us_of(slip.end.at) - us_of(lift.end);
  const double half_difference = static_cast<double>(start_offset - end_offset) / 2;
  return {.relation = {.offset_us = start_offset - std::llround(half_difference),
                       .drift_ppm = 0,
                       .reference_us = us_of(log.states.front().t)},
          .residual_us = std::max(least_residual_us, std::abs(half_difference)),
          .offset_low_us = std::min(start_offset, end_offset) - 20'000,
          .offset_high_us = std::max(start_offset, end_offset) + 20'000,
          .anchors = 2,
          .method = "lift start and end"};
}

/// The longest stretch without one event, if it is too long for chance.
std::optional<std::pair<CameraTime, microseconds>> gap_in(const EventRate& rate, const QuietRate& quiet, microseconds shortest) {
  constexpr double beyond_chance = 30.0;  // events missing: e^-30, and far less where noise comes in clumps of ten
  std::size_t best = 0, best_begin = 0, length = 0;
  for (std::size_t i = 0; i < rate.counts.size(); ++i) {
    length = rate.counts[i] == 0 ? length + 1 : 0;
    if (length > best) {
      best = length;
      best_begin = i + 1 - length;
    }
  }
  const microseconds silent = rate.bin * static_cast<std::int64_t>(best);
  if (silent < shortest || quiet.mean * static_cast<double>(best) < beyond_chance * quiet.dispersion) return std::nullopt;
  return std::pair(rate.begin_of(best_begin), silent);
}

void cut_overlaps(std::vector<LabelledInterval>& intervals) {
  for (std::size_t i = 0; i + 1 < intervals.size(); ++i) {
    UncertainTime& end = intervals[i].end;
    const CameraTime next = intervals[i + 1].start.at;
    end = {std::min(end.at, next), std::min(end.low, next), std::min(end.high, next)};
  }
}

nlohmann::json hashes_of_inputs(const RunFolder& run) {
  nlohmann::json hashes = {{"events.aedat4", sha256_of_file(run.events())}};
  if (std::filesystem::exists(run.robot())) hashes["robot.csv"] = sha256_of_file(run.robot());
  return hashes;
}

/// What was lost on its way to the file, where time of any length may lack its events. Elements that did not fit their stream
/// (`back_in_time`, `outside`) are no such loss.
std::vector<std::string> losses_in(const RunInfo& run) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 3> reasons{{{"queue_full", "the disk was too slow"},
                                                                                  {"unwritten", "the file could not be written"},
                                                                                  {"source", "the source lost them"}}};
  const nlohmann::json dropped = run.extra.value("dropped", nlohmann::json());
  const nlohmann::json by_reason = dropped.is_object() ? dropped.value("by_reason", nlohmann::json()) : nlohmann::json();
  std::vector<std::string> losses;
  for (const auto& [key, why] : reasons) {
    const nlohmann::json counts = by_reason.is_object() ? by_reason.value(key, nlohmann::json()) : nlohmann::json();
    const auto count = [&](const char* name) {
      const auto found = counts.is_object() ? counts.find(name) : counts.end();
      return found != counts.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
    };
    const std::uint64_t packets = count("packets"), events = count("events"), others = count("others");
    if (packets + events + others == 0) continue;
    losses.push_back(fmt::format("the recording lacks {} events, {} other elements and {} whole packets: {} (run.json: {})",
                                 events, others, packets, why, key));
  }
  return losses;
}

}  // namespace

nlohmann::json settings_of(const LabelOptions& options) {
  return {{"bin_us", options.rate.bin.count()},
          {"hot_pixel_hz", options.rate.hot_pixel_hz},
          {"smoothing_us", options.activity.smoothing.count()},
          {"enter", options.activity.enter},
          {"leave", options.activity.leave},
          {"merge_us", options.activity.merge.count()},
          {"shortest_us", options.activity.shortest.count()},
          {"onset_before_us", options.onset.before.count()},
          {"onset_after_us", options.onset.after.count()},
          {"onset_latency_us", options.onset.latency.count()},
          {"press_ends_us", options.press_ends.count()},
          {"slip_ends_us", options.slip_ends.count()},
          {"ambiguous_below", options.ambiguous_below},
          {"longest_disagreement_us", options.longest_disagreement.count()},
          {"shortest_gap_us", options.shortest_gap.count()}};
}

Labels label_run(const RunFolder& run, const LabelOptions& options) {
  RecordingReader recording(run.events());
  const EventRate rate = event_rate(recording, event_stream(recording).id, options.rate);
  const QuietRate quiet = quiet_rate(rate);
  const std::vector<Burst> bursts = bursts_in(rate, quiet, options.activity);
  const auto onset_of = [&](const Burst& burst) { return onset_near(rate, quiet, burst.begin, options.onset); };

  Labels labels;
  const auto flag = [&](std::string reason, std::optional<std::size_t> interval_index = std::nullopt) {
    labels.flags.push_back({.interval_index = interval_index, .reason = std::move(reason), .confirmed = false});
  };

  const RecordingProblems& problems = recording.problems();
  if (problems.truncated_bytes > 0)
    flag(fmt::format("the recording is cut off: {} bytes behind its last whole packet", problems.truncated_bytes));
  if (problems.broken_packets + problems.mismatched_packets > 0) {
    flag(fmt::format("{} packets of the recording cannot be read", problems.broken_packets + problems.mismatched_packets));
  }
  if (std::filesystem::exists(run.info())) {
    const RunInfo info = read_run_info(run);
    if (!info.complete) flag("run.json says that the recording was not completed");
    for (const std::string& loss : losses_in(info)) flag(loss);
  }
  if (const auto gap = gap_in(rate, quiet, options.shortest_gap)) {
    flag(fmt::format("the recording has a gap: no pixel fires for {} ms from {:.3f} s behind its first event on ({} us)",
                     gap->second.count() / 1000, 1e-6 * static_cast<double>(between(rate.begin, gap->first).count()),
                     us_of(gap->first)));
  }

  RobotLog log;
  std::optional<MotionPhase> lift;
  if (std::filesystem::exists(run.robot())) {
    const RobotLogFile file = read_robot_log(run.robot());
    log = file.longest();
    if (file.restarts() > 0) {
      flag(fmt::format("the robot's clock starts anew {} times within its log: {} rows of other clocks are not used",
                       file.restarts(), file.rows_elsewhere()));
    }
    if (!log.gaps.empty()) {
      const auto longest = std::max_element(log.gaps.begin(), log.gaps.end(), [](const RobotGap& a, const RobotGap& b) {
        return a.first_after - a.last_before < b.first_after - b.last_before;
      });
      const double at_s = 1e-6 * static_cast<double>((longest->last_before - log.states.front().t).count());
      flag(fmt::format(
          "the robot log has {} gap{}, the longest of {} ms, {:.3f} s behind its first row (at {:.3f} s of its clock)",
          log.gaps.size(), log.gaps.size() == 1 ? "" : "s", (longest->first_after - longest->last_before).count() / 1000, at_s,
          1e-6 * static_cast<double>(us_of(longest->last_before))));
    }
    if (file.cut_off) flag("the robot log is cut off in its last row");
    lift = lift_in(log);
    if (!lift) flag("the robot log has no lift: its TCP never moves upwards");
  } else {
    flag("no robot log: press and slip are told apart by their order alone");
  }

  std::optional<std::size_t> slip_burst;
  if (lift && !bursts.empty()) {
    const LiftMatch match = match_lift(rate, quiet, bursts, log, *lift);
    slip_burst = match.burst_index;
    if (match.ratio < options.ambiguous_below && bursts.size() > 1) {
      flag(
          fmt::format("which burst of events is the slip is uncertain: the best match with the lift is only {:.2f} times as good "
                      "as the second",
                      match.ratio));
    }
  } else if (!lift && bursts.size() > 1) {
    slip_burst = bursts.size() - 1;
  }

  for (std::size_t i = 0; i < (slip_burst ? *slip_burst : bursts.size()); ++i) {
    labels.intervals.push_back(
        labelled(Touch::press, onset_of(bursts[i]), end_of(rate, quiet, bursts[i], options.press_ends, options.activity)));
  }
  if (slip_burst) {
    const Burst& burst = bursts[*slip_burst];
    LabelledInterval slip =
        labelled(Touch::slip, onset_of(burst), end_of(rate, quiet, burst, options.slip_ends, options.activity));
    if (lift) {
      labels.robot_clocks = {clock_from(slip, *lift, log)};
      slip.evidence.robot = labels.robot_clocks.front().relation.camera_from(lift->start);
      const microseconds longer = between(slip.start.at, slip.end.at) - (lift->end - lift->start);
      if (std::chrono::abs(longer) > options.longest_disagreement) {
        flag(fmt::format("the slip lasts {} ms {} than the lift; expected at most {} ms between them",
                         std::abs(longer.count()) / 1000, longer > 0us ? "longer" : "less",
                         options.longest_disagreement.count() / 1000),
             labels.intervals.size());
      }
      // The last command ahead of the first press is the one that made it.
      for (const OutputChange& change : log.output_changes) {
        if (!(change.output.starts_with("digital output") && change.to == 1)) continue;
        const CameraTime command = labels.robot_clocks.front().relation.camera_from(change.at);
        if (!labels.intervals.empty() && command <= labels.intervals.front().start.at)
          labels.intervals.front().evidence.robot = command;
      }
    }
    labels.intervals.push_back(std::move(slip));
  }
  cut_overlaps(labels.intervals);
  name_intervals(labels.intervals);

  const auto has = [&](Touch touch) {
    return std::any_of(labels.intervals.begin(), labels.intervals.end(),
                       [&](const LabelledInterval& interval) { return interval.touch == touch; });
  };
  for (const Touch touch : {Touch::press, Touch::slip}) {
    if (!has(touch)) flag(fmt::format("no {} found: the event rate has no burst for it", name_of(touch)));
  }
  labels.provenance = {{"made_by", "tactile label"},
                       {"settings", settings_of(options)},
                       {"inputs", hashes_of_inputs(run)},
                       {"hot_pixels", rate.hot_pixels},
                       {"quiet_events_per_s", quiet.mean * 1e6 / static_cast<double>(rate.bin.count())}};
  return labels;
}

}  // namespace tactile
