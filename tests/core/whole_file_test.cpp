#include "tactile/core/whole_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <string>
#include <thread>

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

TEST(ReadText, ReadsAPipeToItsEndAndNoFurtherThanItsLimit) {
  const test::TemporaryFolder folder;
  const std::filesystem::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto read_behind_a_pipe = [&](const std::string& text, std::size_t limit) {
    std::thread writing([&] { std::ofstream(pipe) << text; });  // less than a pipe holds: it never waits for who reads
    std::string outcome;
    try {
      outcome = read_text(pipe, limit);
    } catch (const Error& e) {
      outcome = e.what();
    }
    writing.join();
    return outcome;
  };
  EXPECT_EQ(read_behind_a_pipe("twelve bytes", 12), "twelve bytes");
  EXPECT_EQ(read_behind_a_pipe("", 12), "");
  EXPECT_EQ(read_behind_a_pipe("thirteen byte", 12), pipe.string() + ": more than 12 bytes long; expected at most 12");
}

TEST(ReadText, ReadsAllOfALongFileAndNamesTheSizeOfOneThatIsTooLong) {
  const test::TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 50'000; ++i) text += std::to_string(i);
  write_whole(folder / "long", text);
  EXPECT_EQ(read_text(folder / "long"), text);
  EXPECT_EQ(read_text(folder / "long", text.size()), text);
  try {
    read_text(folder / "long", text.size() - 1);
    FAIL() << "expected an error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(std::to_string(text.size()) + " bytes long"), std::string::npos) << e.what();
  }
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

/// Dies before it commits, as a killed process does.
std::filesystem::path left_by_a_dead_process(const std::filesystem::path& target) {
  std::array<int, 2> pipe{};
  EXPECT_EQ(::pipe(pipe.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    WholeFile whole(target);
    std::ofstream(whole.path()) << "half";
    const std::string path = whole.path().string();
    static_cast<void>(::write(pipe[1], path.data(), path.size()));
    ::_exit(0);
  }
  std::array<char, 4096> path{};
  EXPECT_GT(::read(pipe[0], path.data(), path.size() - 1), 0);
  ::waitpid(child, nullptr, 0);
  ::close(pipe[0]);
  ::close(pipe[1]);
  return path.data();
}

TEST(RemoveLeftovers, TakesWhatTheDeadLeftOfThisTargetAlone) {
  const test::TemporaryFolder folder;
  const auto of_this = left_by_a_dead_process(folder / "result.txt"), of_another = left_by_a_dead_process(folder / "other.txt");
  WholeFile alive(folder / "result.txt");
  std::ofstream(alive.path()) << "half";
  const std::string elsewhere = of_this.string().replace(of_this.string().find('@'), 1, "@elsewhere-");
  std::ofstream(elsewhere) << "half";
  write_whole(folder / ".result.mine.part.txt", "not one of ours");
  ASSERT_TRUE(std::filesystem::exists(of_this));
  remove_leftovers(folder / "result.txt");
  EXPECT_FALSE(std::filesystem::exists(of_this));
  EXPECT_TRUE(std::filesystem::exists(of_another));
  EXPECT_TRUE(std::filesystem::exists(alive.path()));
  EXPECT_TRUE(std::filesystem::exists(elsewhere));
  EXPECT_TRUE(std::filesystem::exists(folder / ".result.mine.part.txt"));
  remove_leftovers(folder / "no-such-folder/result.txt");
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
