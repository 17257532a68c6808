#include "tactile/results/figure.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

Figure read(const nlohmann::json& json, MissingMember missing = MissingMember::is_null) {
  return JsonView(json, "eval.json", missing).get<Figure>();
}

TEST(Figure, ComesBackAsItWasWritten) {
  const nlohmann::json json = Figure{1.5, 1, 2, 7, 5};
  EXPECT_EQ(json.dump(), R"({"high":2.0,"low":1.0,"n":7,"trainings":5,"value":1.5})");
  const Figure whole = read(json, MissingMember::is_error);
  EXPECT_EQ(whole.value, 1.5);
  EXPECT_EQ(whole.low, 1);
  EXPECT_EQ(whole.high, 2);
  EXPECT_EQ(whole.n, 7U);
  EXPECT_EQ(whole.trainings, 5U);
  const Figure empty = read(Figure{}, MissingMember::is_error);
  EXPECT_TRUE(std::isnan(empty.value));
  EXPECT_FALSE(empty.has_interval());
}

TEST(Figure, MayBeANumberAloneOrNothing) {
  EXPECT_EQ(read(0.5).value, 0.5);
  EXPECT_FALSE(read(0.5).low.has_value());
  EXPECT_TRUE(std::isnan(read(nullptr).value));
  EXPECT_EQ(read({{"value", 1}, {"high", 2}}).high, 2);
}

TEST(Figure, IsRefusedByFileAndMember) {
  EXPECT_EQ(test::error_of([] { read({{"value", 1}}, MissingMember::is_error); }), "eval.json: 'low' is missing");
  EXPECT_EQ(test::error_of([] { read({{"value", "x"}}); }), "eval.json: 'value' is string; expected a number");
  EXPECT_EQ(test::error_of([] { read("x"); }), "eval.json is string; expected an object");
}

TEST(Figure, IsScaledWithItsInterval) {
  const Figure percent = scaled({0.5, 0.25, std::nullopt, 3}, 100);
  EXPECT_EQ(percent.value, 50);
  EXPECT_EQ(percent.low, 25);
  EXPECT_FALSE(percent.high.has_value());
  EXPECT_EQ(percent.n, 3U);
}

TEST(Figure, KeepsItsIntervalInOrderWhenItsSignChanges) {
  const Figure figure = scaled({.value = 0, .low = -1, .high = 0, .n = 3}, -1);
  EXPECT_FALSE(std::signbit(figure.value)) << "0, not -0";
  EXPECT_EQ(figure.low, 0);
  EXPECT_FALSE(std::signbit(*figure.low));
  EXPECT_EQ(figure.high, 1);
}

TEST(Figure, IsWrittenWithItsIntervalAndUnit) {
  const Figure figure{.value = 0.8832, .low = 0.8126, .high = 0.9449, .n = 10, .trainings = 5};
  EXPECT_EQ(text_of(scaled(figure, 100), " %"), "88.3 % [81.3, 94.5]");
  EXPECT_EQ(text_of(scaled(figure, -1), " ms", "+.2f"), "-0.88 ms [-0.94, -0.81]");
  EXPECT_EQ(text_of({.value = 4.0, .low = {}, .high = {}, .n = 2}, ""), "4.0");
  EXPECT_EQ(text_of(Figure{}, " ms"), "unknown");
}

TEST(Figure, WithoutAnIntervalIsExplainedOnceForAll) {
  const Figure whole{.value = 0.8832, .low = 0.8126, .high = 0.9449, .n = 10, .trainings = 5}, unmeasured;
  const Figure bare{.value = 4.0, .low = {}, .high = {}, .n = 2};
  EXPECT_EQ(note_on_intervals({whole, unmeasured}), "") << "unknown says enough";
  EXPECT_EQ(note_on_intervals({bare, whole, bare}),
            "A value without brackets has no 95 % interval: that needs three objects, or three runs of one object, and not "
            "two trainings.");
}

}  // namespace
}  // namespace tactile::results
