#include "tactile/model/bundle/temperature.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "evaluation/trained_model.hpp"
#include "support/error_of.hpp"
#include "tactile/model/training/calibrate_model.hpp"
#include "tactile/model/training/open_classifier.hpp"

namespace tactile::model {
namespace {

TEST(Temperature, MakesAHundredSureGuessesAsSureAsTheyAreRight) {
  // Two classes at odds of e^6 to 1; three of four are right. Then the best odds are 3 to 1: 6 / T = ln 3.
  const std::vector<Logits> logits(100, Logits{6, 0, -1000});
  std::vector<Touch> truth(100, Touch::none);
  for (std::size_t i = 0; i < 25; ++i) truth[i] = Touch::press;
  const double fitted = fitted_temperature(logits, truth);
  EXPECT_NEAR(fitted, 6 / std::log(3.0), 1e-6);
  EXPECT_NEAR(loss_at(logits, truth, fitted), -0.75 * std::log(0.75) - 0.25 * std::log(0.25), 1e-9);
  EXPECT_NEAR(probabilities_of(logits[0], fitted)[0], 0.75, 1e-6);
}

TEST(Temperature, StaysInItsRangeWhereAllAreRight) {
  const std::vector<Logits> logits(10, Logits{1, 0, 0});
  EXPECT_NEAR(fitted_temperature(logits, std::vector<Touch>(10, Touch::none)), 1.0 / 20, 1e-6);
}

TEST(Temperature, IsStoredInTheBundleAndReadWhereProbabilitiesAre) {
  const test::Trained trained({"fan", "usb-hub"}, 3);
  const windows::Dataset dataset(trained.file);
  const Classifier before(trained.bundle.folder, 1);
  EXPECT_EQ(before.temperature().value, 1);
  const std::vector<std::string> runs{"02"};
  const Temperature fitted = calibrate_model(dataset, trained.bundle, runs, 1);
  EXPECT_LE(fitted.loss_after, fitted.loss_before);
  ASSERT_EQ(fitted.fitted_on.size(), 2U);
  EXPECT_EQ(fitted.fitted_on[0].run, "fan/02");
  const Classifier after(trained.bundle.folder, 1);
  EXPECT_EQ(after.temperature().value, fitted.value);
  const std::uint32_t run = 2;
  const auto heatmaps = sample_heatmaps(dataset, after.rendering(), samples_of_runs(dataset, {&run, 1}), 1);
  EXPECT_EQ(after.verdicts(heatmaps), before.verdicts(heatmaps));
  EXPECT_EQ(after.probabilities(heatmaps).front(), probabilities_of(before.classify(heatmaps).front(), fitted.value));
  EXPECT_EQ(nlohmann::json(read_temperature(trained.bundle, after.model())), nlohmann::json(fitted));
}

TEST(Temperature, OfOtherWeightsIsRefused) {
  const test::Trained trained;
  const ModelDescription model = read_description(trained.bundle);
  write_temperature(trained.bundle, {.value = 2, .weights_sha256 = "other"});
  EXPECT_NE(test::error_of([&] { read_temperature(trained.bundle, model); }).find("was fitted to other weights"),
            std::string::npos);
  write_temperature(trained.bundle, {.value = -1, .weights_sha256 = model.weights_sha256});
  EXPECT_NE(test::error_of([&] { read_temperature(trained.bundle, model); }).find("expected one above 0"), std::string::npos);
}

TEST(Temperature, NeedsARunThatTheModelDidNotLearnFromAndOneToTestOn) {
  const test::Trained trained;
  const windows::Dataset dataset(trained.file);
  const std::vector<std::string> learned{"01"}, all{"02"};
  EXPECT_NE(test::error_of([&] { calibrate_model(dataset, trained.bundle, learned, 1); }).find("expected ids of other runs"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] { calibrate_model(dataset, trained.bundle, all, 1); }).find("no run is left to test"),
            std::string::npos);
}

}  // namespace
}  // namespace tactile::model
