#include "tactile/capture/simulator_source.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "capture/received.hpp"
#include "support/events_in_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/truth.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/simulation/simulate.hpp"
#include "tactile/video/video_times.hpp"

namespace tactile::capture {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

RunFolder make_run(const fs::path& data, const std::string& object, const std::string& run) {
  const RunFolder folder{data / object / run, object, run};
  fs::create_directories(folder.folder);
  return folder;
}

/// Records a run as far as `part` of its events, and lets the source write the rest.
std::vector<events::Event> record(CameraSource& source, const RunFolder& run, double part, bool robot = true,
                                  bool video = false) {
  source.begin_run(run);
  std::vector<events::Event> events = test::receive_all(source).streams[0].events;
  events.resize(static_cast<std::size_t>(part * static_cast<double>(events.size())));
  events::RecordingWriter writer(run.events(), {source.streams().begin(), source.streams().end()});
  writer.write_events(0, events);
  writer.close();
  source.end_run(run, robot, video);
  return events;
}

std::vector<TrueInterval> labelled_in(const RunFolder& run) {
  std::vector<TrueInterval> labelled = read_truth(run.truth()).intervals;
  std::erase_if(labelled, [](const TrueInterval& interval) { return !interval.labelled; });
  return labelled;
}

TEST(SimulatorSource, FeelsWhatTheInertialSensorFeels) {
  const test::TemporaryFolder folder;
  const auto source = open_simulator_source("sim:fan", "fan", 0, 3);
  ASSERT_EQ(source->streams().size(), 2U);
  source->begin_run(make_run(folder.path(), "fan", "01"));
  test::Received all = test::receive_all(*source);
  const std::vector<events::Event>& events = all.streams[0].events;
  const std::vector<events::ImuSample>& imu = all.streams[1].imu;
  const double seconds = 1e-6 * static_cast<double>((events.back().t - events.front().t).count());
  EXPECT_NEAR(static_cast<double>(imu.size()), 800 * seconds, 40 * seconds);
  EXPECT_LE(all.longest_packet, 20ms);
  CameraTime newest{};
  for (const CameraTime begin : all.begins) {
    EXPECT_GE(begin + 20ms, newest) << "both streams come side by side";
    newest = std::max(newest, begin);
  }
  EXPECT_EQ(all.begins.front(), std::min(events.front().t, imu.front().t)) << "a duration counts from the earliest";
}

TEST(SimulatorSource, GivesTheRunThatSimulateMakes) {
  const test::TemporaryFolder folder;
  simulation::simulate({.data = folder / "made", .preset = "quick", .runs = 1, .objects = {"fan"}, .seed = 3, .threads = 1});
  const RunFolder made{folder / "made" / "fan" / "01", "fan", "01"};
  const auto source = open_simulator_source("sim:fan", "fan", 0, 3);
  EXPECT_TRUE(source->simulated());
  EXPECT_FALSE(source->live());
  const RunFolder run = make_run(folder / "live", "fan", "01");
  record(*source, run, 1.0, true, true);
  EXPECT_EQ(test::events_in_file(run.events()), test::events_in_file(made.events()));
  EXPECT_EQ(read_text(run.truth()), read_text(made.truth()));
  EXPECT_EQ(read_text(run.robot()), read_text(made.robot()));
  EXPECT_EQ(read_text(run.video_times()), read_text(made.video_times()));
  EXPECT_EQ(read_text(run.video()), read_text(made.video()));
  EXPECT_EQ(source->camera().at("source"), read_run_info(made).extra.at("camera").at("source"));
  EXPECT_EQ(source->camera().at("readout_mode"), "variable");
}

TEST(SimulatorSource, WritesTruthAndDevicesOfThePartThatWasRecorded) {
  const test::TemporaryFolder folder;
  const auto source = open_simulator_source("sim", "water-bottle", 0, 1);
  const RunFolder whole = make_run(folder.path(), "water-bottle", "01");
  record(*source, whole, 1.0, true, true);
  const std::vector<TrueInterval> all = labelled_in(whole);
  ASSERT_EQ(all.size(), 2U);

  // The same run once more from a source of its own, cut in the middle of its slip.
  const auto again = open_simulator_source("sim", "water-bottle", 0, 1);
  const RunFolder cut = make_run(folder / "cut", "water-bottle", "01");
  const std::vector<events::Event> events = test::events_in_file(whole.events());
  const CameraTime middle = all[1].interval.start + (all[1].interval.end - all[1].interval.start) / 2;
  const auto kept = std::count_if(events.begin(), events.end(), [&](const events::Event& event) { return event.t <= middle; });
  const CameraTime end =
      record(*again, cut, (static_cast<double>(kept) + 0.5) / static_cast<double>(events.size()), true, true).back().t;
  ASSERT_LE(end, middle);
  const Truth part = read_truth(cut.truth());
  const std::vector<TrueInterval> labelled = labelled_in(cut);
  ASSERT_EQ(labelled.size(), 2U);
  EXPECT_EQ(labelled[0].interval.end, all[0].interval.end);
  EXPECT_EQ(labelled[1].interval.start, all[1].interval.start);
  EXPECT_EQ(labelled[1].interval.end, end);
  EXPECT_EQ(part.lift_start, read_truth(whole.truth()).lift_start);
  for (const TrueInterval& interval : part.intervals) EXPECT_LE(interval.interval.end, end) << interval.what;

  const robot::RobotLog robot = robot::read_robot_log(cut.robot()).longest(),
                        whole_robot = robot::read_robot_log(whole.robot()).longest();
  EXPECT_LT(robot.states.size(), whole_robot.states.size());
  const CameraTime last_state = part.robot_clock->camera_from(robot.states.back().t);
  EXPECT_GE(last_state, end);
  EXPECT_LE(last_state, end + 250ms);
  const std::vector<VideoTime> frames = video::read_video_times(cut.video_times());
  const CameraTime last_frame = part.video_clock->camera_from(frames.back());
  EXPECT_GE(last_frame, end);
  EXPECT_LE(last_frame, end + 150ms);

  // The whole of it beside a real robot and a real film: what is simulated of these is not what was recorded.
  const auto beside = open_simulator_source("sim", "water-bottle", 0, 1);
  const RunFolder real = make_run(folder / "real", "water-bottle", "01");
  record(*beside, real, 1.0, false, false);
  const Truth of_skin = read_truth(real.truth());
  EXPECT_EQ(labelled_in(real).size(), 2U);
  EXPECT_FALSE(of_skin.lift_start || of_skin.robot_clock || of_skin.video_clock);

  // And before anything happened.
  const auto third = open_simulator_source("sim", "water-bottle", 0, 1);
  const RunFolder quiet = make_run(folder / "quiet", "water-bottle", "01");
  record(*third, quiet, 0.001, false, false);
  EXPECT_TRUE(read_truth(quiet.truth()).intervals.empty());
  EXPECT_EQ(read_truth(quiet.truth()).lift_start, std::nullopt);
  EXPECT_FALSE(fs::exists(quiet.robot()));
  EXPECT_FALSE(fs::exists(quiet.video()));
}

TEST(SimulatorSource, RunsOneClockThroughASession) {
  const test::TemporaryFolder folder;
  const auto source = open_simulator_source("sim", std::nullopt, 0, 1);
  EXPECT_TRUE(source->begins_again());
  const RunFolder one = make_run(folder.path(), "fan", "01"), two = make_run(folder.path(), "sprayer", "01");
  const std::vector<events::Event> first = record(*source, one, 1.0), second = record(*source, two, 1.0);
  EXPECT_EQ(source->camera().at("simulator").at("object"), "sprayer") << "the object is the run's where the source names none";
  EXPECT_GT(second.front().t, first.back().t);
  EXPECT_LT(second.front().t, first.back().t + 60s);
  const ClockRelation robot_one = read_truth(one.truth()).robot_clock.value(),
                      robot_two = read_truth(two.truth()).robot_clock.value();
  EXPECT_EQ(robot_one.drift_ppm, robot_two.drift_ppm);
  const std::int64_t stamp = robot_two.reference_us;
  EXPECT_NEAR(static_cast<double>(us_of(robot_one.camera_from(stamp)) - us_of(robot_two.camera_from(stamp))), 0.0, 1.0)
      << "one controller, one clock";
  EXPECT_EQ(us_of(robot::read_robot_log(two.robot()).longest().states.front().t), stamp);
  const std::vector<TrueInterval> labelled = labelled_in(two);
  EXPECT_GT(labelled.at(0).interval.start, second.front().t);
  EXPECT_LT(labelled.at(1).interval.end, second.back().t);
}

TEST(SimulatorSource, NeverEndsIfNothingIsRecorded) {
  const auto source = open_simulator_source("sim", std::nullopt, 0, 1);
  CameraPacket packet;
  CameraTime last{};
  std::uint64_t events = 0;
  microseconds span{};
  CameraTime first{};
  while (span < 12s) {  // a run lasts about 4 s
    ASSERT_EQ(source->receive(packet, milliseconds(0)), CameraSource::Received::packet);
    if (packet.stream_id == 1) continue;
    ASSERT_FALSE(packet.events.empty());
    if (events == 0) first = packet.events.front().t;
    EXPECT_GE(packet.events.front().t, last);
    EXPECT_LT(packet.events.back().t - packet.events.front().t, 1ms);
    last = packet.events.back().t;
    events += packet.events.size();
    span = last - first;
  }
  EXPECT_GT(events, 300'000U);
}

TEST(SimulatorSource, WaitsForRealTime) {
  const test::TemporaryFolder folder;
  const auto source = open_simulator_source("sim", "fan", 20, 1);
  EXPECT_TRUE(source->live());
  source->begin_run(make_run(folder.path(), "fan", "01"));
  const auto begun = std::chrono::steady_clock::now();
  const std::vector<events::Event> events = test::receive_all(*source).streams[0].events;
  EXPECT_GE(20 * (std::chrono::steady_clock::now() - begun), events.back().t - events.front().t);
}

}  // namespace
}  // namespace tactile::capture
