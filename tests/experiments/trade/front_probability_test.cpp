#include "tactile/experiments/trade/front_probability.hpp"

#include <gtest/gtest.h>

namespace tactile::trade {
namespace {

/// A cell with 100 samples, one press that is detected after `delay_us`, and a minute without alarms.
results::Cell cell(const std::string& object, std::size_t training, std::uint64_t right, double delay_us = 5000) {
  results::Cell run;
  run.object = object;
  run.run = "02";
  run.training = training;
  run.samples.counts[0][0] = right;
  run.samples.counts[0][1] = 100 - right;
  run.touches = {{Touch::press, results::DetectionOutcome::detected, delay_us / 1000}};
  run.outside_s = 60;
  return run;
}

TimedRun timed(const std::string& object, float us) {
  TimedRun run;
  run.object = object;
  run.run = "02";
  run.tick_us = {us};
  return run;
}

const std::vector<std::string> objects{"a", "b", "c", "d"};

TEST(FrontProbabilities, AreOneForWhatIsBestInAllAndNoneForWhatItBeats) {
  std::vector<FrontCandidate> candidates(2);
  for (const std::string& object : objects) {
    candidates[0].runs.push_back(cell(object, 0, 90, 9000));
    candidates[0].timed.push_back(timed(object, 200));
    candidates[1].runs.push_back(cell(object, 0, 95, 4000));
    candidates[1].timed.push_back(timed(object, 100));
  }
  const auto probabilities = front_probabilities(candidates, 2);
  EXPECT_EQ(probabilities[0].accuracy, 0);
  EXPECT_EQ(probabilities[0].delay, 0);
  EXPECT_EQ(probabilities[1].accuracy, 1);
  EXPECT_EQ(probabilities[1].delay, 1);
}

TEST(FrontProbabilities, DrawObjects) {
  // Each is better on two of the four objects, and as fast. Of four drawn objects, the sum of the signs is above 0 with 5/16 and
  // 0 with 6/16: of equal ones, the first is on the front.
  std::vector<FrontCandidate> candidates(2);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    candidates[0].runs.push_back(cell(objects[i], 0, i < 2 ? 75 : 50));
    candidates[1].runs.push_back(cell(objects[i], 0, i < 2 ? 50 : 75));
    for (FrontCandidate& candidate : candidates) candidate.timed.push_back(timed(objects[i], 100));
  }
  const auto probabilities = front_probabilities(candidates, 2);
  EXPECT_NEAR(probabilities[0].accuracy.value_or(-1), 11.0 / 16, 0.04);
  EXPECT_NEAR(probabilities[1].accuracy.value_or(-1), 5.0 / 16, 0.04);
  EXPECT_EQ(front_probabilities(candidates, 1)[0].accuracy, probabilities[0].accuracy) << "whatever the threads";
}

TEST(FrontProbabilities, DrawTrainings) {
  // Each is better with one of the two trainings: both draws of this one, with 1/4, or one of each, with 1/2, where they are
  // equal.
  std::vector<FrontCandidate> candidates(2);
  for (const std::string& object : objects) {
    for (const std::size_t training : {0U, 1U}) {
      candidates[0].runs.push_back(cell(object, training, training == 0 ? 75 : 50));
      candidates[1].runs.push_back(cell(object, training, training == 0 ? 50 : 75));
    }
    for (FrontCandidate& candidate : candidates) candidate.timed.push_back(timed(object, 100));
  }
  const auto probabilities = front_probabilities(candidates, 2);
  EXPECT_NEAR(probabilities[0].accuracy.value_or(-1), 0.75, 0.04);
  EXPECT_NEAR(probabilities[1].accuracy.value_or(-1), 0.25, 0.04);
}

TEST(FrontProbabilities, AreUnknownWithFewObjects) {
  std::vector<FrontCandidate> candidates(1);
  for (const char* object : {"a", "b"}) {
    candidates[0].runs.push_back(cell(object, 0, 90));
    candidates[0].timed.push_back(timed(object, 100));
  }
  EXPECT_FALSE(front_probabilities(candidates, 1)[0].accuracy);
}

}  // namespace
}  // namespace tactile::trade
