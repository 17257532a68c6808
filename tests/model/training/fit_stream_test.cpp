#include "tactile/model/training/fit_stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "model/stream_data.hpp"
#include "tactile/core/error.hpp"
#include "tactile/model/inference/stream_network.hpp"

namespace tactile::model {
namespace {

using Layout = StreamLayout;
using Image = StreamImage;
constexpr StreamGrid grid{0, 0, 160, 120};

std::vector<StreamRun> runs_of(std::initializer_list<std::uint64_t> seeds) {
  std::vector<StreamRun> runs;
  for (const std::uint64_t seed : seeds) runs.push_back(test::made_stream_run(seed));
  return runs;
}

/// The logits of every tick of a run, by our engine.
std::vector<Logits> logits_of(const StreamRun& run, const Weights& weights) {
  const StreamNetwork network(weights);
  StreamCounts counts({160, 120}, grid);
  StreamState state;
  std::vector<Logits> logits;
  for (std::size_t k = 0; k < run.ticks; ++k) {
    counts.clear();
    for (std::size_t polarity = 0; polarity < 2; ++polarity) {
      for (std::size_t row = 0; row < Image::rows; ++row) {
        for (std::size_t column = 0; column < Image::columns; ++column) {
          const auto x = static_cast<std::int16_t>((column * 160 + Image::columns - 1) / Image::columns);
          const auto y = static_cast<std::int16_t>((row * 120 + Image::rows - 1) / Image::rows);
          for (unsigned n = run.at(k)[Image::at(polarity, row, column)]; n > 0; --n)
            counts.count({CameraTime{0us}, x, y, static_cast<std::uint8_t>(polarity), {}});
        }
      }
    }
    network.advance(counts, state);
    logits.push_back(state.logits);
  }
  return logits;
}

TEST(StreamCrops, AreTheSameForASeedAndAStepOnAnyNumberOfThreads) {
  const std::vector<StreamRun> runs = runs_of({1, 2, 3});
  const StreamCrops crops(runs, 5);
  const StreamBatch batch = crops.batch(7, 1), again = crops.batch(7, 3);
  EXPECT_EQ(batch.inputs, again.inputs);
  EXPECT_EQ(batch.truth, again.truth);
  EXPECT_EQ(batch.weights, again.weights);
  EXPECT_NE(crops.batch(8, 1).inputs, batch.inputs);
  EXPECT_NE(StreamCrops(runs, 6).batch(7, 1).inputs, batch.inputs);
  EXPECT_EQ(batch.truth.size(), StreamCrops::crops * StreamCrops::ticks);
  EXPECT_THROW(StreamCrops({}, 1), Error);
}

TEST(StreamCrops, HoldTouchesAndWhatIsNone) {
  const std::vector<StreamRun> runs = runs_of({1, 2, 3});
  const StreamCrops crops(runs, 1);
  std::array<std::size_t, touch_count> ticks{};
  std::size_t heavy = 0, left_out = 0;
  for (std::uint64_t step = 0; step < 20; ++step) {
    const StreamBatch batch = crops.batch(step, 2);
    for (std::size_t i = 0; i < batch.truth.size(); ++i) {
      ++ticks[static_cast<std::size_t>(batch.truth[i])];
      heavy += batch.truth[i] == 0 && batch.weights[i] == 2 ? 1U : 0U;
      left_out += batch.weights[i] == 0 ? 1U : 0U;
    }
    EXPECT_TRUE(std::all_of(batch.inputs.begin(), batch.inputs.end(), [](float value) { return value >= 0 && value < 10; }));
  }
  for (const std::size_t of_class : ticks) EXPECT_GT(of_class, 3'000U);
  EXPECT_GT(heavy, 500U) << "motion that is no touch";
  EXPECT_GT(left_out, 1'000U) << "the first ticks of a piece";
}

TEST(StreamCrops, InputsAreLogarithmsOfCellsAndOfTheirSum) {
  std::vector<std::uint8_t> counts(Image::size);
  counts[Image::at(0, 0, 0)] = 1;
  counts[Image::at(0, 0, Image::fine - 1)] = 2;
  counts[Image::at(0, 0, Image::fine)] = 200;
  counts[Image::at(0, 1, Image::fine * (Layout::columns + 1))] = 1;  // place 1, row 1, column 1
  std::vector<float> inputs(Layout::places * (Layout::cells_of_place + 1));
  stream_inputs(counts, inputs);
  EXPECT_FLOAT_EQ(inputs[0], std::log1p(3.0F));
  EXPECT_FLOAT_EQ(inputs[1], std::log1p(200.0F));
  EXPECT_FLOAT_EQ(inputs[Layout::cells_of_place], std::log1p(203.0F));
  EXPECT_FLOAT_EQ(inputs[Layout::cells_of_place + 1 + 5], std::log1p(1.0F));
  EXPECT_FLOAT_EQ(inputs.back(), 0);
}

TEST(FitStream, LearnsAndPredictsWhatLibtorchPredicts) {
  const std::vector<StreamRun> runs = runs_of({1, 2, 3, 4});
  std::size_t epochs = 0;
  const FittedStream fitted =
      fit_stream(runs, grid, {.steps = 150}, 1, {}, [&](const std::vector<EpochResult>& finished) { epochs = finished.size(); });
  ASSERT_EQ(fitted.history.size(), 2U) << "of 100 steps and of 50";
  EXPECT_EQ(epochs, 2U);
  EXPECT_LT(fitted.history.back().loss, fitted.history.front().loss);
  const StreamRun other = test::made_stream_run(9);
  const std::vector<Logits> ours = logits_of(other, fitted.weights);
  std::size_t right = 0;
  for (std::size_t k = 0; k < other.ticks; ++k) right += verdict_of(ours[k]) == other.truth[k] ? 1U : 0U;
  EXPECT_GT(right, other.ticks * 9 / 10);
  std::vector<float> inputs(other.ticks * Layout::places * (Layout::cells_of_place + 1));
  stream_inputs(other.counts, inputs);
  const std::vector<Logits> expected = stream_logits_by_libtorch(inputs, fitted.weights);
  ASSERT_EQ(expected.size(), ours.size());
  for (std::size_t k = 0; k < ours.size(); ++k) {
    const float largest = std::max({std::abs(expected[k][0]), std::abs(expected[k][1]), std::abs(expected[k][2])});
    for (std::size_t i = 0; i < touch_count; ++i) ASSERT_NEAR(ours[k][i], expected[k][i], 1e-5F * largest) << k;
  }
}

TEST(FitStream, GivesTheSameWeightsAgainAndOthersWithAnotherSeed) {
  const std::vector<StreamRun> runs = runs_of({1, 2});
  const Weights first = fit_stream(runs, grid, {.steps = 5}).weights;
  EXPECT_EQ(fit_stream(runs, grid, {.steps = 5}).weights, first);
  EXPECT_NE(fit_stream(runs, grid, {.steps = 5}, 2).weights, first);
  EXPECT_EQ(first.front().values, (std::vector<float>{0, 0, 160, 120}));
  EXPECT_THROW(fit_stream(runs, grid, {.steps = 0}), Error);
  EXPECT_THROW(fit_stream({}, grid), Error);
}

}  // namespace
}  // namespace tactile::model
