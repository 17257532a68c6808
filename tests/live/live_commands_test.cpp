#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "evaluation/trained_model.hpp"
#include "live/live_client.hpp"
#include "support/events_in_file.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/video/picture_codec.hpp"

namespace tactile::live {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::get;
using test::LiveClient;
using test::post;
using test::RunningCommand;

bool is_recording(const json& message) {
  return !message.at("state").is_null() && message.at("state").at("state") == "recording";
}

class RecordPreview : public testing::Test {
 protected:
  test::TemporaryFolder folder;
};

TEST_F(RecordPreview, ShowsTheRunUntilItsEnd) {
  RunningCommand command("record --from sim --object fan --speed 0.5 --preview 0", folder.path());
  const std::uint16_t port = test::port_in(command.logged_after("preview at "));
  EXPECT_NE(get(port, "/").body.find("<!doctype html>"), std::string::npos);
  EXPECT_EQ(get(port, "/api/live", "Host: evil.example\r\n").status, 403);
  LiveClient client(port);
  const json message = client.next_where([](const json& m) {
    const json& steps = m.at("steps");
    return is_recording(m) && m.at("state").at("recording").at("events") > 0 && m.at("live").at("picture") > 0 &&
           !steps.empty() && steps.back().back().is_number();
  });
  ASSERT_FALSE(message.is_null()) << command.err();
  const json& state = message.at("state");
  EXPECT_EQ(state.at("kind"), "record");
  EXPECT_EQ(state.at("run"), "fan/01");
  EXPECT_EQ(state.at("sources").at(0).at("name"), "sim");
  EXPECT_EQ(state.at("sources").at(0).at("state"), "sends");
  EXPECT_GT(state.at("disk").at("free_bytes").get<double>(), 0);
  EXPECT_EQ(state.at("recording").at("dropped").at("events"), 0);
  EXPECT_TRUE(state.at("robot").is_null());
  EXPECT_FALSE(state.at("has_film"));
  EXPECT_EQ(get(port, "/api/live/film").status, 404);
  EXPECT_GT(message.at("live").at("rate_per_s").get<double>(), 0);
  EXPECT_EQ(message.at("columns").back(), "imu_m_per_s2");
  EXPECT_NEAR(message.at("steps").back().back().get<double>(), 9.8, 5) << "the camera hangs at an arm";
  command.signal(SIGINT);
  const json last = client.next_where([](const json& m) { return m.at("ended").get<bool>(); });
  ASSERT_FALSE(last.is_null());
  EXPECT_EQ(last.at("state").at("state"), "ended");
  EXPECT_EQ(last.at("state").at("runs").at(0).at("run"), "01");
  EXPECT_EQ(command.wait().exit_code, 0);
}

TEST_F(RecordPreview, ShowsTheFilmAndTheClockOfALiveCamera) {
  ASSERT_EQ(test::run_tactile("simulate sim --preset tiny --objects fan --quiet", folder.path()).exit_code, 0);
  RunningCommand camera("serve sim/fan/01 --port 0 --loop", folder.path());
  const std::string address = "tcp://" + camera.logged_after("tcp://");
  RunningCommand command("record --object fan --from " + address + " --video sim/fan/01/video.mp4 --preview 0", folder.path());
  const std::uint16_t port = test::port_in(command.logged_after("preview at "));
  LiveClient client(port);
  const json message = client.next_where([](const json& m) {
    return is_recording(m) && !m.at("state").at("recording").at("clock").is_null() && !m.at("steps").empty() &&
           m.at("steps").back().at(2).is_number() && !m.at("state").at("video").at("clock").is_null();
  });
  ASSERT_FALSE(message.is_null()) << command.err();
  EXPECT_EQ(message.at("columns"), (std::vector<std::string>{"events_per_s", "lateness_ms"}));
  const json& clock = message.at("state").at("recording").at("clock");
  EXPECT_GE(clock.at("lateness_ms").get<double>(), 0);
  EXPECT_LT(std::abs(clock.at("change_ms").get<double>()), 1'000);
  EXPECT_TRUE(message.at("state").at("has_film"));
  test::Answer film;
  ASSERT_TRUE(test::comes_true([&] { return (film = get(port, "/api/live/film")).status == 200; }));
  const cv::Mat picture = video::decoded_picture(std::as_bytes(std::span(film.body)));
  EXPECT_GT(picture.rows, 100);
  EXPECT_LE(picture.cols, 640);
  command.signal(SIGINT);
  EXPECT_EQ(command.wait().exit_code, 0);
  camera.signal(SIGINT);
  camera.wait();
}

TEST_F(RecordPreview, ShowsWhatASessionWaitsFor) {
  std::ofstream(folder / "plan.json") << R"({"session": "monday", "objects": [{"name": "fan", "runs": 1}]})";
  RunningCommand command("record --from sim --speed 0.5 --session plan.json --preview 0", folder.path());
  LiveClient client(test::port_in(command.logged_after("preview at ")));
  const json waiting = client.next_where([](const json& m) { return !m.at("state").is_null(); });
  ASSERT_FALSE(waiting.is_null());
  EXPECT_EQ(waiting.at("state").at("state"), "waiting");
  EXPECT_NE(waiting.at("state").at("words").get<std::string>().find("fan, run 1 of 1: Enter starts"), std::string::npos);
  command.type("\n");
  EXPECT_FALSE(client.next_where(is_recording).is_null());
}

TEST_F(RecordPreview, TheRunsOfASessionAreStartedStoppedAndRedoneOnThePage) {
  std::ofstream(folder / "plan.json") << R"({"session": "monday", "objects": [{"name": "fan", "runs": 1}, {"name": "mug"}]})";
  RunningCommand command("record --from sim --speed 0.1 --session plan.json --out data --preview 0", folder.path());
  command.close_input();
  const std::uint16_t port = test::port_in(command.logged_after("preview at "));
  LiveClient client(port);
  const auto offers = [](const json& message) {
    std::vector<std::string> words;
    if (message.at("state").is_null() || !message.at("state").contains("choices")) return words;
    for (const json& one : message.at("state").at("choices")) words.push_back(one.at("words"));
    return words;
  };
  std::uint64_t question = 0;
  const auto comes_to_offer = [&](const std::vector<std::string>& words) {
    const json message = client.next_where([&](const json& m) { return offers(m) == words; });
    ASSERT_FALSE(message.is_null()) << words.front() << "\n" << command.err();
    question = message.at("state").at("question");
  };
  const auto choose = [&](const std::string& choice) {
    return post(port, "/api/live/choice", json{{"question", question}, {"choice", choice}}.dump()).status;
  };
  comes_to_offer({"Start fan, run 1", "Skip fan", "End the session"});
  EXPECT_EQ(choose("redo"), 409) << "there is no run yet";
  EXPECT_EQ(choose("start"), 200);
  EXPECT_EQ(choose("start"), 409) << "an answer to the same question";
  comes_to_offer({"Stop fan/01"});
  EXPECT_FALSE(client.next_where([](const json& m) { return m.at("state").at("recording").at("events") > 0; }).is_null());
  EXPECT_EQ(choose("stop"), 200);
  comes_to_offer({"Start mug, run 1", "Redo fan/01", "Skip mug", "End the session"});
  EXPECT_EQ(choose("redo"), 200);
  comes_to_offer({"Start fan, run 1", "Skip fan", "End the session"});
  EXPECT_EQ(choose("skip"), 200);
  comes_to_offer({"Start mug, run 1", "Skip mug", "End the session"});
  EXPECT_EQ(choose("start"), 200);
  comes_to_offer({"Stop mug/01"});
  EXPECT_EQ(choose("stop"), 200);
  comes_to_offer({"Redo mug/01", "End the session"});
  EXPECT_EQ(choose("end"), 200);
  const test::CommandResult result = command.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("ended by: stopped on the page"), std::string::npos) << result.err;
  EXPECT_TRUE(fs::exists(folder / "data/mug/01/events.aedat4"));
  EXPECT_FALSE(fs::exists(folder / "data/fan/01/events.aedat4"));
}

TEST_F(RecordPreview, ARunStoppedOnThePageBeforeItsDurationDoesNotCount) {
  std::ofstream(folder / "plan.json") << R"({"session": "monday", "objects": [{"name": "fan", "runs": 1}], "duration": 60})";
  RunningCommand command("record --from sim --speed 0.1 --session plan.json --out data --preview 0", folder.path());
  const std::uint16_t port = test::port_in(command.logged_after("preview at "));
  LiveClient client(port);
  command.type("\n");
  const json recording = client.next_where(is_recording);
  ASSERT_FALSE(recording.is_null());
  const std::uint64_t question = recording.at("state").at("question");
  const std::string stop = json{{"question", question}, {"choice", "stop"}}.dump();
  EXPECT_EQ(post(port, "/api/live/choice", stop).status, 200);
  const json waiting = client.next_where([&](const json& m) {
    return m.at("state").at("state") == "waiting" && m.at("state").at("question").get<std::uint64_t>() > question &&
           !m.at("state").at("choices").empty();
  });
  ASSERT_FALSE(waiting.is_null()) << command.err();
  EXPECT_EQ(waiting.at("state").at("choices").at(0).at("words"), "Start fan, run 1") << "it is asked for again";
  EXPECT_EQ(post(port, "/api/live/choice", stop).status, 409) << "of the question before";
  // The end of standard input ends nothing while a person can choose on the page.
  command.close_input();
  command.logged_after("standard input has ended");
  const json end{{"question", waiting.at("state").at("question")}, {"choice", "end"}};
  EXPECT_EQ(post(port, "/api/live/choice", end.dump()).status, 200);
  EXPECT_EQ(command.wait().exit_code, 0);
}

TEST_F(RecordPreview, ABrowserThatTakesNothingChangesNothingInTheRecording) {
  ASSERT_EQ(test::run_tactile("record --from sim --object fan --speed 0 --duration 2 --out without", folder.path()).exit_code, 0);
  // The session waits for Enter, so that the browser is there from the first event on.
  std::ofstream(folder / "plan.json") << R"({"session": "monday", "objects": [{"name": "fan", "runs": 1}], "duration": 2})";
  RunningCommand command("record --from sim --speed 0 --session plan.json --out with --preview 0", folder.path());
  const std::uint16_t port = test::port_in(command.logged_after("preview at "));
  const test::PageConnection stuck(port);
  stuck.send(test::request_text(port, "GET /api/live"));
  command.type("\n");
  command.close_input();
  const test::CommandResult result = command.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(test::events_in_file(folder / "with/fan/01/events.aedat4"),
            test::events_in_file(folder / "without/fan/01/events.aedat4"));
}

TEST_F(RecordPreview, APortInUseEndsTheCommandBeforeARun) {
  const RunningCommand first("record --from sim --object fan --speed 0.5 --preview 0 --out first", folder.path());
  const std::string port = std::to_string(test::port_in(first.logged_after("preview at ")));
  const test::CommandResult second = test::run_tactile("record --from sim --object fan --preview " + port, folder.path());
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_NE(second.err.find("another program uses this port"), std::string::npos) << second.err;
  EXPECT_FALSE(fs::exists(folder / "data"));
  const test::CommandResult wrong = test::run_tactile("record --from sim --preview 70000", folder.path());
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_NE(wrong.err.find("--preview '70000': is no port; expected 0 to 65535"), std::string::npos) << wrong.err;
}

TEST(DetectPage, ShowsVerdictsAndTheLastMinute) {
  static const test::Trained trained;
  const fs::path folder = trained.folder.path();
  RunningCommand command("detect --model models/small --from file:data/fan/01 --speed 0.1 --page 0 --json", folder);
  LiveClient client(test::port_in(command.logged_after("page at ")));
  const json message = client.next_where([](const json& m) {
    return !m.at("state").is_null() && !m.at("state").at("tick").is_null() && m.at("live").at("picture") > 0;
  });
  ASSERT_FALSE(message.is_null()) << command.err();
  EXPECT_EQ(message.at("columns"), json({"events_per_s", "p_press", "p_slip", "lateness_ms"}));
  const json& state = message.at("state");
  EXPECT_EQ(state.at("kind"), "detect");
  EXPECT_EQ(state.at("model"), "small");
  EXPECT_EQ(state.at("source"), "file:data/fan/01");
  const std::vector<double> p = state.at("tick").at("p");
  ASSERT_EQ(p.size(), 3U);
  EXPECT_NEAR(p[0] + p[1] + p[2], 1.0, 1e-5);
  EXPECT_GT(state.at("ticks").at("reported").get<std::uint64_t>(), 0U);
  EXPECT_TRUE(state.at("lateness").is_null()) << "a replay has no deadline";
  const json with_values =
      client.next_where([](const json& m) { return !m.at("steps").empty() && !m.at("steps").back().at(2).is_null(); });
  EXPECT_FALSE(with_values.is_null()) << "the chart has probabilities";
  command.signal(SIGINT);
  const json last = client.next_where([](const json& m) { return m.at("ended").get<bool>(); });
  ASSERT_FALSE(last.is_null());
  EXPECT_EQ(last.at("state").at("words"), "interrupted");
  EXPECT_EQ(command.wait().exit_code, 0);
}

TEST(DetectPage, AReplayHasTheSameVerdictsWithAPageThatNobodyReads) {
  const test::Trained trained({"fan"}, 2);
  const fs::path folder = trained.folder.path();
  const std::string detect = "detect --model models/small --from file:data/fan/01 --speed 0 --quiet --ticks ";
  ASSERT_EQ(test::run_tactile(detect + "without.csv", folder).exit_code, 0);
  ASSERT_EQ(test::run_tactile(detect + "with.csv --page 0", folder).exit_code, 0);
  EXPECT_EQ(test::text_in_file(folder / "with.csv"), test::text_in_file(folder / "without.csv"));
}

}  // namespace
}  // namespace tactile::live
