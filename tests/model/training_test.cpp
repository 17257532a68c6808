#include "tactile/model/training.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "model/noise_heatmaps.hpp"
#include "tactile/core/error.hpp"

namespace tactile {
namespace {

using test::noise_heatmaps;

double share_right(const LeNet& network, const test::NoiseHeatmaps& samples) {
  const auto logits = network.logits(samples.heatmaps, 2);
  double right = 0;
  for (std::size_t i = 0; i < logits.size(); ++i) right += verdict_of(logits[i]) == samples.truth[i] ? 1 : 0;
  return right / static_cast<double>(logits.size());
}

TEST(Training, Learns64SamplesByHeart) {
  const auto samples = noise_heatmaps(64, {128, 96}, 1);
  const TrainedNetwork trained = train_lenet(samples.size, samples.heatmaps, samples.truth, {.epochs = 30}, 2);
  EXPECT_LT(share_right(LeNet(samples.size, 1), samples), 0.6);
  EXPECT_EQ(share_right(trained.network, samples), 1.0);
  EXPECT_LT(trained.summary.history.back().loss, trained.summary.history.front().loss);
}

TEST(Training, GivesTheSameWeightsForTheSameSeedAndThreads) {
  const auto samples = noise_heatmaps(70, {128, 96}, 2);
  const TrainingOptions options{.seed = 5, .epochs = 2};
  for (const unsigned threads : {1U, 2U}) {
    const auto one = train_lenet(samples.size, samples.heatmaps, samples.truth, options, threads);
    const auto again = train_lenet(samples.size, samples.heatmaps, samples.truth, options, threads);
    EXPECT_TRUE(one.network.weights() == again.network.weights()) << threads << " threads";
    for (std::size_t i = 0; i < one.summary.history.size(); ++i) {
      EXPECT_EQ(one.summary.history[i].loss, again.summary.history[i].loss);
      EXPECT_EQ(one.summary.history[i].accuracy, again.summary.history[i].accuracy);
    }
  }
  const auto other = train_lenet(samples.size, samples.heatmaps, samples.truth, {.seed = 6, .epochs = 2}, 1);
  EXPECT_FALSE(other.network.weights() ==
               train_lenet(samples.size, samples.heatmaps, samples.truth, options, 1).network.weights());
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
  const auto trained = train_lenet(samples.size, samples.heatmaps, samples.truth, {.seed = 4, .epochs = 1}, 1);
  ASSERT_EQ(trained.summary.history.size(), 1U);
  EXPECT_NEAR(trained.summary.history[0].loss, loss / 6, 1e-5);
}

TEST(Training, FirstStepOfAdamIsTheLearningRate) {
  // Adam's first step moves each weight by the learning rate against the sign of its slope, whatever its size.
  const auto samples = noise_heatmaps(6, {32, 24}, 3);
  const auto before = LeNet(samples.size, 4).weights();
  const auto after =
      train_lenet(samples.size, samples.heatmaps, samples.truth, {.seed = 4, .epochs = 1, .learning_rate = 0.01}, 1)
          .network.weights();
  const auto& bias_before = before.back().values;
  const auto& bias_after = after.back().values;
  for (std::size_t i = 0; i < bias_before.size(); ++i) EXPECT_NEAR(std::abs(bias_after[i] - bias_before[i]), 0.01, 1e-5);
}

TEST(Training, TellsProgressUpToItsEnd) {
  const auto samples = noise_heatmaps(10, {32, 24}, 3);
  std::vector<Progress> told;
  train_lenet(samples.size, samples.heatmaps, samples.truth, {.epochs = 2, .batch = 4}, 1,
              [&](const Progress& p) { told.push_back(p); });
  ASSERT_EQ(told.size(), 6U);  // batches of 4, 4, 2, twice
  EXPECT_EQ(told[0].done, 4U);
  EXPECT_EQ(told[5].done, 20U);
  EXPECT_EQ(told[5].total, 20U);
  EXPECT_NE(told[5].what.find("epoch 2/2"), std::string::npos);
}

TEST(Training, EndsInWordsWhereTheLossIsNoLongerFinite) {
  const auto samples = noise_heatmaps(64, {32, 24}, 3);
  try {
    train_lenet(samples.size, samples.heatmaps, samples.truth, {.epochs = 20, .batch = 8, .learning_rate = 1e30}, 1);
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("finite"), std::string::npos) << e.what();
  }
}

TEST(Training, RefusesWhatItCannotLearnFrom) {
  const auto samples = noise_heatmaps(6, {32, 24}, 3);
  const std::vector<Touch> no_slip{Touch::none, Touch::press, Touch::none, Touch::press, Touch::none, Touch::press};
  EXPECT_THROW(train_lenet(samples.size, {}, {}, {}, 1), Error);
  EXPECT_THROW(train_lenet(samples.size, samples.heatmaps, no_slip, {}, 1), Error);
  EXPECT_THROW(train_lenet({32, 23}, samples.heatmaps, samples.truth, {}, 1), Error);
  EXPECT_THROW(train_lenet(samples.size, samples.heatmaps, samples.truth, {.epochs = 0}, 1), Error);
  EXPECT_THROW(train_lenet(samples.size, samples.heatmaps, samples.truth, {.learning_rate = 0}, 1), Error);
  EXPECT_THROW(train_lenet(samples.size, samples.heatmaps, samples.truth, {.learning_rate = NAN}, 1), Error);
}

TEST(TrainingOptions, ComeBackFromJson) {
  const TrainingOptions options{.seed = 9, .epochs = 3, .batch = 8, .learning_rate = 0.005};
  EXPECT_EQ(nlohmann::json(options).get<TrainingOptions>(), options);
  EXPECT_THROW(nlohmann::json::parse(R"({"seed": 1})").get<TrainingOptions>(), Error);
}

}  // namespace
}  // namespace tactile
