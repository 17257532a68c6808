#include "tactile/core/whole_file.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/sha256.hpp"

namespace tactile {
namespace {

TEST(WholeFile, IsNotThereBeforeItIsCommitted) {
  const test::TemporaryFolder folder;
  WholeFile whole(folder / "result.txt");
  std::ofstream(whole.path()) << "half";
  EXPECT_FALSE(std::filesystem::exists(folder / "result.txt"));
  whole.commit();
  EXPECT_EQ(read_text(folder / "result.txt"), "half");
}

TEST(WholeFile, LeavesTheOldFileAndNoRubbishWhenItIsGivenUp) {
  const test::TemporaryFolder folder;
  write_whole(folder / "result.txt", "old");
  {
    WholeFile whole(folder / "result.txt");
    std::ofstream(whole.path()) << "new, but";
  }
  EXPECT_EQ(read_text(folder / "result.txt"), "old");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(ReadText, RefusesAFileThatIsMissingOrTooLong) {
  const test::TemporaryFolder folder;
  write_whole(folder / "long.txt", "0123456789");
  EXPECT_THROW(read_text(folder / "long.txt", 9), Error);
  EXPECT_THROW(read_text(folder / "missing.txt"), Error);
}

TEST(Sha256, GivesTheStandardsOwnExample) {
  // FIPS 180-4, the message "abc".
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const test::TemporaryFolder folder;
  write_whole(folder / "abc", "abc");
  EXPECT_EQ(sha256_of_file(folder / "abc"), sha256_of("abc"));
}

}  // namespace
}  // namespace tactile
