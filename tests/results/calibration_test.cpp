#include "tactile/results/calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

TEST(Calibration, ComesBackAsItWasWritten) {
  Calibration calibration;
  calibration.error = {0.03, 0.02, 0.05, 9};
  calibration.objects["fan"].value = 0.04;
  calibration.bins.push_back({.from = 0.4, .to = 0.5});
  calibration.bins.push_back({.from = 0.9, .to = 1, .samples = 50, .confidence = 0.97, .accuracy = {.value = 0.95}});
  const nlohmann::json json = calibration;
  EXPECT_TRUE(json.at("bins").at(0).at("confidence").is_null());
  const auto read = JsonView(json, "eval.json", MissingMember::is_error).get<Calibration>();
  EXPECT_EQ(read.error.high, 0.05);
  EXPECT_EQ(read.objects.at("fan").value, 0.04);
  ASSERT_EQ(read.bins.size(), 2U);
  EXPECT_TRUE(std::isnan(read.bins[0].confidence));
  EXPECT_EQ(read.bins[1].samples, 50U);
  EXPECT_EQ(read.bins[1].accuracy.value, 0.95);
  EXPECT_EQ(nlohmann::json(read), json);
}

TEST(Calibration, IsRefusedByFileAndMember) {
  const nlohmann::json json = {{"bins", {{{"from", "x"}}}}};
  EXPECT_EQ(test::error_of([&] { JsonView(json, "eval.json").get<Calibration>(); }),
            "eval.json: 'bins': 'from' is string; expected a number");
}

}  // namespace
}  // namespace tactile::results
