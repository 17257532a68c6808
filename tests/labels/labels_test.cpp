#include "tactile/labels/labels.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::labels {
namespace {

LabelledInterval interval(Touch touch, std::int64_t start_us, std::int64_t end_us) {
  const auto time = [](std::int64_t us) {
    return alignment::UncertainTime{camera_time(us), camera_time(us - 100), camera_time(us + 200)};
  };
  LabelledInterval made;
  made.touch = touch;
  made.start = time(start_us);
  made.end = time(end_us);
  made.source = "events";
  return made;
}

alignment::FittedClock clock_of(std::int64_t offset_us) {
  return {.relation = {.offset_us = offset_us, .drift_ppm = 1.5, .reference_us = 7},
          .offset_low_us = offset_us - 3,
          .offset_high_us = offset_us + 4,
          .anchors = 2,
          .method = "m"};
}

TEST(Labels, SurviveTheirFile) {
  const test::TemporaryFolder folder;
  Labels labels;
  labels.intervals = {interval(Touch::press, 1'000, 2'000), interval(Touch::slip, 3'000, 4'000)};
  labels.intervals[1].evidence.robot = camera_time(2'990);
  labels.intervals[1].confirmed = true;
  labels.robot_clocks = {clock_of(5)};
  labels.video_clock = clock_of(6);
  labels.video_clock->found_at_us = 2'000;
  labels.video_clock->drift_within_ppm = 9'800;
  labels.rejected = {{Touch::press, camera_time(7'000), camera_time(8'000)}};
  labels.releases = {{Touch::none, camera_time(9'000), camera_time(9'500)}};
  labels.flags = {{.interval_index = 1, .reason = "look", .confirmed = false, .key = "onset-width 45"},
                  {.interval_index = {}, .reason = "whole", .confirmed = true}};
  labels.provenance = {{"made_by", "a test"}};
  write_labels(folder / "labels.json", labels);

  const Labels read = read_labels(folder / "labels.json");
  ASSERT_EQ(read.intervals.size(), 2U);
  EXPECT_EQ(read.intervals[0].touch, Touch::press);
  EXPECT_EQ(read.intervals[0].start.low, camera_time(900));
  EXPECT_EQ(read.intervals[1].end.high, camera_time(4'200));
  EXPECT_EQ(read.intervals[1].evidence.robot, camera_time(2'990));
  EXPECT_FALSE(read.intervals[1].evidence.video.has_value());
  EXPECT_TRUE(read.intervals[1].confirmed);
  ASSERT_EQ(read.robot_clocks.size(), 1U);
  EXPECT_EQ(read.robot_clocks[0].relation.drift_ppm, 1.5);
  EXPECT_EQ(read.robot_clocks[0].offset_low_us, 2);
  EXPECT_EQ(read.robot_clocks[0].offset_high_us, 9);
  EXPECT_EQ(read.robot_clocks[0].drift_within_ppm, 0);
  ASSERT_TRUE(read.video_clock.has_value());
  EXPECT_EQ(read.video_clock->found_at_us, 2'000);
  EXPECT_EQ(read.video_clock->drift_within_ppm, 9'800);
  ASSERT_EQ(read.releases.size(), 1U);
  EXPECT_EQ(read.releases[0].touch, Touch::none);
  EXPECT_EQ(read.releases[0].start, camera_time(9'000));
  EXPECT_EQ(read.releases[0].end, camera_time(9'500));
  ASSERT_EQ(read.rejected.size(), 1U);
  EXPECT_EQ(read.rejected[0].touch, Touch::press);
  EXPECT_EQ(read.rejected[0].end, camera_time(8'000));
  ASSERT_EQ(read.flags.size(), 2U);
  EXPECT_EQ(read.flags[0].key, "onset-width 45");
  EXPECT_EQ(read.flags[1].key, "") << "of an older version";
  EXPECT_EQ(read.provenance, labels.provenance);
}

TEST(Labels, KeepAClockForEachPieceOfALogWhoseControllerRestarted) {
  const test::TemporaryFolder folder;
  Labels labels;
  labels.robot_clocks = {clock_of(5), clock_of(50)};
  labels.robot_clocks[0].to = camera_time(1'000);
  labels.robot_clocks[1].from = camera_time(2'000);
  write_labels(folder / "labels.json", labels);
  const Labels read = read_labels(folder / "labels.json");
  ASSERT_EQ(read.robot_clocks.size(), 2U);
  EXPECT_EQ(read.robot_clock_at(camera_time(0))->relation.offset_us, 5);
  EXPECT_EQ(read.robot_clock_at(camera_time(1'400))->relation.offset_us, 5);
  EXPECT_EQ(read.robot_clock_at(camera_time(1'600))->relation.offset_us, 50);
  EXPECT_EQ(read.robot_clock_at(camera_time(9'000))->relation.offset_us, 50);
  EXPECT_EQ(Labels{}.robot_clock_at(camera_time(0)), nullptr);
}

TEST(Labels, NameTheirIntervalsPermanently) {
  const test::TemporaryFolder folder;
  Labels labels;
  labels.intervals = {interval(Touch::press, 1'000, 2'000), interval(Touch::press, 2'500, 2'600),
                      interval(Touch::slip, 3'000, 4'000)};
  labels.intervals[1].id = "press-1";
  write_labels(folder / "labels.json", labels);
  const Labels read = read_labels(folder / "labels.json");
  EXPECT_EQ(read.intervals[0].id, "press-2");
  EXPECT_EQ(read.intervals[1].id, "press-1");
  EXPECT_EQ(read.intervals[2].id, "slip-1");
  labels.intervals[0].id = "press-1";
  EXPECT_THROW(write_labels(folder / "labels.json", labels), Error);
}

TEST(Labels, AreFlaggedUntilAPersonConfirms) {
  Labels labels;
  labels.intervals = {interval(Touch::press, 1'000, 2'000), interval(Touch::slip, 3'000, 4'000)};
  labels.flags = {{.interval_index = 1, .reason = "look", .confirmed = false},
                  {.interval_index = {}, .reason = "whole", .confirmed = true}};
  EXPECT_FALSE(labels.run_is_flagged());
  EXPECT_FALSE(labels.interval_is_flagged(0));
  EXPECT_TRUE(labels.interval_is_flagged(1));
  labels.flags[1].confirmed = false;
  EXPECT_TRUE(labels.run_is_flagged());
}

TEST(Labels, ThatOverlapOrEndBeforeTheyStartAreRefused) {
  const test::TemporaryFolder folder;
  Labels labels;
  labels.intervals = {interval(Touch::press, 1'000, 3'500), interval(Touch::slip, 3'000, 4'000)};
  EXPECT_THROW(write_labels(folder / "labels.json", labels), Error);
  labels.intervals = {interval(Touch::press, 1'000, 900)};
  EXPECT_THROW(write_labels(folder / "labels.json", labels), Error);
}

TEST(Labels, ThatAreNoObjectAreRefusedAsWhatTheyAre) {
  const test::TemporaryFolder folder;
  const std::string file = (folder / "labels.json").string();
  for (const auto& [json, words] : {std::pair{"[1]", "a list"}, {"null", "null"}, {"5", "a number"}, {"\"x\"", "a text"}}) {
    write_whole(file, json);
    EXPECT_EQ(test::error_of([&] { read_labels(file); }), file + ": is " + words + "; expected an object");
  }
}

TEST(Labels, OfTimesBeforeTheCamerasFirstAreRefusedByMember) {
  const test::TemporaryFolder folder;
  Labels labels;
  labels.intervals = {interval(Touch::press, 1'000, 3'500)};
  labels.rejected = {{Touch::slip, camera_time(5'000), camera_time(6'000)}};
  write_labels(folder / "labels.json", labels);
  const auto whole = read_json(folder / "labels.json");
  for (const char* member : {"/intervals/0/start_us", "/rejected/0/start_us"}) {
    nlohmann::json json = whole;
    const nlohmann::json::json_pointer place(member);
    ASSERT_TRUE(json.contains(place)) << member;
    json[place] = -5;
    write_json(folder / "labels.json", json);
    try {
      read_labels(folder / "labels.json");
      ADD_FAILURE() << member << ": no error";
    } catch (const Error& e) {
      const std::string list = std::string(member).find("intervals") == std::string::npos ? "rejected" : "intervals";
      EXPECT_EQ(e.what(), (folder / "labels.json").string() + ": " + list +
                              "[0].start_us is -5; expected 0 to 10000000000000000, as its recording has");
    }
  }
  nlohmann::json json = whole;
  json["intervals"][0]["start_low_us"] = -5;  // an interval of confidence may reach below
  write_json(folder / "labels.json", json);
  EXPECT_EQ(read_labels(folder / "labels.json").intervals.front().start.low, camera_time(-5));
}

TEST(Labels, OfImpossibleTimesAndClocksAreRefusedByMember) {
  const test::TemporaryFolder folder;
  const std::string file = (folder / "labels.json").string();
  Labels labels;
  labels.intervals = {interval(Touch::press, 1'000, 3'500)};
  labels.robot_clocks = {clock_of(5)};
  labels.video_clock = clock_of(50);
  labels.releases = {{Touch::none, camera_time(4'000), camera_time(4'500)}};
  labels.rejected = {{Touch::slip, camera_time(5'000), camera_time(6'000)}};
  write_labels(file, labels);
  const auto whole = read_json(file);
  EXPECT_NO_THROW(read_labels(file));

  constexpr auto most = std::numeric_limits<std::int64_t>::max(), least = std::numeric_limits<std::int64_t>::min();
  struct Case {
    const char* member;
    nlohmann::json value;
    std::string error;
  };
  const std::string range = "expected -10000000000000000 to 10000000000000000, as its recording has",
                    range_from_0 = "expected 0 to 10000000000000000, as its recording has";
  const std::vector<Case> cases{
      {"/intervals/0/start_low_us", most, "intervals[0].start_low_us is 9223372036854775807; " + range},
      {"/intervals/0/start_high_us", least, "intervals[0].start_high_us is -9223372036854775808; " + range},
      {"/intervals/0/end_us", most, "intervals[0].end_us is 9223372036854775807; " + range_from_0},
      {"/releases/0/start_us", -1, "releases[0].start_us is -1; " + range_from_0},
      {"/rejected/0/end_us", most, "rejected[0].end_us is 9223372036854775807; " + range_from_0},
      {"/clocks/robot/offset_us", std::int64_t{1} << 62, "clocks.robot.offset_us is 4611686018427387904; " + range},
      {"/clocks/video/drift_ppm", 1e300, "clocks.video.drift_ppm is 1e+300; expected -100000 to 100000"}};
  for (const Case& one : cases) {
    nlohmann::json json = whole;
    const nlohmann::json::json_pointer place(one.member);
    ASSERT_TRUE(json.contains(place)) << one.member;
    json[place] = one.value;
    write_json(file, json);
    EXPECT_EQ(test::error_of([&] { read_labels(file); }), file + ": " + one.error) << one.member;
  }
}

TEST(Labels, FileOfAnotherKindIsRefusedByName) {
  const test::TemporaryFolder folder;
  write_json(folder / "labels.json", {{"intervals", "many"}});
  try {
    read_labels(folder / "labels.json");
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("labels.json"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace tactile::labels
