#include "tactile/review/review.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "alignment/made_run.hpp"
#include "support/comes_true.hpp"
#include "support/events_in_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/heatmaps/store_heatmaps.hpp"
#include "tactile/labels/label_runs.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/made_runs.hpp"

namespace tactile::review {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

PageRequest request(const std::string& path, const std::map<std::string, std::string>& query = {}) {
  return {.method = "GET", .path = path, .query = query, .body = ""};
}

std::uint32_t u32(const std::string& bytes, std::size_t index) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + 4 * index, sizeof value);
  return value;
}

class Reviewing : public testing::Test {
 protected:
  /// Reviews the runs of the folder.
  void review_runs(ReviewHelp help = {}) {
    review =
        std::make_unique<Review>(ReviewOptions{.data = "data", .models = data / "models", .studies = data.path(), .who = "ada"},
                                 std::move(help), [this] { return look_for_runs(data.path()); });
  }

  /// The answer, or the refusal of a request.
  PageResponse ask(const PageRequest& asked) const {
    try {
      return review->answer(asked);
    } catch (const Refusal& e) {
      return refusal_response(e.status(), e.what());
    }
  }
  json json_of(const PageRequest& asked) const { return json::parse(ask(asked).body); }
  PageResponse post(const std::string& path, const json& body) const {
    return ask({.method = "POST", .path = path, .query = {}, .body = body.dump()});
  }

  /// Asks until the run is read, and waits for it.
  json read_run(const std::string& path) const {
    PageResponse answer;
    EXPECT_TRUE(test::comes_true([&] {
      answer = ask(request(path));
      return answer.status != 202;
    }));
    return json::parse(answer.body);
  }

  test::TemporaryFolder data;
  std::unique_ptr<Review> review;
};

/// A run with a press, a slip and a lift of the robot, labelled.
class ReviewingARun : public Reviewing {
 protected:
  void SetUp() override {
    run = test::write_made_run(data.path(), {.bursts = {{800'000, 1'000'000}, {1'503'000, 2'097'000}}},
                               test::made_lift(1'500'000, 500'000, 0.06, -123'456'789));
    ASSERT_EQ(labels::label_runs({run}).at(0).error, "");
    events = test::events_in_file(run.events());
  }
  std::string version() const { return json_of(request("/api/runs/fan/01/labels")).at("version"); }
  PageResponse edit(const json& edit, const std::string& why = "") const {
    return post("/api/runs/fan/01/edits", {{"version", version()}, {"why", why}, {"edit", edit}});
  }
  std::int64_t since_first(const events::Event& event) const { return between(events.front().t, event.t).count(); }
  std::size_t count_in(std::int64_t from, std::int64_t to) const {
    return static_cast<std::size_t>(std::count_if(events.begin(), events.end(), [&](const events::Event& event) {
      return from <= since_first(event) && since_first(event) < to;
    }));
  }

  RunFolder run;
  std::vector<events::Event> events;
};

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
  EXPECT_EQ(names, (std::vector<std::string>{"event_rate", "robot_speed", "robot_height"}));
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

TEST_F(ReviewingARun, AnEditIsSavedAndAnsweredWithTheNewLabels) {
  review_runs();
  const PageResponse answer =
      edit({{"kind", "move"}, {"id", "press-1"}, {"end", "start"}, {"to_us", 812'345}, {"within_us", 250}});
  ASSERT_EQ(answer.status, 200) << answer.body;
  const json view = json::parse(answer.body);
  const json press = view.at("intervals").at(0);
  EXPECT_EQ(press.at("start_us"), 812'345);
  EXPECT_EQ(press.at("start_low_us"), 812'095);
  EXPECT_EQ(press.at("start_high_us"), 812'595);
  EXPECT_EQ(press.at("source"), "person");
  EXPECT_EQ(press.at("confirmed"), true);
  EXPECT_EQ(view.at("history").at(0).at("who"), "ada");
  EXPECT_EQ(view.at("can_undo"), true);
  EXPECT_EQ(labels::read_versioned_labels(run).version, view.at("version"));
  EXPECT_EQ(labels::read_labels(run.labels()).intervals.at(0).start.at, after(events.front().t, 812'345us));
}

TEST_F(ReviewingARun, EditsAreUndoneAndRedone) {
  review_runs();
  const json before = json_of(request("/api/runs/fan/01/labels"));
  ASSERT_EQ(edit({{"kind", "reject"}, {"id", "press-1"}}).status, 200);
  ASSERT_EQ(edit({{"kind", "class"}, {"id", "slip-1"}, {"touch", "press"}}).status, 200);
  const json edited = json_of(request("/api/runs/fan/01/labels"));
  const json undone = json::parse(post("/api/runs/fan/01/undo", {{"version", version()}, {"count", 2}}).body);
  EXPECT_EQ(undone.at("intervals"), before.at("intervals"));
  EXPECT_EQ(undone.at("rejected"), before.at("rejected"));
  EXPECT_EQ(undone.at("can_redo"), true);
  EXPECT_EQ(undone.at("can_undo"), false);
  EXPECT_EQ(undone.at("history").at(0).at("undone"), true);
  const json redone = json::parse(post("/api/runs/fan/01/redo", {{"version", version()}, {"count", 2}}).body);
  EXPECT_EQ(redone.at("intervals"), edited.at("intervals"));
  EXPECT_EQ(post("/api/runs/fan/01/redo", {{"version", version()}}).status, 400);
}

TEST_F(ReviewingARun, AnEditOfOlderLabelsIsAConflictWithTheCurrentOnes) {
  review_runs();
  const std::string seen = version();
  const labels::EditNote eve{.who = "eve", .why = ""};
  ASSERT_TRUE(std::holds_alternative<labels::VersionedLabels>(
      labels::save_edit(run, std::nullopt, labels::RejectInterval{"press-1"}, eve)));
  const std::string file = read_text(run.labels());
  for (const auto& [path, body] :
       {std::pair<std::string, json>("edits", {{"version", seen}, {"edit", {{"kind", "confirm-run"}}}}),
        {"undo", {{"version", seen}}},
        {"redo", {{"version", seen}}}}) {
    const PageResponse answer = post("/api/runs/fan/01/" + path, body);
    EXPECT_EQ(answer.status, 409) << path;
    const json conflict = json::parse(answer.body);
    EXPECT_EQ(conflict.at("current").at("intervals").size(), 1U);
    EXPECT_EQ(conflict.at("current").at("version"), version());
    EXPECT_EQ(conflict.at("current").at("history").at(0).at("who"), "eve");
  }
  EXPECT_EQ(read_text(run.labels()), file);
}

TEST_F(ReviewingARun, AnEditThatCannotBeMadeIsRefusedAndSavesNothing) {
  review_runs();
  const std::string file = read_text(run.labels());
  EXPECT_EQ(edit({{"kind", "reject"}, {"id", "press-9"}}).status, 400);
  EXPECT_EQ(edit({{"kind", "move"}, {"id", "press-1"}, {"end", "start"}, {"to_us", 99'000'000}}).status, 400);
  EXPECT_EQ(edit({{"kind", "lift"}, {"flag", 0}}).status, 400);
  EXPECT_EQ(post("/api/runs/fan/01/edits", {{"edit", {{"kind", "confirm-run"}}}}).status, 400);  // of no version
  EXPECT_EQ(ask({.method = "POST", .path = "/api/runs/fan/01/edits", .query = {}, .body = std::string(40'000, '[')}).status, 400);
  EXPECT_EQ(ask(request("/api/runs/fan/01/edits")).status, 405);
  EXPECT_EQ(post("/api/runs/fan/01/labels", json::object()).status, 405);
  EXPECT_EQ(read_text(run.labels()), file);
}

TEST_F(ReviewingARun, ALiftedFlagHasItsReason) {
  labels::Labels flagged = labels::read_labels(run.labels());
  flagged.flags.push_back({.interval_index = 0, .reason = "<img src=x onerror=alert(1)>", .confirmed = false, .key = "k"});
  labels::write_labels(run.labels(), flagged);
  review_runs();
  const json before = json_of(request("/api/runs/fan/01/labels"));
  const std::size_t index = before.at("flags").size() - 1;
  EXPECT_EQ(before.at("flags").at(index).at("what"),
            "<img src=x onerror=alert(1)>");  // text; the page must not make markup of it
  EXPECT_EQ(before.at("flags").at(index).at("interval_id"), "press-1");
  const json after = json::parse(edit({{"kind", "lift"}, {"flag", index}}, "seen in the film").body);
  EXPECT_EQ(after.at("flags").at(index).at("confirmed"), true);
  EXPECT_EQ(after.at("flags").at(index).at("lifted_why"), "seen in the film");
}

TEST_F(ReviewingARun, ThePictureOfEditedLabelsIsDrawnOnceItEnds) {
  std::atomic<int> drawn{0};
  std::string of;
  review_runs({.classify = {}, .default_model = {}, .draw_labels = [&](const RunFolder& one, const labels::Labels& labels) {
                 of = one.name() + " " + std::to_string(labels.history.entries.size());
                 ++drawn;
               }});
  ASSERT_EQ(edit({{"kind", "confirm-run"}}).status, 200);
  review.reset();
  EXPECT_EQ(drawn, 1);
  EXPECT_EQ(of, "fan/01 1");
}

TEST_F(ReviewingARun, ProbabilitiesComeFromTheModelThatIsAskedFor) {
  std::atomic<bool> may_end{false};
  fs::create_directories(data / "models/net");
  std::ofstream(data / "models/net/model.json") << "{}";
  review_runs({.classify =
                   [&](const fs::path&, const fs::path& bundle, const std::function<void(std::size_t)>& advance) {
                     EXPECT_EQ(bundle.filename(), "net");
                     while (!may_end) {
                       advance(1);
                       std::this_thread::sleep_for(std::chrono::milliseconds(1));
                     }
                     results::FullRun full;
                     full.ticks = {.first = after(events.front().t, 40ms), .count = 2, .tick = 2ms};
                     full.probabilities = {{0.5F, 0.25F, 0.25F}, {0.0F, 0.0F, 1.0F}};
                     return full;
                   },
               .default_model = [] { return std::optional<std::string>("net"); },
               .draw_labels = {}});
  const json run_json = read_run("/api/runs/fan/01");
  EXPECT_EQ(run_json.at("default_model"), "net");
  EXPECT_EQ(run_json.at("models"), json::array({"net"}));
  const auto asked = [&](const std::string& model) {
    return ask(
        request("/api/runs/fan/01/signals", {{"from_us", "0"}, {"to_us", "3000000"}, {"names", "p_slip"}, {"model", model}}));
  };
  EXPECT_EQ(json::parse(asked("net").body).at("pending"), json::array({"p_slip"}));
  EXPECT_EQ(asked("../net").status, 404);
  EXPECT_EQ(asked("other").status, 404);
  may_end = true;
  ASSERT_TRUE(test::comes_true([&] { return json::parse(asked("net").body).at("pending").empty(); }));
  const json slip = json::parse(asked("net").body).at("series").at("p_slip");
  EXPECT_EQ(slip.at("t_us"), json::array({40'000, 42'000}));
  EXPECT_EQ(slip.at("mean"), json::array({0.25, 1.0}));
}

TEST_F(ReviewingARun, ProbabilitiesOfAModelThatIsTrainedAgainAreComputedAgain) {
  fs::create_directories(data / "models/net");
  const auto write_model = [&](const std::string& text) {
    std::ofstream(data / "models/net/new.json") << text;
    fs::rename(data / "models/net/new.json", data / "models/net/model.json");
  };
  write_model("1");
  std::atomic<int> asked{0};
  std::atomic<bool> was_ended{false};
  review_runs({.classify =
                   [&](const fs::path&, const fs::path&, const std::function<void(std::size_t)>& advance) {
                     results::FullRun full;
                     full.ticks = {.first = after(events.front().t, 40ms), .count = 1, .tick = 2ms};
                     full.probabilities = {{0.0F, 0.0F, asked == 0 ? 0.25F : 0.5F}};
                     if (asked++ == 0) {
                       try {
                         while (true) {
                           advance(1);
                           std::this_thread::sleep_for(std::chrono::milliseconds(1));
                         }
                       } catch (...) {
                         was_ended = true;
                         throw;
                       }
                     }
                     return full;
                   },
               .default_model = {},
               .draw_labels = {}});
  read_run("/api/runs/fan/01");
  const PageRequest slip =
      request("/api/runs/fan/01/signals", {{"from_us", "0"}, {"to_us", "3000000"}, {"names", "p_slip"}, {"model", "net"}});
  ask(slip);
  ASSERT_TRUE(test::comes_true([&] { return asked == 1; }));
  write_model("2");
  ASSERT_TRUE(test::comes_true([&] { return json_of(slip).at("pending").empty(); }));
  EXPECT_TRUE(was_ended);
  EXPECT_EQ(json_of(slip).at("series").at("p_slip").at("mean"), json::array({0.5}));
}

TEST_F(ReviewingARun, OfManyModelsTheLastOnesAreKept) {
  std::vector<std::string> names;
  for (int i = 0; i < 12; ++i) {
    names.push_back("net-" + std::to_string(i));
    fs::create_directories(data / "models" / names.back());
    std::ofstream(data / "models" / names.back() / "model.json") << "{}";
  }
  std::atomic<int> asked{0};
  review_runs({.classify =
                   [&](const fs::path&, const fs::path&, const std::function<void(std::size_t)>&) {
                     ++asked;
                     return results::FullRun{};
                   },
               .default_model = {},
               .draw_labels = {}});
  read_run("/api/runs/fan/01");
  const auto answered = [&](const std::string& name) {
    const PageRequest slip =
        request("/api/runs/fan/01/signals", {{"from_us", "0"}, {"to_us", "10"}, {"names", "p_slip"}, {"model", name}});
    return test::comes_true([&] { return json_of(slip).at("pending").empty(); });
  };
  for (const std::string& name : names) ASSERT_TRUE(answered(name)) << name;
  EXPECT_EQ(asked, 12);
  ASSERT_TRUE(answered(names.back()));
  EXPECT_EQ(asked, 12);
}

TEST_F(ReviewingARun, EndsWhileAModelStillPredicts) {
  fs::create_directories(data / "models/net");
  std::ofstream(data / "models/net/model.json") << "{}";
  std::atomic<bool> has_begun{false};
  review_runs(
      {.classify = [&](const fs::path&, const fs::path&, const std::function<void(std::size_t)>& advance) -> results::FullRun {
         has_begun = true;
         while (true) {
           advance(1);
           std::this_thread::sleep_for(std::chrono::milliseconds(1));
         }
       },
       .default_model = {},
       .draw_labels = {}});
  read_run("/api/runs/fan/01");
  ask(request("/api/runs/fan/01/signals", {{"from_us", "0"}, {"to_us", "10"}, {"names", "p_slip"}, {"model", "net"}}));
  ASSERT_TRUE(test::comes_true([&] { return has_begun.load(); }));
  review.reset();
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
  EXPECT_NE(studies.at(0).at("error").get<std::string>().find("expected tactile-study-1"), std::string::npos);
}

}  // namespace
}  // namespace tactile::review
