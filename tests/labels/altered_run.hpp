#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "support/events_in_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/labels/label_run.hpp"
#include "tactile/labels/truth_comparison.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/simulation/simulate.hpp"

namespace tactile::test {

/// The physics of a plain run: one press and one slip, no stage command, no inertial sensor, clocks of its own.
inline simulation::SimulationPhysics plain_physics() {
  simulation::SimulationPhysics physics = simulation::default_physics();
  physics.clocks.shared_session_share = 0;
  physics.imu.share = 0;
  physics.variation.stage_output_share = 0;
  return physics;
}

/// Runs of one special kind alone, such as `only_runs(&SpecialRuns::two_presses)`.
inline simulation::SimulationPhysics only_runs(double simulation::SpecialRuns::*kind) {
  simulation::SimulationPhysics physics = plain_physics();
  physics.special_runs = {.from_run = 1, .two_presses = 0, .without_slip = 0, .without_press = 0, .firm_lifts = 0, .taps = 0};
  physics.special_runs.*kind = 1;
  for (auto& [name, preset] : physics.presets) preset.special_runs = true;
  return physics;
}

/// A simulated run whose files are then altered, and what truly happened in it.
class AlteredRun {
 public:
  explicit AlteredRun(const simulation::SimulationPhysics& physics = plain_physics(), const std::string& object = "fan",
                      std::uint64_t seed = 1, const std::string& preset = "tiny") {
    simulation::simulate(
        {.data = data_.path(), .preset = preset, .runs = 1, .objects = {object}, .seed = seed, .threads = 1, .physics = physics});
    run = find_runs(data_.path()).at(0);
    truth = read_truth(run.truth());
  }

  labels::Labels labels() const { return labels::label_run(run); }

  /// The first true interval of this kind, such as "press" or "slip".
  TouchInterval truly(const std::string& what) const {
    const auto found = std::find_if(truth.intervals.begin(), truth.intervals.end(),
                                    [&](const TrueInterval& interval) { return interval.what == what; });
    if (found == truth.intervals.end()) throw Error("the run has no " + what);
    return found->interval;
  }
  RobotTime in_robot_time(CameraTime t) const { return RobotTime{microseconds{truth.robot_clock->clock_us_from(t)}}; }

  void alter_recording(const std::function<void(std::vector<events::Event>&, std::vector<events::ImuSample>&)>& alter) {
    std::vector<events::Event> events = events_in_file(run.events());
    std::vector<events::ImuSample> imu;
    std::vector<events::Stream> streams;
    {
      events::RecordingReader recording(run.events());
      streams.assign(recording.streams().begin(), recording.streams().end());
      for (const events::PacketRecord& packet : recording.packets()) {
        if (recording.stream(packet.stream_id).type != events::StreamType::imu) continue;
        const std::vector<events::ImuSample> samples = recording.read_imu(packet);
        imu.insert(imu.end(), samples.begin(), samples.end());
      }
    }
    alter(events, imu);
    std::filesystem::remove(run.events());
    events::RecordingWriter writer(run.events(), streams);
    for (const events::Stream& stream : streams) {
      if (stream.type == events::StreamType::events) writer.write_events(stream.id, events);
      if (stream.type == events::StreamType::imu) writer.write_imu(stream.id, imu);
    }
    writer.close();
  }

  void alter_robot(const std::function<void(std::vector<robot::RobotState>&)>& alter) {
    robot::RobotLog log = robot::read_robot_log(run.robot()).longest();
    alter(log.states);
    std::filesystem::remove(run.robot());
    robot::write_robot_log(run.robot(), log);
  }

  RunFolder run;
  Truth truth;

 private:
  TemporaryFolder data_;
};

/// All that the labels say, for a test that fails.
inline std::string told_by(const labels::Labels& labels) {
  std::string text = "\n";
  for (const labels::LabelledInterval& i : labels.intervals)
    text += i.id + " from " + std::to_string(us_of(i.start.at)) + " (-" + std::to_string(us_of(i.start.at) - us_of(i.start.low)) +
            ", +" + std::to_string(us_of(i.start.high) - us_of(i.start.at)) + ") to " + std::to_string(us_of(i.end.at)) + " us\n";
  for (const labels::LabelFlag& flag : labels.flags) {
    const std::string of = flag.interval_index ? labels.intervals.at(*flag.interval_index).id : "run";
    text += "flag on " + of + ": " + flag.reason + "\n";
  }
  for (const alignment::FittedClock& clock : labels.robot_clocks)
    text += "robot clock by " + clock.method + ", to " + std::to_string(clock.uncertainty().count()) + " us\n";
  if (labels.video_clock) text += "video clock by " + labels.video_clock->method + "\n";
  for (const std::string& remark : labels.remarks) text += "remark: " + remark + "\n";
  return text;
}

inline bool flags_say(const labels::Labels& labels, const std::string& words) {
  return std::any_of(labels.flags.begin(), labels.flags.end(),
                     [&](const labels::LabelFlag& flag) { return flag.reason.find(words) != std::string::npos; });
}

inline bool remarks_say(const labels::Labels& labels, const std::string& words) {
  return std::any_of(labels.remarks.begin(), labels.remarks.end(),
                     [&](const std::string& remark) { return remark.find(words) != std::string::npos; });
}

/// Labels are those of the truth and no more; each onset lies within 4 ms (press) or 6 ms (slip), or else the truth in its 95 %
/// interval; and within 20 ms, unless it is flagged.
inline void expect_as_true(const labels::Labels& labels, const Truth& truth) {
  const labels::TruthComparison compared = labels::compare_with_truth(labels, truth);
  EXPECT_TRUE(compared.spurious.empty()) << told_by(labels);
  for (const labels::IntervalComparison& interval : compared.intervals) {
    const std::string what(name_of(interval.touch));
    if (!interval.start) {
      ADD_FAILURE() << "no " << what << " found" << told_by(labels);
      continue;
    }
    const microseconds error = std::chrono::abs(interval.start->error);
    EXPECT_TRUE(error <= (interval.touch == Touch::press ? 4ms : 6ms) || interval.start->covered)
        << what << ", off by " << interval.start->error.count() << " us" << told_by(labels);
    EXPECT_TRUE(error <= 20ms || interval.flagged) << what << ", off by " << error.count() << " us" << told_by(labels);
  }
}

/// Where the lift starts the robot's clock is off by 10 ms at most, or else the truth lies in its 95 % interval.
inline void expect_lift_as_true(const labels::Labels& labels, const AlteredRun& altered) {
  const labels::TruthComparison compared = labels::compare_with_truth(labels, altered.truth);
  ASSERT_TRUE(compared.robot_clock.has_value()) << told_by(labels);
  EXPECT_TRUE(compared.robot_clock->covered || std::chrono::abs(compared.robot_clock->error) <= 10ms)
      << compared.robot_clock->error.count() << " us" << told_by(labels);
}

}  // namespace tactile::test
