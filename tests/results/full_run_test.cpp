#include "tactile/results/full_run.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

FullRun run_in(const nlohmann::json& json) { return JsonView(json, "predictions.json", MissingMember::is_error).get<FullRun>(); }

TEST(FullRun, ComesBackAsItWasWritten) {
  const FullRun run{.run = "fan/03",
                    .ticks = {.first = camera_time(6000), .count = 3, .tick = 2ms},
                    .verdicts = {Touch::none, Touch::slip, Touch::press},
                    .probabilities = {{1, 0, 0}, {0, 0.25F, 0.75F}, {0.1F, 0.9F, 1e-30F}},
                    .events = {0, 70'000'000'000, 1}};
  const nlohmann::json json = run;
  EXPECT_EQ(json.dump(), R"({"events":[0,70000000000,1],"first_us":6000,"predicted":"021","probabilities":")"
                         "3f8000000000000000000000000000003e8000003f4000003dcccccd3f6666660da24260"
                         R"(","run":"fan/03","tick_us":2000})");
  const FullRun read = run_in(json);
  EXPECT_EQ(read.run, "fan/03");
  EXPECT_EQ(read.ticks.first, camera_time(6000));
  EXPECT_EQ(read.ticks.count, 3);
  EXPECT_EQ(read.verdicts, run.verdicts);
  EXPECT_EQ(read.probabilities, run.probabilities);
  EXPECT_EQ(read.events, run.events);
}

TEST(FullRun, IsReadFromFilesOfEarlierVersions) {
  const auto earlier = nlohmann::json::parse(
      R"({"run": "fan/03", "first_us": 0, "tick_us": 2000, "said": "02", "probabilities": "", "events": [1, 2]})");
  const FullRun read = run_in(earlier);
  EXPECT_EQ(read.verdicts, (std::vector{Touch::none, Touch::slip}));
}

TEST(FullRun, IsRefusedByFileAndMember) {
  const auto error_of = [](const char* text) { return test::error_of([&] { run_in(nlohmann::json::parse(text)); }); };
  EXPECT_EQ(error_of(R"({"run": "a", "first_us": 0})"), "predictions.json: 'tick_us' is missing");
  EXPECT_EQ(error_of(R"({"run": "a", "first_us": 0, "tick_us": 2, "predicted": "03", "events": [1, 2]})"),
            "predictions.json: 'predicted' has a digit other than 0, 1 and 2");
  EXPECT_EQ(error_of(R"({"run": "a", "first_us": 0, "tick_us": 2, "predicted": "01", "events": [1, -2]})"),
            "predictions.json: 'events' has a value that is not a whole number from 0 on");
  EXPECT_EQ(error_of(R"({"run": "a", "first_us": 0, "tick_us": 2, "predicted": "01", "probabilities": "", "events": [1]})"),
            "predictions.json: the numbers of verdicts and event counts differ; expected a full run of a model");
  for (const char* probabilities :
       {"3f800000", "3f80000000000000-0000000", "3f8000000000000040000000", "7fc000000000000000000000"}) {
    EXPECT_EQ(
        error_of((R"({"run": "a", "first_us": 0, "tick_us": 2, "predicted": "0", "events": [1], "probabilities": ")" +
                  std::string(probabilities) + "\"}")
                     .c_str()),
        "predictions.json: 'probabilities' are not three float32 from 0 to 1 per tick; expected 24 hexadecimal digits each");
  }
}

}  // namespace
}  // namespace tactile::results
