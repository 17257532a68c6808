#include "tactile/evaluation/calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tactile::evaluation {
namespace {

TEST(Reliability, PutsAnUpperEdgeIntoTheBinBelowIt) {
  Reliability reliability;
  reliability.add(1.0, true);
  reliability.add(5.0 / 15, true);
  reliability.add(0.34, false);
  EXPECT_EQ(reliability.bins[14].samples, 1U);
  EXPECT_EQ(reliability.bins[4].samples, 1U);
  EXPECT_EQ(reliability.bins[5].samples, 1U);
  EXPECT_EQ(reliability.bins[5].correct, 0U);
}

TEST(CalibrationError, WeighsEachBinsGapByItsSamples) {
  Reliability reliability;
  // Three at 0.98, of which two are right; one at 0.5, wrong.
  for (const bool right : {true, true, false}) reliability.add(0.98, right);
  reliability.add(0.5, false);
  EXPECT_NEAR(calibration_error(reliability), (3 * std::abs(2.0 / 3 - 0.98) + 0.5) / 4, 1e-12);
  EXPECT_EQ(calibration_error({}), 0.0);
}

TEST(CalibrationError, IsNoneWhereProbabilitiesAreWhatTheyPromise) {
  Reliability reliability;
  for (int i = 0; i < 5; ++i) reliability.add(0.8, i < 4);
  EXPECT_NEAR(calibration_error(reliability), 0.0, 1e-12);
}

TEST(Calibration, FindsErrorsOfOppositeRunsOnlyWhereTheyDoNotCancel) {
  // One run is too sure, the other not enough: together they are right.
  Reliability sure, unsure;
  for (int i = 0; i < 10; ++i) sure.add(0.7, i < 5);
  for (int i = 0; i < 10; ++i) unsure.add(0.7, i < 9);
  const std::vector<RunReliability> runs{{{"fan"}, sure}, {{"box"}, unsure}, {{"none"}, {}}};
  const results::Calibration calibration = calibration_of(runs);
  EXPECT_NEAR(calibration.error.value, 0.0, 1e-12);
  EXPECT_EQ(calibration.error.n, 2U);
  EXPECT_NEAR(calibration.objects.at("fan").value, 0.2, 1e-12);
  EXPECT_NEAR(calibration.objects.at("box").value, 0.2, 1e-12);
  ASSERT_EQ(calibration.bins.size(), reliability_bins);
  const results::ReliabilityBin& bin = calibration.bins[10];
  EXPECT_EQ(bin.samples, 20U);
  EXPECT_NEAR(bin.confidence, 0.7, 1e-12);
  EXPECT_NEAR(bin.accuracy.value, 0.7, 1e-12);
  const nlohmann::json json = calibration;
  EXPECT_TRUE(json.at("bins").at(0).at("confidence").is_null());
  EXPECT_TRUE(json.at("bins").at(0).at("accuracy").at("value").is_null());
}

}  // namespace
}  // namespace tactile::evaluation
