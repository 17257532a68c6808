#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <random>
#include <thread>

#include "model/small_data.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/model/checkpoint.hpp"
#include "tactile/model/model_bundle.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

constexpr const char* arguments =
    "train --json --epochs 6 --batch 24 --validation 0.2 --augment flip,shift --schedule cosine --save-every 0 ";

/// What a bundle holds but for times, a line each.
std::string contents_of(const fs::path& folder) {
  const ModelBundle bundle{folder};
  auto history = read_history(bundle.history());
  for (EpochResult& epoch : history) epoch.images_per_s = epoch.seconds = 0;
  nlohmann::json description = read_json(bundle.description());
  description.erase("trained_at");
  description.at("result").erase("seconds");
  std::string contents = history_csv(history) + description.dump(2);
  if (fs::exists(bundle.best_weights())) contents += "\n" + sha256_of_file(bundle.best_weights());
  return contents;
}

/// Whether a file is being written in the folder: a hidden one of a process.
bool holds_a_part(const fs::path& folder) {
  return fs::exists(folder) && std::any_of(fs::directory_iterator(folder), fs::directory_iterator{}, [](const auto& entry) {
           return entry.path().filename().string().find(".part") != std::string::npos;
         });
}

TEST(TrainCommand, KilledAgainAndAgainComesToTheSameBitsByResuming) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  write_dataset(folder / "data", folder / "data/dataset.h5", {}, 1);
  const auto begun = std::chrono::steady_clock::now();
  const auto whole = test::run_tactile(arguments + std::string("--threads 1 --name whole"), folder.path());
  const auto lasted = std::chrono::steady_clock::now() - begun;
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  EXPECT_FALSE(fs::exists(folder / "models/whole.training"));

  // Killed at ten moments and more, until some kills came amid an epoch and some amid a state's writing.
  const fs::path kept = folder / "models/mine.training";
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0.05, 0.5);
  int kills = 0, amid_an_epoch = 0, amid_writing = 0;
  while ((kills < 10 || amid_an_epoch == 0 || amid_writing == 0) && !fs::exists(folder / "models/mine")) {
    {
      const test::RunningCommand training(arguments + std::string("--threads 1 --name mine --resume"), folder.path());
      std::this_thread::sleep_for(share(random) * lasted);
    }
    if (fs::exists(folder / "models/mine")) {
      // It came to its end first: begin anew, for the kills are what is tested.
      ASSERT_EQ(contents_of(folder / "models/mine"), contents_of(folder / "models/whole"));
      fs::remove_all(folder / "models/mine");
      continue;
    }
    ++kills;
    amid_writing += holds_a_part(kept) ? 1 : 0;
    if (CheckpointFolder::holds_state(kept)) {
      const auto state = nlohmann::json::parse(read_metadata(kept / "last.safetensors").at("state"));
      amid_an_epoch += state.at("done") > 0 ? 1 : 0;
    }
  }
  const auto last = test::run_tactile(arguments + std::string("--threads 1 --name mine --resume"), folder.path());
  ASSERT_EQ(last.exit_code, 0) << last.err;
  EXPECT_EQ(contents_of(folder / "models/mine"), contents_of(folder / "models/whole"));
  EXPECT_FALSE(fs::exists(kept));
}

TEST(TrainCommand, BrokenOffTrainingWantsResumeOrForce) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  write_dataset(folder / "data", folder / "data/dataset.h5", {}, 1);
  const fs::path kept = folder / "models/mine.training";
  {
    const test::RunningCommand training(arguments + std::string("--threads 1 --name mine"), folder.path());
    while (!CheckpointFolder::holds_state(kept)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const auto refused = test::run_tactile(arguments + std::string("--threads 1 --name mine"), folder.path());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("--resume"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--force"), std::string::npos) << refused.err;
  const auto other = test::run_tactile(arguments + std::string("--threads 1 --name mine --resume --seed 2"), folder.path());
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.err.find("other settings"), std::string::npos) << other.err;
  EXPECT_TRUE(CheckpointFolder::holds_state(kept));
  const auto resumed = test::run_tactile(arguments + std::string("--name mine --resume --threads 2"), folder.path());
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(nlohmann::json::parse(resumed.out).at("threads"), 1) << "others would move the last bits";
}

}  // namespace
}  // namespace tactile
