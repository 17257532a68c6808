#include "tactile/labels/label_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "alignment/made_run.hpp"
#include "labels/altered_run.hpp"
#include "labels/press_and_slip.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::labels {
namespace {

using test::lift_after_press;
using test::made_camera_begin_us;
using test::made_lift;
using test::ms_from_begin;
using test::press_and_slip;
using test::write_made_run;

TEST(LabelRun, FindsPressAndSlipInCameraTime) {
  const test::TemporaryFolder data;
  const Labels labels = label_run(write_made_run(data.path(), press_and_slip, lift_after_press));
  EXPECT_TRUE(labels.flags.empty()) << labels.flags.front().reason;
  ASSERT_EQ(labels.intervals.size(), 2U);
  EXPECT_EQ(labels.intervals[0].touch, Touch::press);
  EXPECT_NEAR(ms_from_begin(labels.intervals[0].start.at), 800.0, 0.5);
  EXPECT_NEAR(ms_from_begin(labels.intervals[0].end.at), 1000.0, 3.0);
  EXPECT_EQ(labels.intervals[1].touch, Touch::slip);
  EXPECT_NEAR(ms_from_begin(labels.intervals[1].start.at), 1503.0, 0.5);
  EXPECT_NEAR(ms_from_begin(labels.intervals[1].end.at), 2097.0, 6.0);  // a sudden stop looks like a brief ringing
}

TEST(LabelRun, FlagsARecordingThatLostEventsOnTheirWay) {
  const test::TemporaryFolder data;
  const RunFolder run = write_made_run(data.path(), press_and_slip, lift_after_press);
  RunInfo info{
      .object = run.object, .run = run.run, .session = "", .simulated = false, .complete = true, .width = 64, .height = 48};
  const auto lost = [](int events) { return nlohmann::json{{"packets", 0}, {"events", events}, {"others", 0}}; };
  info.extra["dropped"]["by_reason"] = {
      {"queue_full", lost(0)}, {"back_in_time", lost(3)}, {"unwritten", lost(0)}, {"source", lost(0)}};
  write_run_info(run, info);
  EXPECT_TRUE(label_run(run).flags.empty()) << "what does not fit its stream is no loss";
  for (const std::string reason : {"queue_full", "unwritten", "source"}) {
    RunInfo lossy = info;
    lossy.extra["dropped"]["by_reason"][reason] = lost(70);
    write_run_info(run, lossy);
    const Labels labels = label_run(run);
    ASSERT_EQ(labels.flags.size(), 1U) << reason;
    EXPECT_NE(labels.flags[0].reason.find("lacks 70 events"), std::string::npos) << labels.flags[0].reason;
    EXPECT_NE(labels.flags[0].reason.find(reason), std::string::npos) << labels.flags[0].reason;
  }
}

TEST(LabelRun, RelatesTheRobotsClockAndKeepsTheLagOutOfIt) {
  const test::TemporaryFolder data;
  const Labels labels = label_run(write_made_run(data.path(), press_and_slip, lift_after_press));
  ASSERT_EQ(labels.robot_clocks.size(), 1U);
  // Events that do not follow the arm's speed, as no skin's do: the interval shows how little they decide.
  EXPECT_LE(labels.robot_clocks[0].offset_low_us, -123'456'789);
  EXPECT_GE(labels.robot_clocks[0].offset_high_us, -123'456'789);
  EXPECT_LE(labels.robot_clocks[0].uncertainty(), 40ms);
  EXPECT_EQ(labels.robot_clocks[0].relation.drift_ppm, 0.0);
  ASSERT_TRUE(labels.intervals[1].evidence.robot.has_value());
  EXPECT_NEAR(ms_from_begin(*labels.intervals[1].evidence.robot), 1500.0,
              1e-3 * static_cast<double>(labels.robot_clocks[0].uncertainty().count()));
}

TEST(LabelRun, FindsTheSlipByTheLiftWhenThePressIsTheLongerOne) {
  const test::TemporaryFolder data;
  const Labels labels = label_run(write_made_run(data.path(), {.bursts = {{500'000, 1'100'000}, {1'502'000, 1'800'000}}},
                                                 made_lift(1'500'000, 250'000, 0.06, 77)));
  ASSERT_EQ(labels.intervals.size(), 2U);
  EXPECT_EQ(labels.intervals[0].touch, Touch::press);
  EXPECT_EQ(labels.intervals[1].touch, Touch::slip);
}

TEST(LabelRun, WithoutAnyWitnessIsFlagged) {
  const test::TemporaryFolder data;
  const Labels labels = label_run(write_made_run(data.path(), press_and_slip, {}));
  ASSERT_EQ(labels.intervals.size(), 2U);
  EXPECT_TRUE(labels.robot_clocks.empty());
  EXPECT_TRUE(labels.interval_is_flagged(0) || labels.interval_is_flagged(1)) << test::told_by(labels);
}

TEST(LabelRun, OfNoiseAloneFindsNothingAndSaysThat) {
  const test::TemporaryFolder data;
  const Labels labels = label_run(write_made_run(data.path(), {}, lift_after_press));
  EXPECT_TRUE(labels.intervals.empty());
  EXPECT_TRUE(test::remarks_say(labels, "no press found"));
  EXPECT_TRUE(test::remarks_say(labels, "no slip found"));
}

TEST(LabelRun, OfAnArmThatNeverRisesHasNoSlip) {
  const test::TemporaryFolder data;
  const Labels labels = label_run(write_made_run(data.path(), {.bursts = {{800'000, 1'000'000}}}, made_lift(9e9, 1, 0.06, 0)));
  ASSERT_EQ(labels.intervals.size(), 1U);
  EXPECT_EQ(labels.intervals[0].touch, Touch::press);
  EXPECT_FALSE(labels.run_is_flagged()) << "robot and skin agree that there was no slip";
  EXPECT_TRUE(test::remarks_say(labels, "no slip found"));
  EXPECT_TRUE(test::remarks_say(labels, "the arm does not move in its log"));
}

TEST(LabelRun, RemarksThatMotionsAreThoseOfTheTarget) {
  const test::TemporaryFolder data;
  const RunFolder run = write_made_run(data.path(), press_and_slip, lift_after_press);
  std::string text = read_text(run.robot());
  for (std::size_t at = 0; (at = text.find("actual_TCP", at)) != std::string::npos;) text.replace(at, 6, "target");
  write_whole(run.robot(), text);
  const Labels labels = label_run(run);
  EXPECT_TRUE(std::any_of(labels.remarks.begin(), labels.remarks.end(),
                          [](const std::string& remark) { return remark.find("target_TCP_speed") != std::string::npos; }));
  const std::string from = labels.provenance.at("robot_log").at("speeds_from");
  EXPECT_EQ(from, "target_TCP_speed");
}

TEST(LabelRun, FlagsAGapInTheRecording) {
  const test::TemporaryFolder data;
  const RunFolder run = write_made_run(data.path(), press_and_slip, lift_after_press);
  // Rewritten without what lies between 1.45 and 1.55 s, the slip's onset among it.
  events::RecordingReader recording(run.events());
  events::RecordingWriter writer(data / "cut.aedat4", {events::event_stream_declaration({64, 48}, "DVXplorer_TEST")});
  for (const auto& [begin_us, end_us] : {std::pair(0, 1'450'000), std::pair(1'550'000, 3'000'000)}) {
    events::for_events_between(recording, 0, camera_time(test::made_camera_begin_us + begin_us),
                               camera_time(test::made_camera_begin_us + end_us),
                               [&](std::span<const events::Event> events) { writer.write_events(0, events); });
  }
  writer.close();
  std::filesystem::rename(data / "cut.aedat4", run.events());
  const Labels labels = label_run(run);
  EXPECT_TRUE(labels.run_is_flagged());
}

/// True if a flag of the whole run says so.
bool says(const Labels& labels, const std::string& words) {
  return std::any_of(labels.flags.begin(), labels.flags.end(),
                     [&](const auto& flag) { return !flag.interval_index && flag.reason.find(words) != std::string::npos; });
}

TEST(LabelRun, FlagsAGapInTheRobotLog) {
  const test::TemporaryFolder data;
  robot::RobotLog torn = lift_after_press;
  std::erase_if(torn.states, [](const robot::RobotState& state) {
    const std::int64_t us = us_of(state.t) - us_of(lift_after_press.states.front().t);
    return us > 300'000 && us < 500'000;
  });
  const Labels labels = label_run(write_made_run(data.path(), press_and_slip, torn));
  EXPECT_EQ(labels.intervals.size(), 2U);
  EXPECT_TRUE(says(labels, "the robot log has 1 gap, the longest of 2"));
  EXPECT_TRUE(says(labels, " s after its first row (at "));
}

TEST(LabelRun, FlagsARobotsClockThatRestarts) {
  const test::TemporaryFolder data;
  const RunFolder run = write_made_run(data.path(), press_and_slip, lift_after_press);
  // Five rows of another clock ahead of the others, which are still there whole.
  std::string text = read_text(run.robot());
  std::string rows;
  for (int i = 0; i < 5; ++i) rows += std::to_string(8e9 + 0.008 * i) + ",0,0,0,0,0,0,0,0,0,0,0,0\n";
  text.insert(text.find('\n') + 1, rows);
  std::filesystem::remove(run.robot());
  write_whole(run.robot(), text);
  const Labels labels = label_run(run);
  EXPECT_TRUE(says(labels, "restarts 1 time within its log"));
  ASSERT_EQ(labels.robot_clocks.size(), 1U) << "nothing shows the five rows' clock";
  EXPECT_EQ(labels.robot_clocks[0].relation.reference_us, us_of(lift_after_press.states.front().t));
  EXPECT_LE(labels.robot_clocks[0].offset_low_us, -123'456'789);
  EXPECT_GE(labels.robot_clocks[0].offset_high_us, -123'456'789);
  EXPECT_TRUE(labels.robot_clocks[0].from && labels.robot_clocks[0].to);
}

TEST(LabelRun, FlagsATouchThatTheRecordingBeginsWithin) {
  const test::TemporaryFolder data;
  const Labels labels =
      label_run(write_made_run(data.path(), {.bursts = {{0, 250'000}, {1'503'000, 2'097'000}}}, lift_after_press));
  ASSERT_EQ(labels.intervals.size(), 2U);
  EXPECT_TRUE(labels.interval_is_flagged(0));
  EXPECT_TRUE(test::flags_say(labels, "the recording begins within it: its onset lies before the first event"));
  EXPECT_FALSE(labels.interval_is_flagged(1));
}

TEST(LabelRun, FlagsALiftThatTheObjectFollows) {
  // The skin shears for 28 ms, in which the arm moves by 0.5 mm at 1.2 m/s^2; the arm continues for 0.6 s. The host's times
  // relate the clocks to a few milliseconds.
  const test::TemporaryFolder data;
  robot::RobotLog logged = lift_after_press;
  for (robot::RobotState& state : logged.states) state.host_time = HostTime{microseconds{us_of(state.t) - 123'456'789}};
  const RunFolder run = write_made_run(data.path(), {.bursts = {{800'000, 1'000'000}, {1'502'000, 1'530'000, 120}}}, logged);
  RunInfo info = read_run_info(run);
  for (std::int64_t t = made_camera_begin_us; t < made_camera_begin_us + 3'000'000; t += 100'000)
    info.extra["host_from_camera"].push_back({t, t});
  write_run_info(run, info);
  const Labels labels = label_run(run);
  EXPECT_TRUE(test::flags_say(labels, "it is a slip with a probability of") || test::flags_say(labels, "there is a slip at"))
      << test::told_by(labels);
}

TEST(LabelRun, GivesTheSameBytesEachTime) {
  const test::TemporaryFolder data;
  const RunFolder run = write_made_run(data.path(), press_and_slip, lift_after_press);
  write_labels(data / "first.json", label_run(run));
  write_labels(data / "second.json", label_run(run));
  EXPECT_EQ(read_text(data / "first.json"), read_text(data / "second.json"));
}

}  // namespace
}  // namespace tactile::labels
