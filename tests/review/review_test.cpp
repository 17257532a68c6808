#include "tactile/review/review.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "review/reviewing.hpp"
#include "support/comes_true.hpp"
#include "support/events_in_file.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/heatmaps/store_heatmaps.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/made_runs.hpp"

namespace tactile::review {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::request;
using test::Reviewing;
using test::ReviewingARun;
using test::u32;

TEST_F(ReviewingARun, TheListHasTheRunWithItsLabels) {
  review_runs();
  ASSERT_TRUE(test::comes_true([&] { return !json_of(request("/api/runs")).at("runs").at(0).at("rate_peak_per_s").is_null(); }));
  const json list = json_of(request("/api/runs"));
  EXPECT_EQ(list.at("data"), "data");
  EXPECT_EQ(list.at("progress").at("runs"), 1);
  EXPECT_EQ(list.at("progress").at("confirmed"), 0);
  const json row = list.at("runs").at(0);
  EXPECT_EQ(row.at("name"), "fan/01");
  EXPECT_EQ(row.at("events"), events.size());
  EXPECT_EQ(row.at("width"), 64);
  EXPECT_EQ(row.at("height"), 48);
  EXPECT_EQ(row.at("has").at("robot"), true);
  EXPECT_EQ(row.at("has").at("video"), false);
  EXPECT_EQ(row.at("intervals").size(), 2U);
  EXPECT_EQ(row.at("error"), nullptr);
  EXPECT_NEAR(row.at("length_s").get<double>(), 3.0, 1e-3);
  EXPECT_EQ(json_of(request("/api/runs")).at("revision"), list.at("revision"));
  ASSERT_EQ(edit({{"kind", "confirm-run"}}).status, 200);
  const json after = json_of(request("/api/runs"));
  EXPECT_NE(after.at("revision"), list.at("revision"));
  EXPECT_EQ(after.at("runs").at(0).at("confirmed"), true);
}

TEST_F(ReviewingARun, IsReadOnceItIsAskedFor) {
  review_runs();
  const PageResponse at_once =
      ask(request("/api/runs/fan/01/signals", {{"from_us", "0"}, {"to_us", "10"}, {"names", "event_rate"}}));
  EXPECT_TRUE(at_once.status == 202 || at_once.status == 200);
  const json read = read_run("/api/runs/fan/01");
  EXPECT_EQ(read.at("tick_us"), 2000);
  EXPECT_EQ(read.at("history_us"), 40'000);
  EXPECT_EQ(read.at("tick_origin_us"), 0);  // the recording begins at a whole tick
  EXPECT_EQ(read.at("film"), nullptr);
  std::vector<std::string> names;
  for (const json& signal : read.at("signals")) names.push_back(signal.at("name"));
  EXPECT_EQ(names, (std::vector<std::string>{"event_rate", "touched_rate", "robot_speed", "robot_height"}));
}

TEST_F(ReviewingARun, TheRateOfAWindowIsItsExactCount) {
  review_runs();
  read_run("/api/runs/fan/01");
  for (const auto& [from, to, points] :
       {std::tuple(0, 3'000'000, 300), std::tuple(1'500'000, 1'600'000, 50), std::tuple(1'503'000, 1'504'000, 200)}) {
    const json answer = json_of(request("/api/runs/fan/01/signals", {{"from_us", std::to_string(from)},
                                                                     {"to_us", std::to_string(to)},
                                                                     {"points", std::to_string(points)},
                                                                     {"names", "event_rate"}}));
    const json rate = answer.at("series").at("event_rate");
    const auto bucket = rate.at("bucket_us").get<std::int64_t>();
    ASSERT_GT(rate.at("t_us").size(), 0U);
    for (std::size_t i = 0; i < rate.at("t_us").size(); ++i) {
      const std::int64_t begin = rate.at("t_us").at(i).get<std::int64_t>() - bucket / 2;
      if (begin + bucket > 2'999'000) continue;  // the last one is cut off
      EXPECT_NEAR(rate.at("mean").at(i).get<double>() * static_cast<double>(bucket) / 1000,
                  static_cast<double>(count_in(begin, begin + bucket)), 1e-6)
          << from << ", bucket " << i;
    }
  }
}

TEST_F(ReviewingARun, AtTheZoomOfAnOnsetTheRateOfTheTouchedPlacesRises) {
  review_runs();
  read_run("/api/runs/fan/01");
  const std::int64_t onset = json_of(request("/api/runs/fan/01/labels")).at("intervals").at(0).at("start_us").get<std::int64_t>();
  const auto window = [&] {
    return json_of(request("/api/runs/fan/01/signals", {{"from_us", std::to_string(onset - 30'000)},
                                                        {"to_us", std::to_string(onset + 30'000)},
                                                        {"points", "1000"},
                                                        {"smooth_us", "600"},
                                                        {"names", "event_rate,touched_rate"}}));
  };
  ASSERT_TRUE(test::comes_true([&] { return window().at("pending").empty(); }));
  const json series = window().at("series");
  EXPECT_EQ(series.at("event_rate").at("over_us"), 600);
  // The mean rate of 20 ms before and after the onset, and the largest value before it.
  const auto rates = [&](const std::string& name) {
    const json& rate = series.at(name);
    double before = 0, after = 0, most_before = 0;
    int n_before = 0, n_after = 0;
    for (std::size_t i = 0; i < rate.at("t_us").size(); ++i) {
      const auto t = rate.at("t_us").at(i).get<std::int64_t>() - onset;
      const auto value = rate.at("mean").at(i).get<double>();
      if (t < -5'000) {
        before += value;
        most_before = std::max(most_before, value);
        ++n_before;
      } else if (t > 5'000 && t < 25'000) {
        after += value;
        ++n_after;
      }
    }
    return std::array{before / n_before, after / n_after, most_before};
  };
  const auto whole = rates("event_rate"), touched = rates("touched_rate");
  const auto clearness = [](const auto& rate) { return (rate[1] - rate[0]) / std::sqrt(rate[0]); };
  EXPECT_GT(clearness(touched), clearness(whole)) << "a rise over its noise, without the rest of the picture";
  EXPECT_GT(touched[1], touched[2]) << "noise before the onset does not reach the rate after it";
}

TEST_F(Reviewing, ARunWithoutLabelsIsLabelledOnRequest) {
  const RunFolder run = test::write_made_run(data.path(), test::press_and_slip, test::lift_after_press);
  review_runs();
  EXPECT_EQ(ask(request("/api/runs/fan/01/labels")).status, 404);
  const auto signals = [&] { return read_run("/api/runs/fan/01").at("signals").size(); };
  EXPECT_EQ(signals(), 1U) << "the event rate alone: robot and film have no clock";
  EXPECT_EQ(ask(request("/api/runs/fan/01/label")).status, 405);
  const PageResponse labelled = post("/api/runs/fan/01/label", {});
  ASSERT_EQ(labelled.status, 200) << labelled.body;
  EXPECT_EQ(json::parse(labelled.body).at("intervals").size(), 2U);
  const json by_page = read_json(run.labels());
  EXPECT_EQ(labels::label_runs({run}).at(0).unchanged, true) << "'tactile label' makes the same";
  EXPECT_EQ(read_json(run.labels()), by_page);
  EXPECT_EQ(signals(), 4U);
}

TEST_F(ReviewingARun, TheLiftOfTheRobotLiesWhereItsClockPutsIt) {
  review_runs();
  read_run("/api/runs/fan/01");
  const json speed = json_of(request("/api/runs/fan/01/signals",
                                     {{"from_us", "0"}, {"to_us", "3000000"}, {"points", "5000"}, {"names", "robot_speed"}}))
                         .at("series")
                         .at("robot_speed");
  double before = 0, within = 0;
  for (std::size_t i = 0; i < speed.at("t_us").size(); ++i) {
    const auto t = speed.at("t_us").at(i).get<std::int64_t>();
    const auto value = speed.at("mean").at(i).get<double>();
    if (t < 1'400'000) before = std::max(before, value);
    if (t > 1'700'000 && t < 1'900'000) within = std::max(within, value);
  }
  EXPECT_LT(before, 0.005);
  EXPECT_NEAR(within, 0.06, 0.005);
}

TEST_F(ReviewingARun, TheEventsOfAWindowAreCountedAtTheirPixels) {
  review_runs();
  read_run("/api/runs/fan/01");
  const std::int64_t at = 1'620'000, history = 30'000;
  const PageResponse answer =
      ask(request("/api/runs/fan/01/events", {{"at_us", std::to_string(at)}, {"history_us", std::to_string(history)}}));
  ASSERT_EQ(answer.status, 200);
  EXPECT_EQ(answer.type, "application/octet-stream");
  constexpr std::size_t width = 64, height = 48, pixels = width * height;
  std::vector<int> on(pixels), off(pixels);
  for (const events::Event& event : events) {
    if (since_first(event) >= at - history && since_first(event) < at)
      ++(event.on != 0 ? on : off)[static_cast<std::size_t>(event.y * 64 + event.x)];
  }
  ASSERT_EQ(answer.body.size(), 16U + 2 * pixels);
  EXPECT_EQ(u32(answer.body, 0), 64U);
  EXPECT_EQ(u32(answer.body, 1), 48U);
  EXPECT_EQ(u32(answer.body, 2) + u32(answer.body, 3), count_in(at - history, at));
  for (std::size_t pixel = 0; pixel < on.size(); ++pixel) {
    ASSERT_EQ(static_cast<unsigned char>(answer.body[16 + pixel]), std::min(on[pixel], 255));
    ASSERT_EQ(static_cast<unsigned char>(answer.body[16 + on.size() + pixel]), std::min(off[pixel], 255));
  }
}

TEST_F(ReviewingARun, TheTimesOfEventsAreThoseOfTheRecording) {
  review_runs();
  read_run("/api/runs/fan/01");
  const json times = json_of(request("/api/runs/fan/01/event_times", {{"from_us", "1503000"}, {"to_us", "1503600"}})).at("t_us");
  std::vector<std::int64_t> expected;
  for (const events::Event& event : events) {
    if (since_first(event) >= 1'503'000 && since_first(event) < 1'503'600) expected.push_back(since_first(event));
  }
  EXPECT_EQ(times.get<std::vector<std::int64_t>>(), expected);
  EXPECT_EQ(ask(request("/api/runs/fan/01/event_times", {{"from_us", "0"}, {"to_us", "200000"}})).status, 400);
  const json dense = json_of(request("/api/runs/fan/01/event_times", {{"from_us", "1503000"}, {"to_us", "1603000"}}));
  ASSERT_GT(count_in(1'503'000, 1'603'000), 20'000U);
  EXPECT_EQ(dense.at("too_many"), true);
  EXPECT_TRUE(dense.at("t_us").empty());
}

TEST_F(ReviewingARun, AThumbnailIsASmallPicture) {
  review_runs();
  PageResponse answer;
  ASSERT_TRUE(test::comes_true([&] {
    answer = ask(request("/api/runs/fan/01/thumbnail"));
    return answer.status != 202;
  }));
  ASSERT_EQ(answer.status, 200);
  const std::vector<unsigned char> bytes(answer.body.begin(), answer.body.end());
  EXPECT_EQ(cv::imdecode(bytes, cv::IMREAD_COLOR).size(), cv::Size(64, 48));
}

TEST_F(ReviewingARun, WrongQuestionsAreRefused) {
  review_runs();
  read_run("/api/runs/fan/01");
  for (const char* path :
       {"/api", "/api/none", "/api/runs/fan", "/api/runs/fan/99", "/api/runs/fan/../../etc", "/api/runs/../01",
        "/api/runs/fan/01/none", "/api/runs/fan/01/labels/more", "/api/runs/FAN/01", "/api/runs/fan/1", "/api/who/me"})
    EXPECT_EQ(ask(request(path)).status, 404) << path;
  for (const auto& [from, to, points] :
       {std::tuple("5", "5", "10"), std::tuple("9", "5", "10"), std::tuple("x", "5", "10"), std::tuple("0", "5", "0"),
        std::tuple("0", "5", "999999999"), std::tuple("0", "99999999999999999999", "5"), std::tuple("nan", "5", "5")}) {
    EXPECT_EQ(
        ask(request("/api/runs/fan/01/signals", {{"from_us", from}, {"to_us", to}, {"points", points}, {"names", "event_rate"}}))
            .status,
        400)
        << from;
  }
  EXPECT_EQ(ask(request("/api/runs/fan/01/events")).status, 400);
  EXPECT_EQ(ask(request("/api/runs/fan/01/events", {{"at_us", "0"}, {"history_us", "0"}})).status, 400);
  EXPECT_EQ(ask(request("/api/runs/fan/01/heatmap", {{"at_us", "0"}, {"history_us", "99999999"}})).status, 400);
  EXPECT_EQ(ask(request("/api/runs/fan/01/film", {{"at_us", "0"}})).status, 404);
  EXPECT_EQ(json_of(request("/api/runs/fan/01/signals", {{"from_us", "0"}, {"to_us", "5"}, {"names", "<script>,,nothing"}}))
                .at("series"),
            json::object());
}

TEST_F(ReviewingARun, ARunThatCannotBeReadIsListedAndTheOthersWork) {
  fs::create_directories(data / "fan/02");
  std::ofstream(data / "fan/02/events.aedat4") << "no recording";
  fs::create_directories(data / "fan/03");
  fs::copy(run.events(), data / "fan/03/events.aedat4");
  std::ofstream(data / "fan/03/labels.json") << "{\"intervals\": 5";
  fs::create_directories(data / "Fan <b>new/01");
  fs::copy(run.events(), data / "Fan <b>new/01/events.aedat4");
  review_runs();
  ASSERT_TRUE(test::comes_true([&] {
    const json runs = json_of(request("/api/runs")).at("runs");
    return !runs.at(0).at("rate_peak_per_s").is_null() && !runs.at(1).at("error").is_null();
  }));
  const json list = json_of(request("/api/runs"));
  ASSERT_EQ(list.at("runs").size(), 3U);
  EXPECT_EQ(list.at("runs").at(0).at("error"), nullptr);
  EXPECT_NE(list.at("runs").at(1).at("error").get<std::string>().find("AEDAT4"), std::string::npos);
  EXPECT_NE(list.at("runs").at(2).at("error").get<std::string>().find("labels.json"), std::string::npos);
  EXPECT_EQ(list.at("left_out").size(), 1U);
  EXPECT_EQ(read_run("/api/runs/fan/02").count("error"), 1U);
  EXPECT_EQ(ask(request("/api/runs/fan/02/thumbnail")).status, 204);
  EXPECT_EQ(ask(request("/api/runs/fan/02/labels")).status, 404);
  EXPECT_EQ(read_run("/api/runs/fan/01").at("name"), "fan/01");
}

TEST_F(ReviewingARun, ANewRunAppears) {
  review_runs();
  fs::create_directories(data / "fan/02");
  fs::copy(run.events(), data / "fan/02/events.aedat4");
  ASSERT_TRUE(test::comes_true([&] { return json_of(request("/api/runs")).at("runs").size() == 2; }));
  EXPECT_EQ(read_run("/api/runs/fan/02").at("has").at("labels"), false);
  EXPECT_EQ(ask(request("/api/runs/fan/02/labels")).status, 404);
}

TEST_F(ReviewingARun, ManyRunsOpenOneAfterTheOther) {
  for (const char* name : {"02", "03", "04", "05", "06", "07"}) {
    fs::create_directories(data / "fan" / name);
    fs::copy(run.events(), data / "fan" / name / "events.aedat4");
  }
  review_runs();
  for (int round = 0; round < 2; ++round) {
    for (const char* name : {"01", "02", "03", "04", "05", "06", "07"})
      EXPECT_EQ(read_run(std::string("/api/runs/fan/") + name).at("events"), events.size());
  }
}

TEST_F(Reviewing, TwoRunsOfOneNameAreRefused) {
  RunsBelow twice;
  twice.runs = {{data / "a/fan/01", "fan", "01"}, {data / "b/fan/01", "fan", "01"}};
  EXPECT_THROW(Review({.data = "", .models = {}, .studies = {}, .who = ""}, {}, [&] { return twice; }), Error);
}

TEST_F(Reviewing, HeatmapsAreByteByByteThoseOfTheDataset) {
  test::make_three_runs(data.path());
  const fs::path file = data / "dataset.h5";
  windows::write_dataset(data.path(), file);
  const std::vector<heatmaps::HeatmapOptions> histories{{.history = 40ms}, {.history = 6ms}};
  heatmaps::store_heatmaps(windows::Dataset(file), histories);
  const windows::Dataset dataset(file);
  review_runs();
  std::size_t compared = 0;
  for (std::uint32_t i = 0; i < dataset.samples().size(); i += 3) {
    const windows::Sample& sample = dataset.samples()[i];
    const std::string path = "/api/runs/" + name_of(dataset.runs()[sample.run_index]);
    const json run = read_run(path);
    const std::int64_t at = us_of(sample.t) - run.at("first_event_us").get<std::int64_t>();
    for (const heatmaps::HeatmapOptions& options : histories) {
      const PageResponse answer = ask(
          request(path + "/heatmap", {{"at_us", std::to_string(at)}, {"history_us", std::to_string(options.history.count())}}));
      ASSERT_EQ(answer.status, 200) << answer.body;
      const std::vector<std::uint32_t> index{i};
      const std::vector<std::uint8_t> stored = dataset.read_heatmaps(heatmaps::stored_name(options), index);
      ASSERT_EQ(answer.body.size(), 16 + stored.size());
      EXPECT_EQ(u32(answer.body, 0) * u32(answer.body, 1), stored.size());
      ASSERT_EQ(std::memcmp(answer.body.data() + 16, stored.data(), stored.size()), 0) << "sample " << i;
      ++compared;
    }
  }
  EXPECT_GT(compared, 10U);
}

TEST_F(Reviewing, ModelsAndStudiesThatCannotBeReadAreListedWithTheirError) {
  fs::create_directories(data / "models/broken");
  std::ofstream(data / "models/broken/model.json") << "{]";
  fs::create_directories(data / "study-a");
  std::ofstream(data / "study-a/study.json") << R"({"format": "tactile-study-9"})";
  fs::create_directories(data / "fan/01");
  review_runs();
  const json models = json_of(request("/api/models")), studies = json_of(request("/api/studies"));
  ASSERT_EQ(models.size(), 1U);
  EXPECT_EQ(models.at(0).at("name"), "broken");
  EXPECT_FALSE(models.at(0).at("error").is_null());
  ASSERT_EQ(studies.size(), 1U);
  EXPECT_EQ(studies.at(0).at("name"), "study-a");
  EXPECT_NE(studies.at(0).at("error").get<std::string>().find("expected tactile-study-2"), std::string::npos);
}

}  // namespace
}  // namespace tactile::review
