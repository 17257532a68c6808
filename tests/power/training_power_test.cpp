#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "model/small_data.hpp"
#include "power/cuts.hpp"
#include "support/power_cut.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/training/checkpoint.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using test::run_tactile;

const std::string arguments = "train --epochs 2 --batch 24 --validation 0.2 --save-every 0 --threads 1 --name mine";
const std::string bundle = "models/mine", kept_folder = "models/mine.training", kept_state = kept_folder + "/last.safetensors";

/// The files of the model in an image, by name; empty if the image has no model.
test::FolderImage bundle_in(const test::FolderImage& image) {
  test::FolderImage files;
  for (const auto& [path, content] : image) {
    if (path.starts_with(bundle + "/")) files[path] = content;
  }
  return files;
}

/// The entry of the journal that removes the name for good.
std::size_t removal_of(const std::string& name, const test::WrittenJournal& journal) {
  std::size_t removal = 0;
  for (std::size_t entry = 0; entry < journal.entries.size(); ++entry) {
    for (const auto& [changed, node] : journal.entries[entry].names) removal = changed == name && !node ? entry : removal;
  }
  EXPECT_GT(removal, 0U) << name;
  return removal;
}

TEST(TrainingAfterPowerCut, LeavesACompleteModelOrNoneAndResumes) {
  const test::TemporaryFolder folder;
  const fs::path lab = folder / "lab";
  test::make_runs(lab / "data", {"fan", "usb-hub"}, 2);
  windows::write_dataset(lab / "data", lab / "data/dataset.h5", {}, 1);
  ASSERT_EQ(run_tactile("heatmaps --th 40", lab).exit_code, 0);
  const auto journal = test::journal_of(test::tactile_command(arguments), lab);
  REQUIRE_JOURNAL(journal);
  const test::PowerCut cut(*journal);
  const test::FolderImage whole = cut.whole();
  test::expect_complete(*journal, whole, lab);
  ASSERT_FALSE(bundle_in(whole).empty());

  // Every state of the training that was complete on the disk at some moment.
  std::set<std::string> states;
  for (std::size_t entry = 0; entry < journal->entries.size(); ++entry) {
    if (journal->entries[entry].kind != test::JournalEntry::Kind::sync_ends) continue;
    const test::FolderImage certain = cut.after(entry + 1, nullptr);
    if (const auto state = certain.find(kept_state); state != certain.end()) states.insert(*state->second);
  }
  ASSERT_GT(states.size(), 2U);

  const std::uint64_t seed = test::power_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const std::size_t cuts = test::power_cuts(80);
  std::size_t with_model = 0, with_state = 0, number = 0;
  for (const std::size_t moment : cut.moments(cuts, random)) {
    SCOPED_TRACE("cut after entry " + std::to_string(moment) + " of " + std::to_string(journal->entries.size()));
    const test::FolderImage image = cut.after(moment, &random);
    const test::FolderImage model = bundle_in(image);
    EXPECT_TRUE(model.empty() || model == bundle_in(whole)) << "an incomplete model";
    EXPECT_FALSE(model.empty() && image.contains(bundle)) << "a model folder without files";
    with_model += model.empty() ? 0 : 1;
    const auto state = image.find(kept_state);
    if (state != image.end()) {
      EXPECT_TRUE(states.contains(*state->second)) << "an incomplete state of the training";
      ++with_state;
    }
    if (number++ % std::max<std::size_t>(1, cuts / 5) != 0) continue;  // a training takes some time
    const test::TemporaryFolder place;
    test::write_image(image, place.path());
    const auto resumed = run_tactile(arguments + " --resume", place.path());
    EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
    EXPECT_EQ(bundle_in(test::image_of(place.path())).at(bundle + "/weights.safetensors"),
              whole.at(bundle + "/weights.safetensors"));
  }
  EXPECT_GT(with_model, 0U);
  EXPECT_GT(with_state, 5U);
  EXPECT_EQ(bundle_in(cut.after(journal->entries.size(), nullptr)), bundle_in(whole))
      << "the command has ended, but its model is not on the disk";

  // Killed at any moment: the state that is there has all of its files, also while they are removed in the end.
  std::size_t with_best = 0;
  for (std::size_t entry = 0; entry < journal->entries.size(); ++entry) {
    if (journal->entries[entry].kind != test::JournalEntry::Kind::names) continue;
    const test::FolderImage image = cut.killed_after(entry + 1);
    if (!image.contains(kept_state)) continue;
    const test::TemporaryFolder place;
    test::write_image(image, place.path());
    const auto state = nlohmann::json::parse(model::read_metadata(place / kept_state).at("state"));
    if (state.at("best").is_null()) continue;
    ++with_best;
    const fs::path best = model::CheckpointFolder::best_weights(place / kept_folder, state.at("best").at("epoch"));
    EXPECT_TRUE(fs::exists(best)) << best << " after entry " << entry;
  }
  EXPECT_GT(with_best, 5U);
  // Whatever the order of names in the folder.
  EXPECT_LT(removal_of("last.safetensors", *journal), removal_of("history.csv", *journal));

  const test::WrittenJournal unsynced = test::without_syncs(*journal);
  const test::PowerCut unsynced_cut(unsynced);
  std::size_t damaged = 0;
  for (int i = 0; i < 80; ++i) {
    const test::FolderImage model = bundle_in(unsynced_cut.after(unsynced.entries.size(), &random));
    damaged += !model.empty() && model != bundle_in(whole) ? 1 : 0;
  }
  EXPECT_GT(damaged, 0U) << "without syncs some models are damaged";
}

}  // namespace
}  // namespace tactile::cli
