#include "tactile/labels/label_runs.hpp"

#include <gtest/gtest.h>

#include <atomic>

#include "alignment/made_run.hpp"
#include "labels/press_and_slip.hpp"
#include "support/events_in_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::labels {
namespace {

using test::lift_after_press;
using test::made_lift;
using test::press_and_slip;
using test::TemporaryFolder;

/// Two runs of one object, of one session if it has a name.
std::vector<RunFolder> write_two_runs(const TemporaryFolder& data, const std::string& session) {
  std::vector<RunFolder> runs;
  for (const std::string name : {"01", "02"}) {
    runs.push_back(test::write_made_run(data.path(), press_and_slip, lift_after_press, name));
    RunInfo info = read_run_info(runs.back());
    info.session = session;
    write_run_info(runs.back(), info);
  }
  return runs;
}

std::string text_of(const RunFolder& run) { return read_text(run.labels()); }

TEST(LabelRuns, WritesTheSameBytesOnAnyNumberOfThreads) {
  for (const std::string session : {"", "morning"}) {
    const TemporaryFolder data;
    const std::vector<RunFolder> runs = write_two_runs(data, session);
    label_runs(runs, {.threads = 1});
    const std::string first = text_of(runs[0]), second = text_of(runs[1]);
    label_runs(runs, {.force = true, .threads = 3});
    EXPECT_EQ(text_of(runs[0]), first);
    EXPECT_EQ(text_of(runs[1]), second);
  }
}

TEST(LabelRuns, KeepsTheLabelsOfUnchangedRuns) {
  const TemporaryFolder data;
  const std::vector<RunFolder> runs = write_two_runs(data, "");
  EXPECT_FALSE(label_runs(runs)[0].unchanged);
  const auto written = std::filesystem::last_write_time(runs[0].labels());
  const std::vector<RunOutcome> again = label_runs(runs);
  EXPECT_TRUE(again[0].unchanged && again[1].unchanged);
  EXPECT_EQ(again[0].labels.intervals.size(), 2U);
  EXPECT_EQ(std::filesystem::last_write_time(runs[0].labels()), written);

  LabelRunsOptions other;
  other.label.doubt.widest_onset_ms = 60;
  EXPECT_FALSE(label_runs(runs, other)[0].unchanged) << "other settings";
  LabelRunsOptions masked;
  masked.label.signals.rate.mask = {{1, 2}};
  EXPECT_FALSE(label_runs(runs, masked)[0].unchanged) << "a mask";
  EXPECT_TRUE(label_runs(runs, masked)[0].unchanged);
  EXPECT_FALSE(label_runs(runs, {.force = true})[0].unchanged);
  EXPECT_TRUE(label_runs(runs)[0].unchanged);
  test::write_made_events(runs[0].events(), {.bursts = press_and_slip.bursts, .seed = 5});
  const std::vector<RunOutcome> changed = label_runs(runs);
  EXPECT_FALSE(changed[0].unchanged) << "other events";
  EXPECT_TRUE(changed[1].unchanged);
}

TEST(LabelRuns, LabelsARunAgainIfOneOfItsSessionChanged) {
  const TemporaryFolder data;
  const std::vector<RunFolder> runs = write_two_runs(data, "morning");
  label_runs(runs);
  test::write_made_events(runs[0].events(), {.bursts = press_and_slip.bursts, .seed = 5});
  EXPECT_FALSE(label_runs({runs[1]})[0].unchanged);
}

/// The same recording, with DV's note of the camera's start.
void note_camera_start(const RunFolder& run, const std::string& start_us) {
  const std::vector<events::Event> events = test::events_in_file(run.events());
  events::Stream stream = events::event_stream_declaration({64, 48}, "DVXplorer_TEST");
  stream.info.emplace_back("tsOffset", start_us);
  std::filesystem::remove(run.events());
  events::RecordingWriter writer(run.events(), {stream});
  writer.write_events(0, events);
  writer.close();
}

TEST(LabelRuns, TakesRecordingsOfOneStartOfTheCameraForASession) {
  const auto method_with = [](const std::string& start_of_second) {
    const TemporaryFolder data;
    const std::vector<RunFolder> runs = write_two_runs(data, "");
    note_camera_start(runs[0], "1605507430438338");
    note_camera_start(runs[1], start_of_second);
    return label_runs(runs)[0].labels.robot_clocks.at(0).method;
  };
  EXPECT_NE(method_with("1605507430438338").find("2 runs of a session"), std::string::npos);
  EXPECT_EQ(method_with("1605507999999999").find("session"), std::string::npos);
}

TEST(LabelRuns, SharesTheClockOfASessionWithARunWithoutAnchors) {
  const TemporaryFolder data;
  std::vector<RunFolder> runs = write_two_runs(data, "morning");
  test::write_made_events(runs[1].events(), {.bursts = {{800'000, 1'000'000}}});
  std::filesystem::remove(runs[1].robot());
  robot::write_robot_log(runs[1].robot(), made_lift(9e9, 1, 0.06, -123'456'789));
  const std::vector<RunOutcome> labelled = label_runs({runs[1]});
  ASSERT_EQ(labelled[0].labels.robot_clocks.size(), 1U);
  EXPECT_LE(labelled[0].labels.robot_clocks[0].offset_low_us, -123'456'789);
  EXPECT_GE(labelled[0].labels.robot_clocks[0].offset_high_us, -123'456'789);
  EXPECT_LE(labelled[0].labels.robot_clocks[0].uncertainty(), 60ms);
  EXPECT_FALSE(std::filesystem::exists(runs[0].labels())) << "only what was asked for is labelled";
}

TEST(LabelRuns, FitsARunApartWhoseControllerRestartedWithinTheSession) {
  const TemporaryFolder data;
  std::vector<RunFolder> runs = write_two_runs(data, "morning");
  runs.push_back(test::write_made_run(data.path(), press_and_slip, made_lift(1'500'000, 500'000, 0.06, 987'654'321), "03"));
  RunInfo info = read_run_info(runs.back());
  info.session = "morning";
  write_run_info(runs.back(), info);
  const std::vector<RunOutcome> labelled = label_runs(runs);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int64_t truly_us = i < 2 ? -123'456'789 : 987'654'321;
    ASSERT_EQ(labelled[i].labels.robot_clocks.size(), 1U) << i;
    EXPECT_NEAR(static_cast<double>(labelled[i].labels.robot_clocks[0].relation.offset_us), static_cast<double>(truly_us), 25'000)
        << i;
    EXPECT_EQ(labelled[i].labels.intervals.size(), 2U) << i;
  }
}

TEST(LabelRuns, LabelsTheOthersWhenOneCannotBeRead) {
  const TemporaryFolder data;
  const std::vector<RunFolder> runs = write_two_runs(data, "");
  std::filesystem::remove(runs[0].events());
  write_whole(runs[0].events(), "no recording");
  const std::vector<RunOutcome> labelled = label_runs(runs);
  EXPECT_NE(labelled[0].error, "");
  EXPECT_EQ(labelled[1].error, "");
  EXPECT_TRUE(std::filesystem::exists(runs[1].labels()));
}

TEST(LabelRuns, KeepsAPersonsEdits) {
  const TemporaryFolder data;
  const std::vector<RunFolder> runs = write_two_runs(data, "");
  label_runs(runs);
  Labels mine = read_labels(runs[0].labels());
  mine.intervals[0].start = {camera_time(us_of(mine.intervals[0].start.at) + 7'000), mine.intervals[0].start.low,
                             camera_time(us_of(mine.intervals[0].start.at) + 9'000)};
  mine.intervals[0].source = "person";
  mine.intervals[0].confirmed = true;
  const CameraTime moved = mine.intervals[0].start.at;
  write_labels(runs[0].labels(), mine);
  LabelRunsOptions other;
  other.label.doubt.widest_onset_ms = 60;
  EXPECT_EQ(label_runs(runs, other)[0].labels.intervals.at(0).start.at, moved);
  other.force = true;
  EXPECT_NE(label_runs(runs, other)[0].labels.intervals.at(0).start.at, moved);
}

TEST(LabelRuns, MakesMissingCompanionsAgain) {
  const TemporaryFolder data;
  const std::vector<RunFolder> runs = write_two_runs(data, "");
  std::atomic<int> made = 0;
  const LabelRunsOptions options{
      .has_companions = [](const RunFolder& run) { return std::filesystem::exists(run.folder / "picture"); },
      .make_companions =
          [&](const alignment::RunSignals& signals, const Labels& labels) {
            EXPECT_EQ(labels.intervals.size(), 2U);
            write_whole(signals.run.folder / "picture", "");
            ++made;
          }};
  label_runs(runs, options);
  EXPECT_EQ(made, 2);
  label_runs(runs, options);
  EXPECT_EQ(made, 2);
  std::filesystem::remove(runs[1].folder / "picture");
  label_runs(runs, options);
  EXPECT_EQ(made, 3);
}

}  // namespace
}  // namespace tactile::labels
