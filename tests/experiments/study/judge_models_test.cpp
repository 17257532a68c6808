#include "tactile/experiments/study/judge_models.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/truth.hpp"

namespace tactile::study {
namespace {

TEST(JudgedModels, DetectionsComeBackAsTheyWereWritten) {
  results::Detection late, missed;
  late.interval = {Touch::slip, camera_time(1'700'000'000'000'001), camera_time(1'700'000'000'400'000)};
  late.outcome = results::DetectionOutcome::detected;
  late.delay = 6ms;
  missed.interval = {Touch::press, camera_time(5), camera_time(7)};
  nlohmann::json evaluation = {
      {"runs", {{{"run", "fan/03"}, {"object", "fan"}, {"training", 2U}, {"intervals", {late, missed}}}}}};
  const auto runs = detections_in(evaluation, "eval.json");
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs[0].object, "fan");
  EXPECT_EQ(runs[0].run, "03");
  EXPECT_EQ(runs[0].training, 2U);
  ASSERT_EQ(runs[0].detections.size(), 2U);
  EXPECT_EQ(runs[0].detections[0].interval.start, late.interval.start);
  EXPECT_EQ(runs[0].detections[0].delay, 6ms);
  EXPECT_EQ(runs[0].detections[1].outcome, results::DetectionOutcome::missed);
  evaluation.at("runs")[0].at("intervals")[1].at("outcome") = "late";
  EXPECT_EQ(test::error_of([&] { detections_in(evaluation, "eval.json"); }),
            "eval.json: 'runs': 'intervals': 'outcome' is 'late'; expected detected, missed or early");
}

TEST(RunToShow, HasATruePressAndATrueSlip) {
  const test::TemporaryFolder folder;
  const auto run = [&](const std::string& object, const std::string& id, const std::vector<Touch>& touches) {
    Truth truth;
    for (const Touch touch : touches) {
      const CameraTime start = camera_time(1'000'000 * static_cast<std::int64_t>(truth.intervals.size() + 1));
      truth.intervals.push_back({{touch, start, after(start, 100ms)}, {}, {}});
    }
    const std::filesystem::path at = folder / object / id;
    std::filesystem::create_directories(at);
    write_truth(at / "truth.json", truth);
    return RunFolder{at, object, id};
  };
  const std::vector<RunFolder> runs{run("fan", "02", {Touch::press, Touch::slip}), run("water-bottle", "02", {Touch::press}),
                                    run("water-bottle", "03", {Touch::press, Touch::slip})};
  EXPECT_EQ(run_to_show(runs), 2U) << "a firm lift has no slip";
  EXPECT_EQ(run_to_show({runs[0], runs[1]}), 0U) << "else another object";
  EXPECT_EQ(run_to_show({run("fan", "03", {Touch::slip}), runs[1]}), 1U) << "else the paper's object";
}

TEST(JudgedModels, AtTheFirstTickMeansWithoutDelayMissOrEarlyDetection) {
  const auto at_first_tick = detected_at_first_tick({{"a", {.mean_ms = {.value = 2}, .intervals = 2}},
                                                     {"b", {.mean_ms = {.value = 2}, .intervals = 2, .misses = 1}},
                                                     {"c", {.mean_ms = {.value = 3}, .intervals = 2}}},
                                                    2);
  EXPECT_TRUE(at_first_tick.at("a"));
  EXPECT_FALSE(at_first_tick.at("b"));
  EXPECT_FALSE(at_first_tick.at("c"));
}

}  // namespace
}  // namespace tactile::study
