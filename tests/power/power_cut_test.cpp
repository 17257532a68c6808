#include "support/power_cut.hpp"

#include <gtest/gtest.h>

#include <string>

#include "power/cuts.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

/// Shell commands that replace the contents of `target`, 64 000 times the letter a, by as many b, in blocks of 1000.
class PowerCutOfShell : public testing::Test {
 protected:
  void SetUp() override {
    write_whole(folder / "target", old);
    write_whole(outside / "new", replaced);
  }

  std::optional<test::WrittenJournal> shell(const std::string& script) const {
    auto journal = test::journal_of({"sh", "-e", "-c", script}, folder.path());
    if (journal) {
      SCOPED_TRACE(script);
      test::expect_complete(*journal, test::PowerCut(*journal).whole(), folder.path());
    }
    return journal;
  }
  std::string from_outside() const { return "if='" + (outside / "new").string() + "' bs=1000 2>/dev/null"; }

  /// Number of power cuts after which `target` is absent, or has neither the old nor the new contents.
  static std::size_t damaged(const test::WrittenJournal& journal) {
    Random random(test::power_seed());
    const test::PowerCut cut(journal);
    std::size_t count = 0;
    for (const std::size_t moment : cut.moments(200, random)) {
      const test::FolderImage image = cut.after(moment, &random);
      const auto found = image.find("target");
      count += found == image.end() || (found->second != old && found->second != replaced) ? 1 : 0;
    }
    return count;
  }

  static inline const std::string old = std::string(64'000, 'a'), replaced = std::string(64'000, 'b');
  test::TemporaryFolder folder, outside;
};

TEST_F(PowerCutOfShell, TheJournalHasEveryChange) {
  fs::create_directories(folder / "there/below");
  write_whole(folder / "there/below/file", "text");
  const auto journal = shell("mkdir made; dd of=made/one " + from_outside() +
                             "; mv there moved; ln made/one two; rm made/one;"
                             "cp target three; printf tail >>three; truncate -s 100 two; mv two target; rm -r moved;"
                             "mkdir made/empty; rmdir made/empty; mv made/ other");
  REQUIRE_JOURNAL(journal);
  EXPECT_GT(journal->entries.size(), 20U);
}

TEST_F(PowerCutOfShell, AFileThatIsSyncedAndThenRenamedIsTheOldOneOrTheNewOne) {
  const auto journal = shell("dd of=part conv=fsync " + from_outside() + "; mv part target; sync .");
  REQUIRE_JOURNAL(journal);
  EXPECT_EQ(damaged(*journal), 0U);
  const test::PowerCut cut(*journal);
  EXPECT_EQ(cut.after(journal->entries.size(), nullptr).at("target"), replaced);
}

TEST_F(PowerCutOfShell, AFileThatIsRenamedButNotSyncedIsDamaged) {
  const auto journal = shell("dd of=part " + from_outside() + "; mv part target; sync .");
  REQUIRE_JOURNAL(journal);
  EXPECT_GT(damaged(*journal), 20U);
}

TEST_F(PowerCutOfShell, AFileThatIsWrittenInPlaceIsDamaged) {
  const auto journal = shell("dd of=target conv=fsync " + from_outside());
  REQUIRE_JOURNAL(journal);
  EXPECT_GT(damaged(*journal), 20U);
}

TEST_F(PowerCutOfShell, ARenameIsLostUntilItsFolderIsSynced) {
  const auto journal = shell("dd of=part conv=fsync " + from_outside() + "; mv part target");
  REQUIRE_JOURNAL(journal);
  EXPECT_EQ(test::PowerCut(*journal).after(journal->entries.size(), nullptr).at("target"), old);
}

TEST_F(PowerCutOfShell, AFileIsLostUntilTheFolderAboveItsFolderIsSynced) {
  const std::string makes = "mkdir made; dd of=made/file conv=fsync " + from_outside() + "; sync made";
  const auto lost = shell(makes);
  REQUIRE_JOURNAL(lost);
  EXPECT_FALSE(test::PowerCut(*lost).after(lost->entries.size(), nullptr).contains("made/file"));
  fs::remove_all(folder / "made");
  const auto kept = shell(makes + "; sync .");
  EXPECT_EQ(test::PowerCut(*kept).after(kept->entries.size(), nullptr).at("made/file"), replaced);
}

TEST_F(PowerCutOfShell, SomeBlocksOfWritesAfterASyncAreThere) {
  const auto journal =
      shell("dd of=growing conv=fsync " + from_outside() + "; sync .; dd of=growing conv=notrunc oflag=append " + from_outside());
  REQUIRE_JOURNAL(journal);
  Random random(test::power_seed());
  const test::PowerCut cut(*journal);
  std::size_t whole = 0, with_holes = 0, as_synced = 0;
  for (int i = 0; i < 200; ++i) {
    const std::string content = *cut.after(journal->entries.size(), &random).at("growing");
    EXPECT_TRUE(content.starts_with(replaced)) << "it was synced";
    as_synced += content.size() == replaced.size() ? 1 : 0;
    whole += content == replaced + replaced ? 1 : 0;
    const std::size_t hole = content.find('\0');
    with_holes += hole != std::string::npos && content.find('b', hole) != std::string::npos ? 1 : 0;
  }
  EXPECT_GT(whole, 20U);
  EXPECT_GT(as_synced, 20U);
  EXPECT_GT(with_holes, 20U);
}

}  // namespace
}  // namespace tactile::cli
