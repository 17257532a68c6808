#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "power/cuts.hpp"
#include "support/power_cut.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/dataset_contents.hpp"
#include "windows/made_runs.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using test::dataset_contents;
using test::run_tactile;

class DatasetAfterPowerCut : public testing::Test {
 protected:
  void SetUp() override {
    test::make_run(lab() / "data", {.object = "fan", .run = "01", .seed = 1});
    test::make_run(lab() / "data", {.object = "fan", .run = "02", .seed = 2, .begin_us = -700'123});
  }

  fs::path lab() const { return folder / "lab"; }
  fs::path file() const { return lab() / "data/dataset.h5"; }

  /// Cuts the power while `windows` works. The dataset must be the new one or one of `allowed_before`; empty contents: no
  /// dataset.
  void cut_windows(const std::string& options, const std::set<test::DatasetContents>& allowed_before,
                   std::size_t expected_states) {
    const auto journal = test::journal_of(test::tactile_command("windows --threads 1 " + options), lab());
    REQUIRE_JOURNAL(journal);
    const test::PowerCut cut(*journal);
    test::expect_complete(*journal, cut.whole(), lab());
    std::set<test::DatasetContents> allowed = allowed_before;
    allowed.insert(dataset_contents(file()));

    const std::uint64_t seed = test::power_seed();
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    std::map<std::string, std::size_t> seen;
    std::set<test::DatasetContents> found;
    std::size_t number = 0;
    for (const std::size_t moment : cut.moments(test::power_cuts(60), random)) {
      const test::FolderImage image = cut.after(moment, &random);
      if (seen[test::hash_of(image)]++ > 0) continue;
      SCOPED_TRACE("cut after entry " + std::to_string(moment) + " of " + std::to_string(journal->entries.size()));
      const test::TemporaryFolder place;
      test::write_image(image, place.path());
      const bool is_there = image.contains("data/dataset.h5");
      const test::DatasetContents contents = is_there ? dataset_contents(place / "data/dataset.h5") : test::DatasetContents();
      EXPECT_TRUE(allowed.contains(contents)) << "neither the old dataset nor the new one";
      found.insert(contents);
      if (is_there) {
        const auto verify = run_tactile("windows --verify", place.path());
        EXPECT_EQ(verify.exit_code, 0) << verify.err;
      }
      if (number++ % 10 != 0) continue;  // a command takes some time
      const auto repeated = run_tactile("windows " + options, place.path());
      EXPECT_EQ(repeated.exit_code, 0) << repeated.err;
      EXPECT_EQ(dataset_contents(place / "data/dataset.h5"), dataset_contents(file()));
    }
    EXPECT_GE(found.size(), expected_states) << "no cut before the change, or no cut after it";
    EXPECT_EQ(cut.after(journal->entries.size(), nullptr).count("data/dataset.h5"), 1U)
        << "the command has ended, but its dataset is not on the disk";
    expect_damage_without_syncs(*journal);
  }

  /// Without syncs, power cuts after the end of the command leave files that are neither the old nor the new dataset.
  static void expect_damage_without_syncs(const test::WrittenJournal& journal) {
    const test::WrittenJournal unsynced = test::without_syncs(journal);
    const test::PowerCut cut(unsynced);
    const test::FolderImage before = cut.after(0, nullptr), whole = cut.whole();
    Random random(test::power_seed());
    std::size_t damaged = 0;
    for (int i = 0; i < 80; ++i) {
      const test::FolderImage image = cut.after(unsynced.entries.size(), &random);
      const auto file = image.find("data/dataset.h5"), old = before.find("data/dataset.h5");
      damaged += file != image.end() && file->second != whole.at("data/dataset.h5") &&
                         (old == before.end() || file->second != old->second)
                     ? 1
                     : 0;
    }
    EXPECT_GT(damaged, 0U);
  }

  test::TemporaryFolder folder;
};

TEST_F(DatasetAfterPowerCut, IsCompleteOrAbsent) { cut_windows("", {{}}, 2); }

TEST_F(DatasetAfterPowerCut, IsTheOldOneOrTheNewOne) {
  windows::write_dataset(lab() / "data", file());
  cut_windows("--seed 2", {dataset_contents(file())}, 2);
}

}  // namespace
}  // namespace tactile::cli
