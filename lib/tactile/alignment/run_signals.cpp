#include "tactile/alignment/run_signals.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>
#include <utility>

#include "tactile/core/doubt.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/video/video_times.hpp"

namespace tactile::alignment {
namespace {

std::string in_seconds(std::int64_t us) { return fmt::format("{:.3f} s", 1e-6 * static_cast<double>(us)); }

/// Losses before the file: any time may lack its events. Elements that did not fit their stream (`back_in_time`, `outside`) are
/// no such loss.
std::vector<Doubt> losses_in(const RunInfo& run) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 3> reasons{{{"queue_full", "the disk was too slow"},
                                                                                  {"unwritten", "the file could not be written"},
                                                                                  {"source", "the source lost them"}}};
  const nlohmann::json dropped = run.extra.value("dropped", nlohmann::json());
  const nlohmann::json by_reason = dropped.is_object() ? dropped.value("by_reason", nlohmann::json()) : nlohmann::json();
  std::vector<Doubt> losses;
  for (const auto& [key, why] : reasons) {
    const nlohmann::json counts = by_reason.is_object() ? by_reason.value(key, nlohmann::json()) : nlohmann::json();
    const auto count = [&](const char* name) {
      const auto found = counts.is_object() ? counts.find(name) : counts.end();
      return found != counts.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
    };
    const std::uint64_t packets = count("packets"), events = count("events"), others = count("others");
    if (packets + events + others == 0) continue;
    losses.push_back(doubt(fmt::format("lost-{}", key),
                           "the recording lacks {} events, {} other elements and {} whole packets: {} (run.json: {})", events,
                           others, packets, why, key));
  }
  return losses;
}

void read_recording(RunSignals& signals, const RunSignalsOptions& options) {
  events::RecordingReader recording(signals.run.events());
  signals.event_stream = events::event_stream(recording).id;
  signals.rate = event_rate(recording, signals.event_stream, options.rate);
  signals.quiet = quiet_rate(signals.rate);
  for (const events::PacketRecord& packet : recording.packets()) {
    if (recording.stream(packet.stream_id).type != events::StreamType::imu) continue;
    const std::vector<events::ImuSample> samples = recording.read_imu(packet);
    signals.imu.insert(signals.imu.end(), samples.begin(), samples.end());
  }
  std::stable_sort(signals.imu.begin(), signals.imu.end(),
                   [](const events::ImuSample& a, const events::ImuSample& b) { return a.t < b.t; });

  const events::RecordingProblems& problems = recording.problems();
  if (problems.truncated_bytes > 0)
    signals.problems.push_back(
        doubt("recording-cut-off", "the recording is cut off: {} bytes after its last whole packet", problems.truncated_bytes));
  if (const auto unread = problems.broken_packets + problems.mismatched_packets; unread > 0)
    signals.problems.push_back(doubt("packets-unread", "{} packets of the recording cannot be read", unread));
  if (signals.rate.saturated_bins > 0) {
    signals.problems.push_back(doubt(
        "read-outs-full", "{} read-outs of the recording are full: events were lost in them, and the highest rates are not known",
        signals.rate.saturated_bins));
  }
  if (signals.rate.flicker_hz)
    signals.problems.push_back(
        doubt("flicker", "the light flickers at {:.0f} Hz: its events hide touches", *signals.rate.flicker_hz));
  signals.gaps = gaps_in(signals.rate, signals.quiet, options.shortest_gap);
  const auto longest = std::max_element(signals.gaps.begin(), signals.gaps.end(), [](const CameraSpan& a, const CameraSpan& b) {
    return between(a.begin, a.end) < between(b.begin, b.end);
  });
  if (longest != signals.gaps.end()) {
    signals.problems.push_back(doubt(
        "recording-gap", "the recording has a gap: no pixel fires for {} ms, from {} after its first event on",
        between(longest->begin, longest->end).count() / 1000, in_seconds(between(signals.rate.begin, longest->begin).count())));
  }
}

/// How far the camera's clock is ahead of the host's, by the packet that arrived fastest.
std::optional<std::int64_t> camera_ahead_of_host(const std::vector<CameraArrival>& arrivals) {
  std::optional<std::int64_t> ahead;
  for (const CameraArrival& arrival : arrivals) {
    const std::int64_t us = saturating_subtract(us_of(arrival.camera), us_of(arrival.host));
    ahead = std::max(ahead.value_or(us), us);
  }
  return ahead;
}

/// How far the host's clock is ahead of the robot's; nothing if the log has no host times.
std::optional<std::int64_t> host_ahead_of_robot(const RunInfo& run, const robot::RobotLog& log) {
  if (run.extra.value("robot_clock", nlohmann::json()) == "host") return 0;
  std::optional<std::int64_t> ahead;
  for (const robot::RobotState& state : log.states) {
    if (!state.host_time) continue;
    const std::int64_t us = saturating_subtract(us_of(*state.host_time), us_of(state.t));
    ahead = std::min(ahead.value_or(us), us);
  }
  return ahead;
}

/// Data arrive late by some ms, in bursts more, and clocks drift: the content decides within this.
constexpr microseconds host_times_within = 100ms;

std::optional<CoarseOffset> coarse_offset(const RunSignals& signals, const robot::RobotLog& log) {
  const auto camera = camera_ahead_of_host(signals.host_from_camera), host = host_ahead_of_robot(signals.info, log);
  if (!camera || !host) return std::nullopt;
  return CoarseOffset{.offset_us = saturating_add(*camera, *host), .within = host_times_within};
}

void read_robot(RunSignals& signals, const robot::RobotLogOptions& options) {
  signals.has_robot = true;
  robot::RobotLogFile file = robot::read_robot_log(signals.run.robot(), options);
  signals.speed_from = file.speed_from;
  signals.arm = file.arm;
  if (robot::is_target(file.speed_from)) {
    signals.remarks.push_back(
        fmt::format("the robot log has no actual_ column: motions are the commanded ones of {}", name_of(file.speed_from)));
  }
  if (file.arm)
    signals.remarks.push_back(fmt::format("poses follow from the robot's joints by the kinematics of a {}", name_of(*file.arm)));
  std::size_t mixed_rows = 0;
  for (const robot::RobotLog& log : file.pieces) mixed_rows += log.mixed_rows;
  if (mixed_rows > 0) {
    signals.remarks.push_back(fmt::format("{} of the robot log's rows {} two packages, and {} left out or repaired", mixed_rows,
                                          mixed_rows == 1 ? "mixes" : "mix", mixed_rows == 1 ? "was" : "were"));
  }
  for (robot::RobotLog& log : file.pieces) {
    if (!log.gaps.empty()) {
      const auto longest =
          std::max_element(log.gaps.begin(), log.gaps.end(), [](const robot::RobotGap& a, const robot::RobotGap& b) {
            return a.first_after - a.last_before < b.first_after - b.last_before;
          });
      signals.problems.push_back(
          doubt("robot-log-gap", "the robot log has {} gap{}, the longest of {} ms, {} after its first row (at {} of its clock)",
                log.gaps.size(), log.gaps.size() == 1 ? "" : "s", (longest->first_after - longest->last_before).count() / 1000,
                in_seconds((longest->last_before - log.states.front().t).count()), in_seconds(us_of(longest->last_before))));
    }
    if (are_too_far_apart(signals.rate.begin, log.states.front().t)) {
      signals.problems.push_back(
          doubt("clocks-apart", "the robot log is left out: the two clocks lie further apart than 64 bits of microseconds"));
      continue;
    }
    signals.coarse_offsets.push_back(coarse_offset(signals, log));
    signals.robot.push_back(std::move(log));
  }
  if (signals.robot.empty()) signals.problems.push_back(doubt("robot-log-empty", "the robot log has no row"));
  if (signals.robot.size() > 1)
    signals.problems.push_back(doubt("robot-clock-restarts", "the robot's clock restarts {} time{} within its log",
                                     signals.robot.size() - 1, signals.robot.size() == 2 ? "" : "s"));
  if (file.cut_off) signals.problems.push_back(doubt("robot-log-cut-off", "the robot log is cut off in its last row"));
}

}  // namespace

bool are_too_far_apart(CameraTime camera, RobotTime robot) {
  const std::int64_t apart_us = saturating_subtract(us_of(camera), us_of(robot));
  return apart_us == std::numeric_limits<std::int64_t>::max() || apart_us == std::numeric_limits<std::int64_t>::min();
}

std::vector<CameraArrival> arrivals_in(const RunInfo& run) {
  const nlohmann::json pairs = run.extra.value("host_from_camera", nlohmann::json());
  std::vector<CameraArrival> arrivals;
  if (!pairs.is_array()) return arrivals;
  for (const nlohmann::json& pair : pairs) {
    if (!pair.is_array() || pair.size() != 2 || !pair[0].is_number_integer() || !pair[1].is_number_integer()) continue;
    arrivals.push_back({camera_time(pair[0].get<std::int64_t>()), HostTime{microseconds{pair[1].get<std::int64_t>()}}});
  }
  return arrivals;
}

RunSignals read_run_signals(const RunFolder& run, const RunSignalsOptions& options) {
  RunSignals signals;
  signals.run = run;
  signals.info.object = run.object;
  signals.info.run = run.run;
  signals.info.complete = true;
  read_recording(signals, options);
  if (std::filesystem::exists(run.info())) {
    signals.info = read_run_info(run);
    if (!signals.info.complete)
      signals.problems.push_back(doubt("run-incomplete", "run.json says that the recording was not completed"));
    for (Doubt& loss : losses_in(signals.info)) signals.problems.push_back(std::move(loss));
  }
  signals.info.simulated = events::is_simulated(run);
  signals.host_from_camera = arrivals_in(signals.info);
  if (std::filesystem::exists(run.robot())) read_robot(signals, options.robot);
  if (std::filesystem::exists(run.video())) {
    try {
      const std::vector<VideoTime> times =
          std::filesystem::exists(run.video_times()) ? video::read_video_times(run.video_times()) : std::vector<VideoTime>();
      signals.video = motion_energy(run.video(), times, options.video);
      if (const std::size_t lost = signals.video->rows_without_frame; lost > 0)
        signals.problems.push_back(
            doubt("film-lacks-frames", "the film lacks {} of the {} frames of video.csv", lost, times.size()));
    } catch (const OutsideFilm&) {
      throw;  // the requested part of the film does not exist
    } catch (const Error& e) {
      std::string why = e.what();
      if (const std::string folder = run.folder.string() + "/"; why.starts_with(folder)) why.erase(0, folder.size());
      signals.problems.push_back(doubt("film-unusable", "the film cannot be used: {}", why));
    }
  } else {
    signals.remarks.emplace_back("no film");
  }
  return signals;
}

nlohmann::json hashes_of_inputs(const RunFolder& run) {
  nlohmann::json hashes = nlohmann::json::object();
  for (const std::filesystem::path& file : {run.events(), run.robot(), run.video(), run.video_times(), run.info()}) {
    if (std::filesystem::exists(file)) hashes[file.filename().string()] = sha256_of_file(file);
  }
  return hashes;
}

}  // namespace tactile::alignment
