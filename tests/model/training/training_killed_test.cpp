#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <random>
#include <set>
#include <string>
#include <system_error>
#include <thread>

#include "model/small_data.hpp"
#include "support/comes_true.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/training/checkpoint.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::model {
namespace {

namespace fs = std::filesystem;

constexpr const char* arguments =
    "train --json --epochs 6 --batch 24 --validation 0.2 --augment flip,shift --schedule cosine --save-every 0 ";

/// What a bundle holds except for times, a line each.
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

/// The files being written in the folder: hidden ones, each of a process.
std::set<std::string> parts_in(const fs::path& folder) {
  std::set<std::string> parts;
  std::error_code gone;
  for (fs::directory_iterator entry(folder, gone); !gone && entry != fs::directory_iterator(); entry.increment(gone)) {
    const std::string name = entry->path().filename().string();
    if (name.find(".part") != std::string::npos) parts.insert(name);
  }
  return parts;
}

TEST(TrainCommand, KilledAgainAndAgainComesToTheSameBitsByResuming) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 1);
  const auto begun = std::chrono::steady_clock::now();
  const auto whole = test::run_tactile(arguments + std::string("--threads 1 --name whole"), folder.path());
  const auto lasted = std::chrono::steady_clock::now() - begun;
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  EXPECT_FALSE(fs::exists(folder / "models/whole.training"));

  // Killed by turns while it begins, soon after it has kept a first state, and while it writes one: a process is long in
  // beginning, and moments of the clock alone may never fall behind that.
  const fs::path kept = folder / "models/mine.training";
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0.0, 0.4);
  int kills = 0, amid_an_epoch = 0, amid_writing = 0;
  for (int attempt = 0; attempt < 60 && (kills < 12 || amid_an_epoch < 3 || amid_writing < 3); ++attempt) {
    {
      // A part that an earlier kill left is no sight of this one's writing.
      const std::set<std::string> left = parts_in(kept);
      test::RunningCommand training(arguments + std::string("--threads 1 --name mine --resume"), folder.path());
      const auto is_at_its_end = [&] { return fs::exists(folder / "models/mine") || training.has_ended(); };
      const auto is_writing = [&] {
        const auto parts = parts_in(kept);
        return std::any_of(parts.begin(), parts.end(), [&](const std::string& part) { return left.count(part) == 0; });
      };
      if (attempt % 3 != 0) {
        ASSERT_TRUE(test::comes_true([&] { return is_writing() || is_at_its_end(); }, std::chrono::microseconds(50)));
      }
      if (attempt % 3 != 1) std::this_thread::sleep_for(share(random) * lasted);
      if (training.has_ended()) {
        ASSERT_TRUE(fs::exists(folder / "models/mine")) << training.err();
      }
    }
    if (fs::exists(folder / "models/mine")) {
      // It finished first: start again, because the kills are the test.
      ASSERT_EQ(contents_of(folder / "models/mine"), contents_of(folder / "models/whole"));
      fs::remove_all(folder / "models/mine");
      continue;
    }
    ++kills;
    amid_writing += parts_in(kept).empty() ? 0 : 1;
    if (CheckpointFolder::holds_state(kept)) {
      const auto state = nlohmann::json::parse(read_metadata(kept / "last.safetensors").at("state"));
      amid_an_epoch += state.at("done") > 0 ? 1 : 0;
    }
  }
  EXPECT_GE(kills, 12);
  EXPECT_GE(amid_an_epoch, 3);
  EXPECT_GE(amid_writing, 3);
  const auto last = test::run_tactile(arguments + std::string("--threads 1 --name mine --resume"), folder.path());
  ASSERT_EQ(last.exit_code, 0) << last.err;
  EXPECT_EQ(contents_of(folder / "models/mine"), contents_of(folder / "models/whole"));
  EXPECT_FALSE(fs::exists(kept));
}

TEST(TrainCommand, AnInterruptedTrainingRequiresResumeOrForce) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 1);
  const fs::path kept = folder / "models/mine.training";
  {
    const test::RunningCommand training(arguments + std::string("--threads 1 --name mine"), folder.path());
    ASSERT_TRUE(test::comes_true([&] { return CheckpointFolder::holds_state(kept); })) << training.err();
  }
  const auto refused = test::run_tactile(arguments + std::string("--threads 1 --name mine"), folder.path());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("--resume"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--force"), std::string::npos) << refused.err;
  const auto other = test::run_tactile(arguments + std::string("--threads 1 --name mine --resume --seed 2"), folder.path());
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.err.find("other settings"), std::string::npos) << other.err;
  EXPECT_NE(other.err.find("seed: 1 before, 2 now"), std::string::npos) << other.err;
  EXPECT_EQ(other.err.find("resuming"), std::string::npos) << other.err;
  EXPECT_TRUE(CheckpointFolder::holds_state(kept));
  const auto resumed = test::run_tactile(arguments + std::string("--name mine --resume --threads 2"), folder.path());
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(nlohmann::json::parse(resumed.out).at("threads"), 2);
}

TEST(TrainCommand, AnInterruptedTrainingOfLibtorchsLayersKeepsItsThreads) {
  const test::TemporaryFolder folder;
  test::make_runs(folder / "data", {"fan", "usb-hub"}, 2);
  windows::write_dataset(folder / "data", folder / "data/dataset.h5", {}, 1);
  const std::string command = arguments + std::string("--name mine --engine libtorch");
  {
    const test::RunningCommand training(command + " --threads 1", folder.path());
    ASSERT_TRUE(test::comes_true([&] { return CheckpointFolder::holds_state(folder / "models/mine.training"); }))
        << training.err();
  }
  const auto resumed = test::run_tactile(command + " --resume --threads 2", folder.path());
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(nlohmann::json::parse(resumed.out).at("threads"), 1) << "others would change the last digits";
  EXPECT_NE(resumed.err.find("resumed with 1 thread, as it began"), std::string::npos) << resumed.err;
}

}  // namespace
}  // namespace tactile::model
