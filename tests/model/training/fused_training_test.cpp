#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

#include "model/noise_heatmaps.hpp"
#include "tactile/core/error.hpp"
#include "tactile/model/training/fused_convolutions.hpp"
#include "tactile/model/training/optimizer_steps.hpp"
#include "tactile/model/training/training.hpp"

namespace tactile::model {
namespace {

using test::noise_heatmaps;
using test::NoiseHeatmaps;

constexpr TrainerOptions fast{}, libtorch{.engine = EngineKind::libtorch}, float64{.float64 = true};

/// The gradients of one batch, by the names of the weights: what SGD remembers of its first step.
Weights gradients_of(LeNet network, const NoiseHeatmaps& samples, const TrainerOptions& options, unsigned threads = 1) {
  LeNetTrainer trainer(network, OptimizerKind::sgd, {1, 1, 1}, threads, options);
  EXPECT_TRUE(trainer.learn(samples.heatmaps, samples.truth, 1e-6).moved);
  return trainer.state().moments;
}

double norm_of(const std::vector<float>& values) {
  double squares = 0;
  for (const float value : values) squares += static_cast<double>(value) * static_cast<double>(value);
  return std::sqrt(squares);
}

/// Each parameter's by itself, by their Euclidean norms.
void expect_alike(const Weights& gradients, const Weights& expected, const std::string& what) {
  ASSERT_EQ(gradients.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    std::vector<float> difference(expected[i].values.size());
    for (std::size_t k = 0; k < difference.size(); ++k) difference[k] = gradients[i].values[k] - expected[i].values[k];
    EXPECT_LE(norm_of(difference), 1e-5 * norm_of(expected[i].values)) << what << ", " << expected[i].shape.name;
  }
}

/// A few patches that move, as markers do, on an empty ground: most cells are 0.
NoiseHeatmaps patches(std::size_t count, events::SensorSize size, std::uint64_t seed) {
  Random random(seed);
  NoiseHeatmaps samples{size, {}, {}};
  const auto width = static_cast<std::size_t>(size.width), height = static_cast<std::size_t>(size.height);
  samples.heatmaps.resize(count * width * height);
  for (std::size_t i = 0; i < count; ++i) {
    samples.truth.push_back(all_touches[i % touch_count]);
    const std::size_t side = 2 + 2 * (i % touch_count);  // the larger the patch, the later the touch's name
    for (int patch = 0; patch < 3; ++patch) {
      const std::size_t x = random.below(width - side), y = random.below(height - side);
      for (std::size_t cell = 0; cell < side * side; ++cell)
        samples.heatmaps[(i * height + y + cell / side) * width + x + cell % side] =
            static_cast<std::uint8_t>(1 + random.below(255));
    }
  }
  return samples;
}

TEST(FusedTraining, GradientsAreThoseOfLibtorchsLayersInFloat64) {
  for (const events::SensorSize size : {events::SensorSize{128, 96}, {31, 22}, {16, 16}, {33, 47}, {70, 18}}) {
    const std::string name = std::to_string(size.width) + " x " + std::to_string(size.height);
    for (const auto& samples : {noise_heatmaps(9, size, 3), patches(9, size, 4)}) {
      const Weights expected = gradients_of(LeNet(size, 7), samples, float64);
      expect_alike(gradients_of(LeNet(size, 7), samples, fast), expected, name);
      expect_alike(gradients_of(LeNet(size, 7), samples, libtorch), expected, name + " by libtorch");
    }
  }
}

// Float64 is the reference: float32 of libtorch errs by 1e-5 itself on processors without AVX-512.
TEST(FusedTraining, GradientsAreThoseOfLibtorchsLayersForFullBatches) {
  const auto samples = noise_heatmaps(32, {128, 96}, 5);
  expect_alike(gradients_of(LeNet(samples.size, 1), samples, fast), gradients_of(LeNet(samples.size, 1), samples, float64),
               "a batch of 32");
}

TEST(FusedTraining, OfEqualValuesTheFirstTakesTheGradientAsInLibtorch) {
  // Cells of 0 and 1, kernels of small whole numbers: every sum is exact, and equals are many.
  const events::SensorSize size{40, 32};
  Random random(1);
  NoiseHeatmaps samples = noise_heatmaps(6, size, 8);
  for (std::uint8_t& cell : samples.heatmaps) cell = cell > 0 ? 255 : 0;
  Weights weights = LeNet(size, 1).weights();
  for (std::size_t i = 0; i < 4; ++i) {
    for (float& value : weights[i].values) value = static_cast<float>(random.below(4)) - (i % 2 == 0 ? 1.0F : 0.0F);
  }
  for (float& value : weights[4].values) value *= 1e-3F;  // the sums are large
  expect_alike(gradients_of(LeNet(size, weights), samples, fast), gradients_of(LeNet(size, weights), samples, float64), "equals");
}

TEST(FusedTraining, EmptyHeatmapsTeachTheFirstKernelNothing) {
  NoiseHeatmaps samples = noise_heatmaps(5, {48, 40}, 2);
  std::fill(samples.heatmaps.begin(), samples.heatmaps.end(), std::uint8_t{0});
  const Weights gradients = gradients_of(LeNet(samples.size, 3), samples, fast);
  expect_alike(gradients, gradients_of(LeNet(samples.size, 3), samples, float64), "empty");
  EXPECT_EQ(norm_of(gradients[0].values), 0);
  EXPECT_GT(norm_of(gradients[1].values), 0);
}

TEST(FusedTraining, FullHeatmapsToo) {
  NoiseHeatmaps samples = noise_heatmaps(5, {48, 40}, 2);
  std::fill(samples.heatmaps.begin(), samples.heatmaps.end(), std::uint8_t{255});
  expect_alike(gradients_of(LeNet(samples.size, 3), samples, fast), gradients_of(LeNet(samples.size, 3), samples, float64),
               "full");
}

TEST(FusedTraining, GradientsDependNotOnTheThreadsToTheBit) {
  for (const auto& samples : {noise_heatmaps(31, {64, 48}, 6), noise_heatmaps(9, {128, 96}, 7)}) {
    const Weights gradients = gradients_of(LeNet(samples.size, 2), samples, fast, 1);
    for (const unsigned threads : {2U, 3U, 16U})
      EXPECT_EQ(gradients_of(LeNet(samples.size, 2), samples, fast, threads), gradients) << threads << " threads";
  }
}

TEST(FusedTraining, OtherLayersAreLibtorchs) {
  const auto samples = noise_heatmaps(6, {40, 32}, 4);
  const auto network = [&] { return LeNet(samples.size, 5, {Activation::tanh, Pooling::average}); };
  EXPECT_EQ(gradients_of(network(), samples, fast), gradients_of(network(), samples, libtorch));
}

TEST(FusedTraining, LearnsAsLibtorchsLayersDo) {
  const auto samples = patches(192, {64, 48}, 9);
  for (const OptimizerKind optimizer : {OptimizerKind::adam, OptimizerKind::adamw, OptimizerKind::sgd}) {
    const auto history = [&](EngineKind engine) {
      TrainingOptions options{
          .epochs = 6, .learning_rate = optimizer == OptimizerKind::sgd ? 0.02 : 1e-3, .optimizer = optimizer};
      options.engine = engine;
      return train_lenet({.size = samples.size, .training = {samples.heatmaps, samples.truth}, .options = options, .threads = 1})
          .summary.history;
    };
    const auto ours = history(EngineKind::fast), theirs = history(EngineKind::libtorch);
    ASSERT_EQ(ours.size(), theirs.size());
    for (std::size_t i = 0; i < ours.size(); ++i)
      EXPECT_NEAR(ours[i].loss, theirs[i].loss, 0.01 * theirs[0].loss) << name_of(optimizer) << ", epoch " << i + 1;
    if (optimizer == OptimizerKind::sgd) continue;  // six epochs are no more than its start
    EXPECT_LT(ours.back().loss, 0.9 * ours.front().loss) << name_of(optimizer);
  }
}

TEST(FusedConvolutions, AreTheSameOnEveryKindOfProcessor) {
  const auto layers = lenet_layers({45, 38});
  const auto samples = patches(1, layers.input, 11);
  Random random(12);
  std::vector<float> values(6 * 25 + 6 + 16 * 150 + 16), gradients_in(layers.flat);
  for (float& value : values) value = static_cast<float>(random.below(2001)) / 5000.0F - 0.2F;
  for (float& value : gradients_in) value = static_cast<float>(random.below(2001)) / 1000.0F - 1.0F;
  FusedConvolutions passes(layers);
  std::vector<float> first_flat, first_gradients;
  int targets = 0;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1, ++targets) {
    hwy::SetSupportedTargetsForTest(left & -left);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    passes.set({values.data(), values.data() + 150, values.data() + 156, values.data() + 2556});
    auto kept = passes.make_kept();
    auto workspace = passes.make_workspace();
    FusedConvolutions::Gradients sums;
    std::vector<float> flat(layers.flat), gradients(values.size());
    passes.forward(samples.heatmaps, flat, kept, workspace);
    passes.backward(samples.heatmaps, kept, gradients_in, sums, workspace);
    sums.write({gradients.data(), gradients.data() + 150, gradients.data() + 156, gradients.data() + 2556});
    if (first_flat.empty()) {
      first_flat = flat;
      first_gradients = gradients;
      EXPECT_GT(norm_of(flat), 0);
    }
    for (auto [ours, theirs] : {std::pair(&flat, &first_flat), std::pair(&gradients, &first_gradients)}) {
      std::vector<float> difference(ours->size());
      for (std::size_t i = 0; i < ours->size(); ++i) difference[i] = (*ours)[i] - (*theirs)[i];
      EXPECT_LE(norm_of(difference), 1e-5 * norm_of(*theirs)) << hwy::TargetName(hwy::SupportedTargets());
    }
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  EXPECT_GE(targets, 1);
}

TEST(FusedConvolutions, PassOnWhatIsNotANumber) {
  const auto layers = lenet_layers({20, 20});
  std::vector<float> values(6 * 25 + 6 + 16 * 150 + 16, 0.1F);
  values[0] = std::numeric_limits<float>::quiet_NaN();
  FusedConvolutions passes(layers);
  passes.set({values.data(), values.data() + 150, values.data() + 156, values.data() + 2556});
  auto kept = passes.make_kept();
  auto workspace = passes.make_workspace();
  std::vector<float> flat(layers.flat);
  passes.forward(std::vector<std::uint8_t>(400, 9), flat, kept, workspace);
  EXPECT_TRUE(std::all_of(flat.begin(), flat.end(), [](float value) { return std::isnan(value); }));
}

TEST(OptimizerSteps, AreThoseOfTheirFormulas) {
  constexpr std::size_t count = 37;  // no whole number of vectors
  constexpr double rate = 0.01;
  for (const OptimizerKind kind : {OptimizerKind::adam, OptimizerKind::adamw, OptimizerKind::sgd}) {
    Random random(4);
    std::vector<float> weights(count), first(count), second(count), gradients(count);
    for (float& weight : weights) weight = static_cast<float>(random.below(1000)) / 500.0F - 1.0F;
    std::vector<double> w(weights.begin(), weights.end()), m(count), v(count);
    for (std::int64_t step = 1; step <= 20; ++step) {
      for (float& gradient : gradients) gradient = static_cast<float>(random.below(1000)) / 300.0F - 1.5F;
      const auto slice_of = [&](std::size_t begin, std::size_t size) {
        const auto part = [&](std::vector<float>& values) { return std::span(values).subspan(begin, size); };
        return WeightSlice{part(weights), part(gradients), part(first),
                           kind == OptimizerKind::sgd ? std::span<float>() : part(second)};
      };
      take_step({kind, rate, step}, slice_of(0, 20));
      take_step({kind, rate, step}, slice_of(20, count - 20));
      for (std::size_t i = 0; i < count; ++i) {
        const auto g = static_cast<double>(gradients[i]);
        if (kind == OptimizerKind::sgd) {
          m[i] = 0.9 * m[i] + g;
          w[i] -= rate * m[i];
          continue;
        }
        if (kind == OptimizerKind::adamw) w[i] *= 1 - 0.01 * rate;
        m[i] = 0.9 * m[i] + 0.1 * g;
        v[i] = 0.999 * v[i] + 0.001 * g * g;
        const auto t = static_cast<double>(step);
        w[i] -= rate * m[i] / (1 - std::pow(0.9, t)) / (std::sqrt(v[i] / (1 - std::pow(0.999, t))) + 1e-8);
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_NEAR(weights[i], w[i], 1e-5) << name_of(kind);
      EXPECT_NEAR(first[i], m[i], 1e-5) << name_of(kind);
      EXPECT_NEAR(second[i], v[i], 1e-6) << name_of(kind);
    }
  }
}

TEST(OptimizerSteps, StayWithLibtorchsOverManyBatches) {
  const auto samples = noise_heatmaps(24, {24, 20}, 3);
  for (const OptimizerKind kind : {OptimizerKind::adam, OptimizerKind::adamw, OptimizerKind::sgd}) {
    LeNet ours(samples.size, 2), theirs(samples.size, 2);
    LeNetTrainer fast_trainer(ours, kind, {1, 1, 1}, 1, fast), libtorch_trainer(theirs, kind, {1, 1, 1}, 1, libtorch);
    for (int batch = 0; batch < 5; ++batch) {
      const auto result = fast_trainer.learn(samples.heatmaps, samples.truth, 1e-4);
      const auto expected = libtorch_trainer.learn(samples.heatmaps, samples.truth, 1e-4);
      EXPECT_NEAR(result.loss, expected.loss, 1e-5) << name_of(kind);
      EXPECT_NEAR(result.gradient_norm, expected.gradient_norm, 1e-4 * expected.gradient_norm) << name_of(kind);
    }
    // The other trainer resumes from the state of the first.
    libtorch_trainer.restore(fast_trainer.state());
    EXPECT_EQ(libtorch_trainer.state(), fast_trainer.state());
  }
}

TEST(SumOfSquares, IsExactEnoughForMillions) {
  std::vector<float> values(1'170'001, 0.1F);
  EXPECT_NEAR(sum_of_squares(values), 11'700.01, 0.01);
  EXPECT_EQ(sum_of_squares(values, 5), sum_of_squares(values));
  EXPECT_EQ(sum_of_squares({}), 0);
  values[7] = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(std::isinf(sum_of_squares(values)));
}

/// A network with the same logits for every heatmap.
LeNet constant_network(events::SensorSize size, const std::array<float, touch_count>& logits) {
  Weights weights = LeNet(size, 1).weights();
  for (float& value : weights[8].values) value = 0;  // fc3
  weights[9].values.assign(logits.begin(), logits.end());
  return {size, weights};
}

TEST(TrainingAtExtremes, LogitsOfTenThousandGiveAFiniteLossAndGradient) {
  NoiseHeatmaps samples = noise_heatmaps(3, {24, 20}, 1);
  for (const TrainerOptions& options : {fast, libtorch}) {
    LeNet network = constant_network(samples.size, {1e4F, -1e4F, 0});
    LeNetTrainer trainer(network, OptimizerKind::sgd, {1, 1, 1}, 1, options);
    const BatchResult result = trainer.learn(samples.heatmaps, samples.truth, 1e-9);
    EXPECT_DOUBLE_EQ(result.loss, (0 + 2e4 + 1e4) / 3);
    EXPECT_EQ(result.correct, 1U);
    EXPECT_TRUE(result.moved);
    const Weights gradients = trainer.state().moments;
    const std::vector<float> expected{2.0F / 3, -1.0F / 3, -1.0F / 3};  // softmax less truth, on average
    for (std::size_t i = 0; i < touch_count; ++i) EXPECT_NEAR(gradients[9].values[i], expected[i], 1e-6F);
  }
}

TEST(TrainingAtExtremes, GradientsWithLogitsOfTenThousandAreThoseOfFloat64) {
  const auto samples = patches(9, {48, 40}, 4);
  Weights weights = LeNet(samples.size, 7).weights();
  const auto largest_of = [&] {
    float largest = 0;
    for (const Logits& logits : LeNet(samples.size, weights).logits(samples.heatmaps, 1)) {
      for (const float logit : logits) largest = std::max(largest, std::abs(logit));
    }
    return largest;
  };
  const float by = 1e4F / largest_of();
  for (const std::size_t i : {8U, 9U}) {
    for (float& value : weights[i].values) value *= by;
  }
  ASSERT_NEAR(largest_of(), 1e4, 10);
  const Weights expected = gradients_of(LeNet(samples.size, weights), samples, float64);
  expect_alike(gradients_of(LeNet(samples.size, weights), samples, fast), expected, "fast");
  expect_alike(gradients_of(LeNet(samples.size, weights), samples, libtorch), expected, "libtorch");
}

TEST(TrainingAtExtremes, ABatchOfOneIsABatch) {
  for (const events::SensorSize size : {events::SensorSize{128, 96}, {31, 22}}) {
    for (const auto& samples : {noise_heatmaps(1, size, 3), patches(1, size, 4)}) {
      const Weights expected = gradients_of(LeNet(size, 7), samples, float64);
      expect_alike(gradients_of(LeNet(size, 7), samples, fast), expected, "one sample");
      expect_alike(gradients_of(LeNet(size, 7), samples, fast, 3), expected, "one sample, three threads");
      expect_alike(gradients_of(LeNet(size, 7), samples, libtorch), expected, "one sample by libtorch");
    }
  }
  // And so is what a last batch has left.
  const auto samples = patches(13, {32, 24}, 2);
  for (const EngineKind engine : {EngineKind::fast, EngineKind::libtorch}) {
    for (const unsigned batch : {1U, 4U, 12U}) {
      const auto trained = train_lenet({.size = samples.size,
                                        .training = {samples.heatmaps, samples.truth},
                                        .options = {.epochs = 2, .batch = batch, .engine = engine},
                                        .threads = 1});
      for (const EpochResult& epoch : trained.summary.history) EXPECT_TRUE(std::isfinite(epoch.loss)) << batch;
      EXPECT_LT(trained.summary.history.back().loss, trained.summary.history.front().loss) << batch;
    }
  }
}

TEST(TrainingAtExtremes, ALearningRateThatDivergesEndsInWords) {
  const auto samples = noise_heatmaps(30, {24, 20}, 1);
  for (const OptimizerKind optimizer : {OptimizerKind::adam, OptimizerKind::sgd}) {
    TrainingOptions options{.epochs = 20, .batch = 3, .learning_rate = 1e5, .optimizer = optimizer};
    for (const EngineKind engine : {EngineKind::fast, EngineKind::libtorch}) {
      options.engine = engine;
      EXPECT_THROW(
          train_lenet({.size = samples.size, .training = {samples.heatmaps, samples.truth}, .options = options, .threads = 1}),
          Error)
          << name_of(optimizer) << " by " << name_of(engine);
    }
  }
}

TEST(TrainingAtExtremes, AClassOfOneSampleIsLearnedFrom) {
  auto samples = patches(40, {32, 24}, 2);
  std::replace(samples.truth.begin() + 3, samples.truth.end(), Touch::slip, Touch::none);
  ASSERT_EQ(std::count(samples.truth.begin(), samples.truth.end(), Touch::slip), 1);
  for (const EngineKind engine : {EngineKind::fast, EngineKind::libtorch}) {
    TrainingOptions options{.epochs = 40, .learning_rate = 2e-3, .class_weights = {.balanced = true}, .engine = engine};
    const auto trained =
        train_lenet({.size = samples.size, .training = {samples.heatmaps, samples.truth}, .options = options, .threads = 1});
    for (const EpochResult& epoch : trained.summary.history) EXPECT_TRUE(std::isfinite(epoch.loss));
    const auto logits = trained.network.logits(samples.heatmaps, 1);
    EXPECT_EQ(verdict_of(logits[2]), Touch::slip) << "known by heart, by " << name_of(engine);
  }
}

TEST(TrainingAtExtremes, AClassWithoutSamplesIsRefusedByName) {
  auto samples = patches(12, {32, 24}, 2);
  std::replace(samples.truth.begin(), samples.truth.end(), Touch::slip, Touch::none);
  for (const bool balanced : {false, true}) {
    const TrainingOptions options{.class_weights = {.balanced = balanced}};
    try {
      train_lenet({.size = samples.size, .training = {samples.heatmaps, samples.truth}, .options = options, .threads = 1});
      ADD_FAILURE() << "no error";
    } catch (const Error& e) {
      EXPECT_STREQ(e.what(), "training: no sample of 'slip'; expected samples of none, press and slip");
    }
  }
}

TEST(TrainingAtExtremes, AnEpochThatMovesTheWeightsTooFarIsNeitherJudgedNorKept) {
  // One batch an epoch: the first step is taken before anything is seen to be wrong.
  const auto samples = noise_heatmaps(6, {24, 20}, 1);
  for (const EngineKind engine : {EngineKind::fast, EngineKind::libtorch}) {
    for (const auto& [rate, words] : {std::pair(1e25, "the logits of heatmap"), std::pair(1e39, "weights: ")}) {
      if (engine == EngineKind::libtorch && rate > 1e38) continue;  // libtorch's own steps take no such rate
      int kept = 0;
      const TrainingOptions options{.epochs = 3, .batch = 6, .learning_rate = rate, .engine = engine, .validation_share = 0.5};
      const LabelledHeatmaps all{samples.heatmaps, samples.truth};
      try {
        train_lenet({.size = samples.size, .training = all, .validation = all, .options = options, .threads = 1},
                    {.save = [&](const TrainingState&) { ++kept; }, .save_every = std::chrono::seconds(0)});
        ADD_FAILURE() << "no error";
      } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
        EXPECT_NE(std::string(e.what()).find("in epoch 1"), std::string::npos) << e.what();
        EXPECT_NE(std::string(e.what()).find("try a smaller --lr"), std::string::npos) << e.what();
      }
      EXPECT_EQ(kept, 0);
    }
  }
}

TEST(TrainingInFloat64, GivesTheNetworkItsWeightsRounded) {
  const auto samples = patches(48, {32, 24}, 3);
  const auto trained = [&](bool in_float64) {
    return train_lenet({.size = samples.size,
                        .training = {samples.heatmaps, samples.truth},
                        .options = {.epochs = 2},
                        .threads = 1,
                        .float64 = in_float64});
  };
  const auto exact = trained(true), ours = trained(false);
  EXPECT_NE(exact.network.weights(), LeNet(samples.size, 1).weights());
  EXPECT_NE(exact.network.weights(), ours.network.weights());
  EXPECT_NEAR(exact.summary.history.back().loss, ours.summary.history.back().loss, 1e-3);
}

}  // namespace
}  // namespace tactile::model
