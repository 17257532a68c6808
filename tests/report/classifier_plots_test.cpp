#include "tactile/report/classifier_plots.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>

#include "report/plot_rows.hpp"
#include "support/drawn_plot.hpp"

namespace tactile::report {
namespace {

using test::contains;
using test::drawn;
using test::has_row;

TEST(ConfusionPlot, ShowsCountsAndSharesOfTheRow) {
  const std::string svg = drawn(confusion_plot("Confusion", {.counts = {{{90, 10, 0}, {1, 3, 0}, {0, 0, 0}}}}));
  for (const char* words : {"90.0 %", "10.0 %", "75.0 %", "25.0 %", "no sample", "predicted", "true", ">90<", ">3<"})
    EXPECT_TRUE(contains(svg, words)) << words;
}

TEST(ReliabilityPlot, HoldsAccuracyByCertaintyAndLeavesEmptyBinsOut) {
  const pictures::Plot plot = reliability_plot(
      "Reliability", {{.from = 0.4, .to = 0.5, .samples = 0, .confidence = NAN, .accuracy = {}},
                      {.from = 0.9, .to = 1, .samples = 500, .confidence = 0.97, .accuracy = {0.95, 0.93, 0.97, 10}}});
  EXPECT_TRUE(has_row(plot, {97, 95, 93, 97}));
  EXPECT_TRUE(has_row(plot, {95, 500, 90, 100, 0.8, 500}));
  EXPECT_TRUE(contains(drawn(plot), "largest probability [%]"));
  drawn(reliability_plot("Nothing", {}));
}

TEST(ReliabilityPlot, DrawsWhatStandsOnFewSamplesHollow) {
  const pictures::Plot plot = reliability_plot(
      "Reliability", {{.from = 0.4, .to = 0.5, .samples = few_samples - 1, .confidence = 0.45, .accuracy = {.value = 1}},
                      {.from = 0.9, .to = 1, .samples = few_samples, .confidence = 0.97, .accuracy = {0.95, 0.93, 0.97, 10}}});
  ASSERT_GE(plot.tables.size(), 2U);
  EXPECT_EQ(plot.tables[0].values, (std::vector<double>{97, 95, 93, 97}));
  EXPECT_EQ(plot.tables[1].values, (std::vector<double>{45, 100, 100, 100}));
  EXPECT_TRUE(contains(drawn(plot), ">fewer than 20 samples<"));
}

TEST(TrainingPlot, HasMoreThanOneTicOnTheAxisOfLosses) {
  const std::string svg = drawn(training_plot(
      "Training",
      {{.name = "a", .epochs = {{.epoch = 1, .loss = 0.5, .accuracy = 0.8}, {.epoch = 2, .loss = 0.03, .accuracy = 0.9}}}}));
  for (const char* tic : {">0.05<", ">0.1<", ">0.2<", ">0.5<"}) EXPECT_TRUE(contains(svg, tic)) << tic << svg;
}

TEST(TrainingPlot, NamesEightTrainingsAndCountsTheRest) {
  std::vector<TrainingCurve> curves;
  curves.reserve(11);
  for (int i = 0; i < 11; ++i) {
    curves.push_back({.name = fmt::format("model-{}", i),
                      .epochs = {{.epoch = 1, .loss = 0.5, .accuracy = 0.8, .validation_accuracy = NAN},
                                 {.epoch = 2, .loss = 0.1, .accuracy = 0.97, .validation_accuracy = 0.9}}});
  }
  const pictures::Plot plot = training_plot("Training", curves);
  EXPECT_TRUE(has_row(plot, {2, 0.1, 97, 90}));
  const std::string svg = drawn(plot);
  EXPECT_TRUE(contains(svg, "model-7"));
  EXPECT_FALSE(contains(svg, "model-8"));
  EXPECT_TRUE(contains(svg, ">3 more<"));
  EXPECT_TRUE(contains(svg, "validation"));
  drawn(training_plot("Nothing", {}));
  drawn(training_plot("No epoch", {{.name = "a", .epochs = {}}}));
}

}  // namespace
}  // namespace tactile::report
