#include "tactile/results/unseen_comparison.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

UnseenComparison comparison_in(const nlohmann::json& json) { return JsonView(json, "eval-unseen.json").get<UnseenComparison>(); }

TEST(UnseenComparison, ComesBackAsItWasWritten) {
  UnseenComparison comparison;
  comparison.models = {"with", "without"};
  comparison.runs = {"fan/02"};
  comparison.mean.difference.value = -0.1;
  comparison.objects["fan"] = {{.value = 0.9}, {.value = 0.8}, {-0.1, -0.2, 0, 3}};
  const nlohmann::json json = comparison;
  EXPECT_EQ(json.at("objects").at("fan").at("held_out").at("value"), 0.8);
  const UnseenComparison read = comparison_in(json);
  ASSERT_TRUE(read.models);
  EXPECT_EQ(read.models->held_out, "without");
  EXPECT_EQ(read.runs, std::vector<std::string>{"fan/02"});
  EXPECT_EQ(read.mean.difference.value, -0.1);
  EXPECT_EQ(read.objects.at("fan").difference.low, -0.2);
  EXPECT_EQ(nlohmann::json(read), json);
}

TEST(UnseenComparison, OfAStudyNamesNoModels) {
  const nlohmann::json json = UnseenComparison{};
  EXPECT_EQ(json.size(), 3U);
  EXPECT_FALSE(comparison_in(json).models);
  EXPECT_TRUE(comparison_in(nullptr).objects.empty());
}

TEST(UnseenComparison, IsRefusedByFileAndMember) {
  EXPECT_EQ(test::error_of([] {
              comparison_in({{"objects", {{"fan", {{"seen", "x"}}}}}});
            }),
            "eval-unseen.json: 'objects': 'fan': 'seen' is string; expected an object");
}

}  // namespace
}  // namespace tactile::results
