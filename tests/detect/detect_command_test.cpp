#include "detect/detect_command.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "evaluation/trained_model.hpp"
#include "robot/fake_controller.hpp"
#include "support/error_of.hpp"
#include "support/events_in_file.hpp"
#include "support/held_port.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
#include "tactile/model/inference/two_thresholds.hpp"
#include "transport/scripted_server.hpp"

namespace tactile::detect {
namespace {

namespace fs = std::filesystem;
using test::rows_of;
using test::run_tactile;
using test::RunningCommand;
using test::Trained;
using test::trained;

using Row = test::TickRow;

/// The same decision in `eval`, whose default is each tick alone.
std::string eval_options(const std::string& detect_options) {
  for (const char* decision : {"--confirm", "--thresholds"}) {
    if (detect_options.find(decision) != std::string::npos) return detect_options;
  }
  return detect_options + " --thresholds " + text_of(model::TwoThresholds{});
}

TEST(DetectCommand, AgreesWithEvalAtEveryTickOfARecording) {
  const fs::path folder = trained().folder.path();
  for (const std::string options : {"", " --confirm 1/1", " --confirm 3/4", " --thresholds 0:-1:8"}) {
    const auto eval = run_tactile("eval --quiet --model small --run fan/02 --out offline" + eval_options(options), folder);
    ASSERT_EQ(eval.exit_code, 0) << eval.err;
    const std::vector<Row> offline = rows_of(folder / "offline/fan-02.csv");
    ASSERT_GT(offline.size(), 100U);
    for (const std::string speed : {"0", "7"}) {
      const auto live =
          run_tactile(fmt::format("detect --quiet --json --model small --from file:data/fan/02 --ticks live.csv --speed {}{}",
                                  speed, options),
                      folder);
      ASSERT_EQ(live.exit_code, 0) << live.err;
      const std::vector<Row> reported = rows_of(folder / "live.csv");
      ASSERT_EQ(reported.size(), offline.size()) << options;
      for (std::size_t i = 0; i < offline.size(); ++i) {
        for (const char* column : {"t_us", "verdict", "events"})
          ASSERT_EQ(reported[i].at(column), offline[i].at(column)) << column << " of tick " << i << options;
        ASSERT_NEAR(std::stod(reported[i].at("p_slip")), std::stod(offline[i].at("p_slip")), 1e-5);
      }
      const auto json = nlohmann::json::parse(live.out);
      EXPECT_EQ(json.at("ticks").at("reported"), offline.size());
      EXPECT_EQ(json.at("ticks").at("skipped"), 0);
      EXPECT_TRUE(json.at("ticks").at("late").is_null()) << "what is played has no deadline";
      EXPECT_TRUE(json.at("ticks").at("missed_share").is_null());
      EXPECT_EQ(json.at("ended"), "source ended");
      EXPECT_GT(json.at("verdicts").at("slip").get<int>(), 0);
      EXPECT_EQ(json.at("latency_us").at("network").at("count"), offline.size());
    }
  }
}

TEST(DetectCommand, DecidesByTwoThresholdsUnlessAnotherDecisionIsGiven) {
  const auto summary = [](const std::string& options) {
    const auto result =
        run_tactile("detect --json --quiet --model small --from file:data/fan/02 --speed 0" + options, trained().folder.path());
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out, nullptr, false);
  };
  const nlohmann::json usual = summary(""), single = summary(" --confirm 1/1");
  EXPECT_EQ(usual.at("thresholds"), "2.5:-1.5:20:3.5");
  EXPECT_TRUE(single.at("thresholds").is_null());
  EXPECT_EQ(summary(" --thresholds off").at("episodes"), single.at("episodes"));
  // A verdict holds until the log-odds were low for 20 ms: an episode ends later than by single ticks.
  const auto last_end = [](const nlohmann::json& of) {
    return of.at("episodes").at("first").back().at("last_us").get<std::int64_t>();
  };
  EXPECT_GE(last_end(usual), last_end(single) + 10'000);
}

TEST(DetectCommand, PrintsWhereEachEpisodeEnds) {
  const auto result = run_tactile("detect --quiet --model small --from file:data/fan/02 --speed 0", trained().folder.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::istringstream lines(result.out);
  std::string line, begun;
  int ended = 0;
  while (std::getline(lines, line) && !line.empty()) {
    if (line.find("confirmed at ") != std::string::npos) {
      EXPECT_EQ(begun.substr(0, 4), "slip") << line;
      continue;
    }
    const bool begins = line.find(" at ") != std::string::npos;
    EXPECT_NE(begins, line.find(" until ") != std::string::npos) << line;
    EXPECT_EQ(begins, begun.empty()) << line;
    if (!begins) {
      EXPECT_EQ(line.substr(0, 5), begun.substr(0, 5));
      ++ended;
    }
    begun = begins ? line : "";
  }
  EXPECT_GE(ended, 2);
  EXPECT_TRUE(begun.empty()) << begun;
}

TEST(DetectCommand, OfAStreamAgreesWithEvalAtEveryTick) {
  const Trained own;
  const fs::path folder = own.folder.path();
  const auto train = run_tactile("train --quiet --name other --kind stream --steps 100", folder);
  ASSERT_EQ(train.exit_code, 0) << train.err;
  for (const std::string options : {"", " --confirm 2/3"}) {
    const auto eval = run_tactile("eval --quiet --model other --run fan/02 --out offline" + eval_options(options), folder);
    ASSERT_EQ(eval.exit_code, 0) << eval.err;
    const std::vector<Row> offline = rows_of(folder / "offline/fan-02.csv");
    ASSERT_GT(offline.size(), 100U);
    const auto live =
        run_tactile("detect --quiet --json --model other --from file:data/fan/02 --ticks live.csv --speed 0" + options, folder);
    ASSERT_EQ(live.exit_code, 0) << live.err;
    const std::vector<Row> reported = rows_of(folder / "live.csv");
    ASSERT_EQ(reported.size(), offline.size()) << options;
    std::map<std::string, int> verdicts;
    for (std::size_t i = 0; i < offline.size(); ++i) {
      for (const char* column : {"t_us", "verdict", "events"})
        ASSERT_EQ(reported[i].at(column), offline[i].at(column)) << column << " of tick " << i << options;
      ASSERT_NEAR(std::stod(reported[i].at("p_slip")), std::stod(offline[i].at("p_slip")), 1e-6);
      ++verdicts[reported[i].at("verdict")];
    }
    // After 100 steps a stream is not yet sure enough for the thresholds.
    if (!options.empty()) {
      EXPECT_EQ(verdicts.size(), 3U) << "each class occurs";
    }
  }
  const auto finer = run_tactile("detect --model other --from file:data/fan/02 --speed 0 --tick-us 1000", folder);
  EXPECT_NE(finer.err.find("a tick of 1000 us; expected the 2000 us"), std::string::npos) << finer.err;
  const auto refused = run_tactile("detect --model other --from file:data/fan/02 --speed 0 --precision int8", folder);
  EXPECT_NE(refused.err.find("has no precision int8; expected fp32"), std::string::npos) << refused.err;
}

TEST(DetectCommand, AgreesWithEvalOnAStreamWithoutLateEvents) {
  const fs::path folder = trained().folder.path();
  ASSERT_EQ(run_tactile("eval --quiet --model small --run fan/02 --out offline" + eval_options(""), folder).exit_code, 0);
  std::map<std::string, Row> offline;
  for (const Row& row : rows_of(folder / "offline/fan-02.csv")) offline[row.at("t_us")] = row;
  RunningCommand server("serve data/fan/02 --port 0", folder);
  const std::string address = server.logged_after(" on ");
  const auto live =
      run_tactile("detect --json --model small --reconnect 0 --slack-us 500000 --ticks stream.csv --from " + address, folder);
  ASSERT_EQ(live.exit_code, 0) << live.err;
  const auto json = nlohmann::json::parse(live.out);
  EXPECT_EQ(json.at("ended"), "source ended");
  // On a machine that stood still the detector drops what waited and begins a new history: such ticks are not reported.
  const nlohmann::json& faults = json.at("faults").at("kinds");
  if (!faults.contains("behind") && !faults.contains("stopped")) {
    EXPECT_EQ(json.at("events").at("dropped"), 0);
  }
  const std::vector<Row> reported = rows_of(folder / "stream.csv");
  ASSERT_GT(reported.size(), 10U);
  std::int64_t last = 0;
  for (const Row& row : reported) {
    const std::int64_t t = std::stoll(row.at("t_us"));
    EXPECT_EQ(t % 2'000, 0);
    EXPECT_GT(t, last);
    last = t;
    const auto same = offline.find(row.at("t_us"));
    if (same == offline.end() || json.at("events").at("late") != 0 || row.at("incomplete") != "0") continue;
    EXPECT_EQ(row.at("events"), same->second.at("events")) << row.at("t_us");
    EXPECT_EQ(row.at("verdict"), same->second.at("verdict")) << row.at("t_us");
  }
}

/// The run's events, and one so long after the last.
fs::path with_an_event_ahead(const fs::path& name, microseconds ahead) {
  const fs::path folder = trained().folder.path();
  const events::RecordingReader recording(folder / "data/fan/02/events.aedat4");
  const events::Stream& stream = events::event_stream(recording);
  std::vector<events::Event> events = test::events_in_file(recording.file());
  events::RecordingWriter writer(folder / name, std::vector<events::Stream>{stream});
  writer.write_events(stream.id, std::span<const events::Event>(events));
  events::Event far = events.back();
  far.t = after(far.t, ahead);
  writer.write_events(stream.id, std::span<const events::Event>(&far, 1));
  writer.close();
  return folder / name;
}

TEST(DetectCommand, RejectsARecordingWithATimeAYearAheadLikeEval) {
  const fs::path folder = trained().folder.path();
  const fs::path file = with_an_event_ahead("year.aedat4", 365 * 24h);
  events::RecordingReader recording(file);
  const std::string of_eval = test::error_of([&] {
    heatmaps::for_every_tick(recording, events::event_stream(recording).id, {}, [](auto&&...) { FAIL() << "a tick"; });
  });
  const auto whole = run_tactile("detect --quiet --model small --speed 0 --ticks year.csv --from file:" + file.string(), folder);
  EXPECT_EQ(whole.exit_code, 1);
  EXPECT_NE(whole.err.find(of_eval), std::string::npos) << whole.err;
  EXPECT_FALSE(fs::exists(folder / "year.csv"));
  const auto piece =
      run_tactile("detect --quiet --json --model small --speed 0 --duration 0.4 --from file:" + file.string(), folder);
  EXPECT_EQ(piece.exit_code, 0) << piece.err;
  EXPECT_EQ(nlohmann::json::parse(piece.out).at("ticks").at("reported"), 200);
}

TEST(DetectCommand, AgreesWithEvalThroughASilence) {
  const fs::path folder = trained().folder.path();
  const fs::path file = with_an_event_ahead("minute.aedat4", 60s);
  std::vector<std::pair<std::string, std::string>> offline;
  events::RecordingReader recording(file);
  heatmaps::for_every_tick(recording, events::event_stream(recording).id, {}, [&](CameraTime t, auto, std::uint64_t events) {
    offline.emplace_back(std::to_string(us_of(t)), std::to_string(events));
  });
  ASSERT_GT(offline.size(), 30'000U);
  const auto result =
      run_tactile("detect --quiet --model small --speed 0 --ticks minute.csv --from file:" + file.string(), folder);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::vector<Row> reported = rows_of(folder / "minute.csv");
  ASSERT_EQ(reported.size(), offline.size());
  for (std::size_t i = 0; i < reported.size(); ++i) {
    ASSERT_EQ(reported[i].at("t_us"), offline[i].first);
    ASSERT_EQ(reported[i].at("events"), offline[i].second);
  }
}

TEST(DetectCommand, DoesNotCountMaskedPixels) {
  const fs::path folder = trained().folder.path();
  const test::TemporaryFolder own;
  const events::RecordingReader recording(folder / "data/fan/02/events.aedat4");
  const events::SensorSize sensor = *events::event_stream(recording).size;
  std::string mask = "x,y\n";  // the left half
  for (int y = 0; y < sensor.height; ++y) {
    for (int x = 0; x < sensor.width / 2; ++x) mask += std::to_string(x) + "," + std::to_string(y) + "\n";
  }
  write_whole(own / "mask.csv", mask);
  const auto events_with = [&](const std::string& options) {
    const auto result = run_tactile("detect --quiet --json --model small --from file:data/fan/02 --speed 0 --ticks '" +
                                        (own / "ticks.csv").string() + "'" + options,
                                    folder);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(nlohmann::json::parse(result.out).at("rendering").contains("mask"), !options.empty());
    std::uint64_t events = 0;
    for (const Row& row : rows_of(own / "ticks.csv")) events += std::stoull(row.at("events"));
    return events;
  };
  const std::uint64_t all = events_with(""), masked = events_with(" --mask '" + (own / "mask.csv").string() + "'");
  EXPECT_GT(masked, 0U);
  EXPECT_LT(masked, all);
}

TEST(DetectCommand, ReportsWhatIsWrong) {
  const fs::path folder = trained().folder.path();
  const auto expect_error = [&](const std::string& options, const std::string& words) {
    const auto result = run_tactile("detect --model small " + options, folder);
    EXPECT_NE(result.exit_code, 0) << options;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  };
  expect_error("--from file:data/fan/02 --bit 64", "--bit: --robot is missing");
  expect_error("--from file:data/fan/02 --slip-bit 64", "--slip-bit: --robot is missing");
  expect_error("--from file:data/fan/02 --latch", "--latch: --robot is missing; expected --robot HOST");
  expect_error("--from file:data/fan/02 --clear-ms 5", "--clear-ms: --robot is missing");
  expect_error("--from file:data/fan/02 --latch --clear-ms 5 --robot 127.0.0.1", "expected one of the two");
  expect_error("--from file:data/fan/02 --tick-us 3000", "expected a tick such as 2500 or 4000");
  expect_error("--from file:data/fan/02 --tick-us 41000", "expected 40000 at most");
  expect_error("--from sim:cup", "'cup' is no object that can be simulated; expected one of 3d-printed-object");
  expect_error("--from file:data/fan/02 --object fan", "--object: --record is missing; expected --record, too");
  expect_error("--from file:data/fan/02 --robot 127.0.0.1", "no bit is given");
  expect_error("--from file:data/fan/02 --robot 127.0.0.1 --bit 63", "64 to 127");
  expect_error("--from file:data/fan/02 --robot 127.0.0.1 --bit 70 --slip-bit 70", "is given twice");
  expect_error("--from file:data/fan/02 --udp nowhere", "expected HOST:PORT");
  expect_error("--from file:data/fan/02 --confirm 1/2", "more than half");
  expect_error("--from file:data/fan/02 --thresholds 1:2:20", "OFF <= ON");
  expect_error("--from file:data/fan/02 --thresholds 2:1:10 --confirm 2/3", "cannot be combined with --confirm 2/3");
  expect_error("--from file:nothing", "nothing");
  expect_error("--from sim:fan", "expected the heatmaps of 32 x 24 cells that models/small was trained on");
  expect_error("--from file:data/fan/02 --speed 0 --ticks no/such/place.csv", "cannot be written");
}

}  // namespace
}  // namespace tactile::detect
