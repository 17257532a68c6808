#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "power/cuts.hpp"
#include "support/paths.hpp"
#include "support/power_cut.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/dataset_contents.hpp"
#include "windows/made_runs.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;
using test::dataset_contents;
using test::run_tactile;

class DatasetCutOff : public testing::Test {
 protected:
  void SetUp() override {
    test::make_run(lab() / "data", {.object = "fan", .run = "01", .seed = 1});
    test::make_run(lab() / "data", {.object = "fan", .run = "02", .seed = 2, .begin_us = -700'123});
  }

  fs::path lab() const { return folder / "lab"; }
  fs::path file() const { return lab() / "data/dataset.h5"; }

  /// Cuts the power while `windows` works. What is left must be one of `allowed`, which an empty one allows to be absent.
  void cut_windows(const std::string& options, const std::set<test::DatasetContents>& allowed_before,
                   std::size_t expected_states) {
    std::vector<std::string> words{test::tactile_binary, "windows", "--threads", "1"};
    std::istringstream options_in(options);
    for (std::string word; options_in >> word;) words.push_back(word);
    const auto journal = test::journal_of(words, lab());
    if (!journal) GTEST_SKIP() << "this machine allows no tracing: no journal can be kept";
    ASSERT_EQ(journal->exit_code, 0);
    ASSERT_TRUE(journal->unseen.empty()) << *journal->unseen.begin();
    const test::PowerCut cut(*journal);
    ASSERT_EQ(cut.whole(), test::image_of(lab())) << "the journal lacks something";
    std::set<test::DatasetContents> allowed = allowed_before;
    allowed.insert(dataset_contents(file()));

    const std::uint64_t seed = test::power_seed();
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random dice(seed);
    std::map<std::string, std::size_t> seen;
    std::set<test::DatasetContents> found;
    std::size_t number = 0;
    for (const std::size_t moment : cut.moments(test::power_cuts(60), dice)) {
      const test::FolderImage image = cut.after(moment, &dice);
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
      if (number++ % 10 != 0) continue;  // each takes its time
      const auto again = run_tactile("windows " + options, place.path());
      EXPECT_EQ(again.exit_code, 0) << again.err;
      EXPECT_EQ(dataset_contents(place / "data/dataset.h5"), dataset_contents(file()));
    }
    EXPECT_GE(found.size(), expected_states) << "no cut came before the change, or none after it";
    EXPECT_EQ(cut.after(journal->entries.size(), nullptr).count("data/dataset.h5"), 1U) << "it ended, and nothing is on the disk";
    expect_harm_without_syncs(*journal);
  }

  /// Without syncs cuts after its end leave files that are neither the old nor the new ones.
  static void expect_harm_without_syncs(const test::WrittenJournal& journal) {
    const test::WrittenJournal careless = test::without_syncs(journal);
    const test::PowerCut cut(careless);
    const test::FolderImage before = cut.after(0, nullptr), whole = cut.whole();
    Random dice(test::power_seed());
    std::size_t harmed = 0;
    for (int i = 0; i < 80; ++i) {
      const test::FolderImage image = cut.after(careless.entries.size(), &dice);
      const auto file = image.find("data/dataset.h5"), old = before.find("data/dataset.h5");
      harmed += file != image.end() && file->second != whole.at("data/dataset.h5") &&
                        (old == before.end() || file->second != old->second)
                    ? 1
                    : 0;
    }
    EXPECT_GT(harmed, 0U);
  }

  test::TemporaryFolder folder;
};

TEST_F(DatasetCutOff, IsWholeOrNotThere) { cut_windows("", {{}}, 2); }

TEST_F(DatasetCutOff, IsTheOldOneOrTheNewOne) {
  write_dataset(lab() / "data", file());
  cut_windows("--seed 2", {dataset_contents(file())}, 2);
}

}  // namespace
}  // namespace tactile
