#include "tactile/labels/label_options.hpp"

#include <gtest/gtest.h>

#include <opencv2/core/types.hpp>

namespace tactile::labels {
namespace {

TEST(SignalsOptions, AreThoseOfTheLabelsSettings) {
  LabelOptions options;
  options.signals.video.region = cv::Rect(10, 20, 300, 200);
  options.signals.rate.mask = {{1, 2}, {30, 40}};
  options.signals.robot.columns = "timestamp,actual_q*6";
  const alignment::RunSignalsOptions read = signals_options_of({{"settings", settings_of(options)}});
  EXPECT_EQ(read.video.region, options.signals.video.region);
  EXPECT_EQ(read.rate.mask, options.signals.rate.mask);
  EXPECT_EQ(read.robot.columns, options.signals.robot.columns);
}

TEST(SignalsOptions, AreTheDefaultsWhereAnotherProgramMadeTheLabels) {
  for (const char* provenance : {"{}", "null", "[1]", R"({"settings": 3})",
                                 R"({"settings": {"video": {"region": [1, 2, 3]}, "rate": {"mask": [7, [1]]}}})",
                                 R"({"settings": {"video": {"region": "1,2,3,4"}, "rate": {"mask": {"x": 1}}}})"}) {
    const alignment::RunSignalsOptions read = signals_options_of(nlohmann::json::parse(provenance));
    EXPECT_FALSE(read.video.region) << provenance;
    EXPECT_TRUE(read.rate.mask.empty()) << provenance;
  }
}

}  // namespace
}  // namespace tactile::labels
