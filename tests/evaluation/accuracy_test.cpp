#include "tactile/evaluation/accuracy.hpp"

#include <gtest/gtest.h>

#include "support/verdict_row.hpp"
#include "tactile/core/error.hpp"

namespace tactile::evaluation {
namespace {

using test::verdict_row;

/// `correct` of `samples` presses predicted right, the others taken for none.
results::Cell run_with(const std::string& object, std::uint64_t correct, std::uint64_t samples) {
  results::Cell run{{object}};
  for (std::uint64_t i = 0; i < samples; ++i) run.samples.add(Touch::press, i < correct ? Touch::press : Touch::none);
  return run;
}

TEST(Confusion, HasTheTruthInRowsAndThePredictionInColumns) {
  results::Confusion confusion;
  const std::vector<Touch> truth = verdict_row("..pppsss"), predicted = verdict_row(".pppss.s");
  for (std::size_t i = 0; i < truth.size(); ++i) confusion.add(truth[i], predicted[i]);
  const nlohmann::json json = confusion;
  EXPECT_EQ(json, nlohmann::json::parse("[[1, 1, 0], [0, 2, 1], [1, 0, 2]]"));
  EXPECT_EQ(confusion.samples(), 8U);
  EXPECT_EQ(confusion.correct(), 5U);
  EXPECT_DOUBLE_EQ(*confusion.accuracy(), 0.625);
}

TEST(Confusion, HasNoAccuracyWithoutSamples) { EXPECT_FALSE(results::Confusion{}.accuracy().has_value()); }

TEST(Accuracy, PoolsTheSamplesOfAnObjectAndAveragesOverObjects) {
  const std::vector<results::Cell> runs{run_with("fan", 1, 2), run_with("fan", 6, 6), run_with("box", 1, 4)};
  const results::Accuracy accuracy = accuracy_of(runs);
  EXPECT_DOUBLE_EQ(accuracy.objects.at("fan").value, 7.0 / 8);
  EXPECT_DOUBLE_EQ(accuracy.objects.at("box").value, 0.25);
  EXPECT_DOUBLE_EQ(accuracy.mean.value, (7.0 / 8 + 0.25) / 2);
  EXPECT_EQ(accuracy.objects.at("fan").n, 2U);
  EXPECT_EQ(accuracy.mean.n, 3U) << "runs of these two objects";
}

TEST(Accuracy, LeavesOutRunsWithoutSamples) {
  const std::vector<results::Cell> runs{run_with("fan", 1, 2), run_with("fan", 0, 0), run_with("box", 0, 0)};
  const results::Accuracy accuracy = accuracy_of(runs);
  EXPECT_EQ(accuracy.objects.at("fan").n, 1U);
  EXPECT_EQ(accuracy.objects.count("box"), 0U);
  EXPECT_EQ(accuracy.mean.n, 1U);
}

TEST(Accuracy, IsTheMeanOverWorldsOfTheirMeansOverObjects) {
  // In world 1 fan has 1 of 1 and box 5 of 10; the others have 1 of 2 in all.
  std::vector<results::Cell> cells{run_with("fan", 1, 1), run_with("box", 5, 10)};
  for (results::Cell& cell : cells) cell.world = "1";
  for (const char* world : {"2", "3"}) {
    for (const char* object : {"fan", "box"}) {
      cells.push_back(run_with(object, 1, 2));
      cells.back().world = world;
    }
  }
  const results::Accuracy accuracy = accuracy_of(cells);
  EXPECT_DOUBLE_EQ(accuracy.mean.value, (0.75 + 0.5 + 0.5) / 3);
  EXPECT_EQ(accuracy.mean.n, 3U);
  ASSERT_TRUE(accuracy.mean.has_interval());
  EXPECT_DOUBLE_EQ(accuracy.objects.at("fan").value, (1 + 0.5 + 0.5) / 3);
  EXPECT_EQ(accuracy.objects.at("fan").n, 3U);
}

TEST(AccuracyDifference, IsPairedOverTheSameRuns) {
  // Runs differ wildly, but the second is one sample in ten better in each: the paired difference has no spread.
  // Nine equal runs leave room for 3.69 in nine that differ by a sample: h = 0.041, as of 2264 trials. From SciPy.
  std::vector<results::Cell> a, b;
  for (std::uint64_t i = 0; i < 9; ++i) {
    a.push_back(run_with("fan", i, 10));
    b.push_back(run_with("fan", i + 1, 10));
  }
  const results::Figure difference = accuracy_difference(a, b).objects.at("fan");
  EXPECT_NEAR(difference.value, 0.1, 1e-12);
  EXPECT_NEAR(*difference.low, 0.05846346756272869, 1e-9);
  EXPECT_NEAR(*difference.high, 0.1412773518316659, 1e-9);
  EXPECT_GT(*accuracy_of(a).objects.at("fan").high - *accuracy_of(a).objects.at("fan").low, 0.1);
}

TEST(AccuracyDifference, RefusesRunsThatAreNotTheSame) {
  const std::vector<results::Cell> a{run_with("fan", 1, 2)}, b{run_with("box", 1, 2)};
  EXPECT_THROW(accuracy_difference(a, b), Error);
}

}  // namespace
}  // namespace tactile::evaluation
