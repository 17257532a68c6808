#include "tactile/results/claim.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

Claim claim_in(const nlohmann::json& json) { return JsonView(json, "study.json").get<Claim>(); }

TEST(Claim, ComesBackAsItWasWritten) {
  Claim claim;
  claim.id = "accuracy-at-40";
  claim.claim = "With 40 ms the accuracy is above 95 %";
  claim.paper = "above 95 %";
  claim.unit = "%";
  claim.asked = Asked::above;
  claim.limit = 95;
  claim.measured = {96, 95.5, 97, 3};
  claim.objects["fan"] = {.value = 96};
  claim.kept = claim.of = 3;
  claim.outcome = Outcome::holds;
  claim.can_be_decided = true;
  claim.all_test = ClaimOutcome{.in_words = "Above 95 %.", .outcome = Outcome::does_not, .why = "", .note = "a note"};
  const nlohmann::json json = claim;
  EXPECT_EQ(json.at("asked"), "above");
  EXPECT_EQ(json.at("verdict"), "holds");
  EXPECT_EQ(json.at("kept"), 3);
  EXPECT_EQ(json.at("all_test").size(), 9U);
  EXPECT_TRUE(json.at("all_test").at("kept").is_null());
  const Claim read = claim_in(json);
  EXPECT_EQ(read.limit, 95);
  EXPECT_EQ(read.measured.low, 95.5);
  EXPECT_EQ(read.objects.at("fan").value, 96);
  EXPECT_EQ(read.of, 3U);
  ASSERT_TRUE(read.all_test);
  EXPECT_EQ(read.all_test->outcome, Outcome::does_not);
  EXPECT_EQ(read.all_test->note, "a note");
  EXPECT_EQ(nlohmann::json(read), json);
}

TEST(Claim, MayLackWhatOlderStudiesDidNotWrite) {
  const Claim claim = claim_in({{"verdict", "holds"}});
  EXPECT_TRUE(std::isnan(claim.limit));
  EXPECT_TRUE(claim.can_be_decided) << "not known to be otherwise";
  EXPECT_FALSE(claim.kept || claim.all_test);
  EXPECT_EQ(claim_in(nlohmann::json::object()).outcome, Outcome::cannot_tell);
}

TEST(Claim, IsReadFromFilesOfEarlierVersions) {
  EXPECT_FALSE(claim_in({{"verdict", "cannot tell"}, {"can_be_told", false}}).can_be_decided);
}

TEST(Claim, IsRefusedByFileAndMember) {
  EXPECT_EQ(test::error_of([] {
              claim_in({{"verdict", "maybe"}});
            }),
            "study.json: 'verdict' is 'maybe'; expected 'holds', 'does not' or 'cannot tell'");
  EXPECT_EQ(test::error_of([] {
              claim_in({{"objects", {{"fan", {{"value", "x"}}}}}});
            }),
            "study.json: 'objects': 'fan': 'value' is string; expected a number");
}

}  // namespace
}  // namespace tactile::results
