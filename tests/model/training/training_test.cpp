#include "tactile/model/training/training.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <optional>

#include "model/noise_heatmaps.hpp"
#include "tactile/core/error.hpp"

namespace tactile::model {
namespace {

using test::noise_heatmaps;

/// A training of noise on its defaults but for the options.
TrainedNetwork trained_on(const test::NoiseHeatmaps& samples, const TrainingOptions& options, unsigned threads = 1,
                          const TrainingControl& control = {}) {
  return train_lenet(
      {.size = samples.size, .training = {samples.heatmaps, samples.truth}, .options = options, .threads = threads}, control);
}

double share_right(const LeNet& network, const test::NoiseHeatmaps& samples) {
  const auto logits = network.logits(samples.heatmaps, 2);
  double right = 0;
  for (std::size_t i = 0; i < logits.size(); ++i) right += verdict_of(logits[i]) == samples.truth[i] ? 1 : 0;
  return right / static_cast<double>(logits.size());
}

TEST(Training, Learns64SamplesByHeart) {
  const auto samples = noise_heatmaps(64, {128, 96}, 1);
  const TrainedNetwork trained = trained_on(samples, {.epochs = 30}, 2);
  EXPECT_LT(share_right(LeNet(samples.size, 1), samples), 0.6);
  EXPECT_EQ(share_right(trained.network, samples), 1.0);
  EXPECT_LT(trained.summary.history.back().loss, trained.summary.history.front().loss);
}

TEST(Training, GivesTheSameWeightsForTheSameSeedAndThreads) {
  const auto samples = noise_heatmaps(70, {128, 96}, 2);
  const TrainingOptions options{.seed = 5, .epochs = 2};
  for (const unsigned threads : {1U, 2U}) {
    const auto one = trained_on(samples, options, threads);
    const auto again = trained_on(samples, options, threads);
    EXPECT_TRUE(one.network.weights() == again.network.weights()) << threads << " threads";
    for (std::size_t i = 0; i < one.summary.history.size(); ++i) {
      EXPECT_EQ(one.summary.history[i].loss, again.summary.history[i].loss);
      EXPECT_EQ(one.summary.history[i].accuracy, again.summary.history[i].accuracy);
    }
  }
  const auto other = trained_on(samples, {.seed = 6, .epochs = 2}, 1);
  EXPECT_FALSE(other.network.weights() == trained_on(samples, options, 1).network.weights());
}

TEST(Training, FirstLossIsThatOfTheFirstWeights) {
  // One batch, one epoch: the loss reported is the cross-entropy of the network as it was initialised.
  const auto samples = noise_heatmaps(6, {32, 24}, 3);
  const auto logits = LeNet(samples.size, 4).logits(samples.heatmaps, 1);
  double loss = 0;
  for (std::size_t i = 0; i < logits.size(); ++i) {
    double sum = 0;
    for (const float logit : logits[i]) sum += std::exp(static_cast<double>(logit));
    loss += std::log(sum) - static_cast<double>(logits[i][static_cast<std::size_t>(samples.truth[i])]);
  }
  const auto trained = trained_on(samples, {.seed = 4, .epochs = 1}, 1);
  ASSERT_EQ(trained.summary.history.size(), 1U);
  EXPECT_NEAR(trained.summary.history[0].loss, loss / 6, 1e-5);
}

TEST(Training, FirstStepOfAdamIsTheLearningRate) {
  // Adam's first step moves each weight by the learning rate against the sign of its gradient, of any size.
  const auto samples = noise_heatmaps(6, {32, 24}, 3);
  const auto before = LeNet(samples.size, 4).weights();
  const auto after = trained_on(samples, {.seed = 4, .epochs = 1, .learning_rate = 0.01}, 1).network.weights();
  const auto& bias_before = before.back().values;
  const auto& bias_after = after.back().values;
  for (std::size_t i = 0; i < bias_before.size(); ++i) EXPECT_NEAR(std::abs(bias_after[i] - bias_before[i]), 0.01, 1e-5);
}

TEST(Training, ReportsProgressUpToItsEnd) {
  const auto samples = noise_heatmaps(10, {32, 24}, 3);
  std::vector<Progress> reported;
  trained_on(samples, {.epochs = 2, .batch = 4}, 1, {.progress = [&](const Progress& p) { reported.push_back(p); }});
  ASSERT_EQ(reported.size(), 6U);  // batches of 4, 4, 2, twice
  EXPECT_EQ(reported[0].done, 4U);
  EXPECT_EQ(reported[5].done, 20U);
  EXPECT_EQ(reported[5].total, 20U);
  EXPECT_NE(reported[5].what.find("epoch 2/2"), std::string::npos);
}

TEST(Training, EndsInWordsWhereTheLossIsNoLongerFinite) {
  const auto samples = noise_heatmaps(64, {32, 24}, 3);
  try {
    trained_on(samples, {.epochs = 20, .batch = 8, .learning_rate = 1e30}, 1);
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("finite"), std::string::npos) << e.what();
  }
}

TEST(Training, RefusesWhatItCannotLearnFrom) {
  const auto samples = noise_heatmaps(6, {32, 24}, 3);
  const std::vector<Touch> no_slip{Touch::none, Touch::press, Touch::none, Touch::press, Touch::none, Touch::press};
  const LabelledHeatmaps whole{samples.heatmaps, samples.truth};
  EXPECT_THROW(train_lenet({.size = samples.size, .training = {}}), Error);
  EXPECT_THROW(train_lenet({.size = samples.size, .training = {samples.heatmaps, no_slip}}), Error);
  EXPECT_THROW(train_lenet({.size = {32, 23}, .training = whole}), Error);
  const TrainingOptions early{.validation_share = 0.2, .early_stop = 1};
  EXPECT_THROW(train_lenet({.size = samples.size, .training = whole, .options = early}), Error);
  EXPECT_THROW(trained_on(samples, {.early_stop = 1}, 1), Error);
  EXPECT_THROW(trained_on(samples, {.validation_share = 0.6}, 1), Error);
  EXPECT_THROW(trained_on(samples, {.epochs = 0}, 1), Error);
  EXPECT_THROW(trained_on(samples, {.learning_rate = 0}, 1), Error);
  EXPECT_THROW(trained_on(samples, {.learning_rate = NAN}, 1), Error);
}

/// The history without its times, which no two trainings share.
std::string history_of(TrainingSummary summary) {
  for (EpochResult& epoch : summary.history) epoch.images_per_s = epoch.seconds = 0;
  return history_csv(summary.history);
}

struct BrokenOff {};

/// Trains, interrupted after each batch, and resumes from the saved state each time.
TrainedNetwork trained_in_pieces(const TrainingTask& task) {
  std::optional<TrainingState> state;
  for (;;) {
    std::uint64_t batches = 0;
    TrainingControl control;
    control.save = [&](const TrainingState& kept) { state = kept; };
    control.save_every = std::chrono::seconds(3600);
    control.progress = [&](const Progress& p) {
      if (++batches == 2 && p.done < p.total) throw BrokenOff{};
    };
    const std::optional<TrainingState> from = state;
    control.resumed = from ? &*from : nullptr;
    try {
      return train_lenet(task, control);
    } catch (const BrokenOff&) {
    }
  }
}

TEST(Training, BrokenOffAndGoneOnWithComesToTheSameBits) {
  const auto samples = noise_heatmaps(22, {32, 24}, 8);
  const auto judges = noise_heatmaps(9, {32, 24}, 9);
  for (const OptimizerKind optimizer : {OptimizerKind::adam, OptimizerKind::adamw, OptimizerKind::sgd}) {
    TrainingTask task{.size = samples.size,
                      .training = {samples.heatmaps, samples.truth},
                      .validation = {judges.heatmaps, judges.truth},
                      .options = {.seed = 3,
                                  .epochs = 4,
                                  .batch = 8,
                                  .optimizer = optimizer,
                                  .schedule = Schedule::cosine,
                                  .augmentation = {.flip = true, .shift = true},
                                  .class_weights = {.balanced = true},
                                  .validation_share = 0.2},
                      .threads = 1};
    const TrainedNetwork whole = train_lenet(task), pieces = trained_in_pieces(task);
    EXPECT_TRUE(whole.network.weights() == pieces.network.weights()) << name_of(optimizer);
    EXPECT_EQ(whole.other, pieces.other) << name_of(optimizer);
    EXPECT_EQ(whole.summary.best_epoch, pieces.summary.best_epoch);
    EXPECT_EQ(history_of(whole.summary), history_of(pieces.summary)) << name_of(optimizer);
    ASSERT_EQ(whole.summary.history.size(), 4U);
  }
}

TEST(Training, StateOfAnotherTrainingIsRefused) {
  const auto samples = noise_heatmaps(12, {32, 24}, 8);
  std::optional<TrainingState> state;
  trained_on(samples, {.epochs = 3}, 1, {.save = [&](const TrainingState& kept) { state = kept; }});
  ASSERT_TRUE(state.has_value());
  EXPECT_THROW(trained_on(samples, {.epochs = 2}, 1, {.resumed = &*state}), Error);
  EXPECT_THROW(trained_on(samples, {.epochs = 3, .optimizer = OptimizerKind::sgd}, 1, {.resumed = &*state}), Error);
  EXPECT_NO_THROW(trained_on(samples, {.epochs = 3}, 1, {.resumed = &*state}));
}

TEST(Training, StopsEarlyAndUsesTheBestWeights) {
  // Memorised noise does not generalise: the validation loss soon rises.
  const auto samples = noise_heatmaps(24, {32, 24}, 8);
  const auto judges = noise_heatmaps(24, {32, 24}, 9);
  TrainingTask task{.size = samples.size,
                    .training = {samples.heatmaps, samples.truth},
                    .validation = {judges.heatmaps, judges.truth},
                    .options = {.epochs = 60, .batch = 8, .validation_share = 0.5, .early_stop = 3},
                    .threads = 1};
  const TrainedNetwork stopped = train_lenet(task);
  ASSERT_TRUE(stopped.summary.stopped_early);
  const auto& history = stopped.summary.history;
  const unsigned best = stopped.summary.best_epoch;
  ASSERT_EQ(history.size(), best + 3);
  for (const EpochResult& epoch : history) EXPECT_GE(*epoch.validation_loss, *history[best - 1].validation_loss);

  // The weights are those that a training of so many epochs ends with, and those of the last are kept too.
  task.options = {.epochs = best, .batch = 8};
  EXPECT_TRUE(stopped.network.weights() == train_lenet(task).network.weights());
  task.options.epochs = best + 3;
  EXPECT_EQ(stopped.other, train_lenet(task).network.weights());
}

TEST(Training, StartsFromOtherWeights) {
  const auto samples = noise_heatmaps(6, {32, 24}, 3);
  const Weights first = LeNet(samples.size, 77).weights();
  const TrainingTask task{.size = samples.size,
                          .training = {samples.heatmaps, samples.truth},
                          .options = {.seed = 4, .epochs = 1, .learning_rate = 1e-12},
                          .from = &first,
                          .threads = 1};
  const Weights last = train_lenet(task).network.weights();
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t k = 0; k < first[i].values.size(); ++k) EXPECT_NEAR(last[i].values[k], first[i].values[k], 1e-6);
  }
}

TEST(Training, EndsWithAnErrorIfTheGradientExplodes) {
  // Weights this large leave the loss finite and its gradient far beyond what a step could use.
  const auto samples = noise_heatmaps(6, {32, 24}, 3);
  Weights huge = LeNet(samples.size, 4).weights();
  for (float& value : huge[6].values) value *= 1e9F;  // fc2
  try {
    train_lenet({.size = samples.size, .training = {samples.heatmaps, samples.truth}, .from = &huge, .threads = 1});
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("gradient's norm"), std::string::npos) << e.what();
  }
}

TEST(WeightsOfClasses, BalanceOrAreAsGiven) {
  const std::vector<Touch> truth{Touch::none, Touch::none, Touch::none, Touch::press, Touch::press, Touch::slip};
  EXPECT_EQ(weights_of_classes({}, truth), (std::array{1.0, 1.0, 1.0}));
  EXPECT_EQ(weights_of_classes({.given = {1, 2, 3}}, truth), (std::array{1.0, 2.0, 3.0}));
  EXPECT_EQ(weights_of_classes({.balanced = true}, truth), (std::array{6.0 / 9, 6.0 / 6, 6.0 / 3}));
  EXPECT_THROW(weights_of_classes({.balanced = true}, std::span(truth).first(5)), Error);
}

TEST(Training, ClassWeightsAreThoseOfTheCrossEntropy) {
  const auto samples = noise_heatmaps(6, {32, 24}, 3);
  const std::array<double, touch_count> given{1, 5, 0.5};
  const auto logits = LeNet(samples.size, 4).logits(samples.heatmaps, 1);
  double loss = 0, weights = 0;
  for (std::size_t i = 0; i < logits.size(); ++i) {
    const auto truth = static_cast<std::size_t>(samples.truth[i]);
    double sum = 0;
    for (const float logit : logits[i]) sum += std::exp(static_cast<double>(logit));
    loss += given[truth] * (std::log(sum) - static_cast<double>(logits[i][truth]));
    weights += given[truth];
  }
  const auto trained = trained_on(samples, {.seed = 4, .epochs = 1, .class_weights = {.given = given}});
  EXPECT_NEAR(trained.summary.history[0].loss, loss / weights, 1e-5);
}

TEST(LearningRate, FollowsItsSchedule) {
  TrainingOptions options{.learning_rate = 0.4};
  EXPECT_EQ(learning_rate_at(options, 99, 100), 0.4);
  options.schedule = Schedule::cosine;
  EXPECT_DOUBLE_EQ(learning_rate_at(options, 0, 100), 0.4);
  EXPECT_NEAR(learning_rate_at(options, 50, 100), 0.2, 1e-12);
  EXPECT_NEAR(learning_rate_at(options, 99, 100), 0.4 * 0.000246719817, 1e-9);
  options.schedule = Schedule::step;
  EXPECT_EQ(learning_rate_at(options, 49, 100), 0.4);
  EXPECT_DOUBLE_EQ(learning_rate_at(options, 50, 100), 0.04);
  EXPECT_DOUBLE_EQ(learning_rate_at(options, 75, 100), 0.004);
}

TEST(TrainingOptions, ComeBackFromJson) {
  const TrainingOptions options{.seed = 9,
                                .epochs = 3,
                                .batch = 8,
                                .learning_rate = 0.005,
                                .optimizer = OptimizerKind::sgd,
                                .schedule = Schedule::step,
                                .augmentation = {.flip = true, .shift = true},
                                .class_weights = {.given = {1, 2.5, 3}},
                                .engine = EngineKind::libtorch,
                                .validation_share = 0.25,
                                .early_stop = 4};
  TrainingOptions back;
  read_all_fields(json_of_fields(options), back, "training");
  EXPECT_EQ(back, options);
  EXPECT_THROW(read_all_fields(nlohmann::json::parse(R"({"seed": 1})"), back, "training"), Error);
  EXPECT_THROW(check_fields(TrainingOptions{.learning_rate = 11}, "training"), Error);
}

TEST(TrainingOptions, UnknownWordsAreRefused) {
  TrainingOptions options;
  for (const char* text : {R"({"optimizer": "lion"})", R"({"schedule": "warm"})", R"({"engine": "opencv"})"})
    EXPECT_THROW(read_fields(nlohmann::json::parse(text), options, "training"), Error) << text;
  EXPECT_THROW(engine_named("slow"), Error);
  EXPECT_THROW(augmentation_named("flip,turn"), Error);
  EXPECT_THROW(augmentation_named(""), Error);
  for (const char* text : {"", "1,2", "1,2,0", "1,2,x", "1,2,3,4", "1,2,inf", "-1,2,3"})
    EXPECT_THROW(class_weights_named(text), Error) << text;
  EXPECT_TRUE(class_weights_named("balanced").balanced);
  EXPECT_EQ(class_weights_named("1,2,1").given, (std::array{1.0, 2.0, 1.0}));
}

}  // namespace
}  // namespace tactile::model
