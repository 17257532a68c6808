#include "tactile/model/training/checkpoint.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "model/noise_heatmaps.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::model {
namespace {

namespace fs = std::filesystem;

const nlohmann::json task{{"settings", "these"}};

/// The states of a small training, as it keeps them.
std::vector<TrainingState> states() {
  const auto samples = test::noise_heatmaps(10, {32, 24}, 3);
  std::vector<TrainingState> kept;
  train_lenet(
      {.size = samples.size, .training = {samples.heatmaps, samples.truth}, .options = {.epochs = 3, .batch = 4}, .threads = 1},
      {.save = [&](const TrainingState& state) { kept.push_back(state); }, .save_every = std::chrono::seconds(0)});
  return kept;
}

std::string error_of(const CheckpointFolder& folder, const nlohmann::json& of) {
  try {
    folder.load(of, lenet_layers({32, 24}), OptimizerKind::adam);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST(CheckpointFolder, GivesBackEachStateToTheLastBit) {
  const test::TemporaryFolder folder;
  CheckpointFolder checkpoints(folder / "mine.training");
  EXPECT_FALSE(checkpoints.load(task, lenet_layers({32, 24}), OptimizerKind::adam).has_value());
  const auto kept = states();
  ASSERT_EQ(kept.size(), 9U);
  for (const TrainingState& state : kept) {
    checkpoints.save(task, state);
    const auto loaded = checkpoints.load(task, lenet_layers({32, 24}), OptimizerKind::adam);
    ASSERT_TRUE(loaded.has_value());
    EXPECT_EQ(loaded->epoch, state.epoch);
    EXPECT_EQ(loaded->done, state.done);
    EXPECT_EQ(loaded->loss, state.loss);
    EXPECT_EQ(loaded->weight, state.weight);
    EXPECT_EQ(loaded->correct, state.correct);
    EXPECT_EQ(loaded->gradient_norm, state.gradient_norm);
    EXPECT_EQ(loaded->seconds, state.seconds);
    EXPECT_EQ(nlohmann::json(loaded->history), nlohmann::json(state.history));
    EXPECT_EQ(loaded->weights, state.weights);
    EXPECT_EQ(loaded->optimizer, state.optimizer);
    ASSERT_EQ(loaded->best.has_value(), state.best.has_value());
    if (state.best) {
      EXPECT_EQ(loaded->best->epoch, state.best->epoch);
      EXPECT_EQ(loaded->best->loss, state.best->loss);
      EXPECT_EQ(loaded->best->weights, state.best->weights);
    }
  }
  EXPECT_LE(std::distance(fs::directory_iterator(folder / "mine.training"), {}), 2);
  EXPECT_EQ(task_of_checkpoint(folder / "mine.training"), task);
  checkpoints.remove();
  EXPECT_FALSE(fs::exists(folder / "mine.training"));
}

TEST(CheckpointFolder, BelongsToOneProcessAndIsRemovedIfEmpty) {
  const test::TemporaryFolder folder;
  {
    const CheckpointFolder first(folder / "mine.training");
    EXPECT_THROW(CheckpointFolder(folder / "mine.training"), Error);
  }
  EXPECT_FALSE(fs::exists(folder / "mine.training"));
  EXPECT_NO_THROW(CheckpointFolder(folder / "mine.training"));
}

TEST(CheckpointFolder, RefusesStatesOfAnotherTaskAndDamagedOnes) {
  const test::TemporaryFolder folder;
  CheckpointFolder checkpoints(folder / "mine.training");
  const auto kept = states();
  checkpoints.save(task, kept.back());
  EXPECT_NE(error_of(checkpoints, {{"settings", "others"}}).find("--force"), std::string::npos);
  EXPECT_EQ(error_of(checkpoints, task), "no error");

  const fs::path last = folder / "mine.training/last.safetensors";
  const std::string whole = read_text(last);
  for (const std::size_t length : {std::size_t{0}, std::size_t{5}, std::size_t{100}, whole.size() / 2, whole.size() - 1}) {
    std::ofstream(last, std::ios::binary) << whole.substr(0, length);
    EXPECT_NE(error_of(checkpoints, task), "no error") << length;
  }
  std::ofstream(last, std::ios::binary) << whole;
  for (const auto& entry : fs::directory_iterator(folder / "mine.training")) {
    if (entry.path() != last) fs::remove(entry.path());
  }
  EXPECT_NE(error_of(checkpoints, task).find("best-"), std::string::npos);
  checkpoints.clear();
  EXPECT_FALSE(CheckpointFolder::holds_state(folder / "mine.training"));
}

}  // namespace
}  // namespace tactile::model
