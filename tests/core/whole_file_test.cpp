#include "tactile/core/whole_file.hpp"

#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/sha256.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

TEST(WholeFile, IsNotThereBeforeItIsCommitted) {
  const test::TemporaryFolder folder;
  WholeFile whole(folder / "result.txt", IfThere::refuse);
  std::ofstream(whole.path()) << "half";
  EXPECT_FALSE(std::filesystem::exists(folder / "result.txt"));
  whole.commit();
  EXPECT_EQ(read_text(folder / "result.txt"), "half");
}

TEST(WholeFile, LeavesNoEmptyFolderThatItMade) {
  const test::TemporaryFolder folder;
  fs::create_directory(folder / "old");
  for (const char* above : {"new/inner", "old"}) {
    const WholeFile failed(folder / above / "result.txt", IfThere::refuse);
    std::ofstream(failed.path()) << "half";
  }
  EXPECT_FALSE(fs::exists(folder / "new"));
  EXPECT_TRUE(fs::exists(folder / "old")) << "it was there before";
  write_whole(folder / "new/inner/result.txt", "whole");
  EXPECT_EQ(read_text(folder / "new/inner/result.txt"), "whole");
}

TEST(WholeFile, IsMadeThoughAnotherTakesItsEmptyFolderAway) {
  const test::TemporaryFolder folder;
  const auto write_often = [&](const char* name) {
    for (int i = 0; i < 300; ++i) {
      { const PartFolder failed(folder / "shared" / name); }
      write_whole(folder / "shared" / name, "whole");
      fs::remove(folder / "shared" / name);
    }
  };
  std::thread beside([&] { write_often("a"); });
  write_often("b");
  beside.join();
}

TEST(ReadText, ReadsAPipeToItsEndAndNoFurtherThanItsLimit) {
  const test::TemporaryFolder folder;
  const std::filesystem::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto read_through_a_pipe = [&](const std::string& text, std::size_t limit) {
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
  EXPECT_EQ(read_through_a_pipe("twelve bytes", 12), "twelve bytes");
  EXPECT_EQ(read_through_a_pipe("", 12), "");
  EXPECT_EQ(read_through_a_pipe("thirteen byte", 12), pipe.string() + ": more than 12 bytes long; expected at most 12");
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
    WholeFile whole(folder / "result.txt", IfThere::replace);
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
    WholeFile whole(target, IfThere::replace);
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
  const auto of_another = left_by_a_dead_process(folder / "other.txt"), of_this = left_by_a_dead_process(folder / "result.txt");
  const fs::path killed_early = folder / ".result.txt.part-Ab3Xyz", not_ours = folder / ".result.txt.part-Ab3Xyw";
  fs::create_directory(killed_early);
  fs::create_directory(not_ours);
  write_whole(not_ours / "mine", "a folder of the user");
  write_whole(folder / ".result.txt.part-Ab3Xyv", "a file of the user");
  ASSERT_TRUE(fs::exists(of_this));
  remove_leftovers(folder / "result.txt");
  EXPECT_FALSE(fs::exists(of_this.parent_path()));
  EXPECT_FALSE(fs::exists(killed_early));
  EXPECT_TRUE(fs::exists(of_another));
  EXPECT_TRUE(fs::exists(not_ours / "mine"));
  EXPECT_TRUE(fs::exists(folder / ".result.txt.part-Ab3Xyv"));
  remove_leftovers_in(folder.path());
  EXPECT_FALSE(fs::exists(of_another.parent_path()));
  EXPECT_TRUE(fs::exists(not_ours / "mine"));
  remove_leftovers(folder / "no-such-folder/result.txt");
}

TEST(RemoveLeftovers, LeavesWhatIsBeingWrittenHereOrInAnotherProcess) {
  const test::TemporaryFolder folder;
  WholeFile here(folder / "result.txt", IfThere::replace);
  std::ofstream(here.path()) << "half";
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const pid_t child = ::fork();  // its number is none that a test could know
  if (child == 0) {
    WholeFile there(folder / "result.txt", IfThere::replace);
    std::ofstream(there.path()) << "theirs";
    static_cast<void>(::write(pipe[1], "x", 1));
    ::pause();
    ::_exit(0);
  }
  char ready = 0;
  ASSERT_EQ(::read(pipe[0], &ready, 1), 1);
  remove_leftovers(folder / "result.txt");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 2);
  EXPECT_EQ(read_text(here.path()), "half");
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  remove_leftovers(folder / "result.txt");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
  ::close(pipe[0]);
  ::close(pipe[1]);
}

TEST(WholeFile, IsMadeManyTimesAtOnceWhileProcessesRemoveLeftovers) {
  const test::TemporaryFolder folder;
  std::vector<std::thread> threads;
  threads.reserve(4);
  std::atomic<int> lost{0};
  for (int thread = 0; thread < 4; ++thread) {
    threads.emplace_back([&, thread] {
      for (int i = 0; i < 100; ++i) {
        WholeFile whole(folder / "result.txt", IfThere::replace);  // it looks for leftovers itself
        std::ofstream(whole.path()) << thread;
        if (!fs::exists(whole.path())) ++lost;
        whole.commit();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(lost, 0);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

/// From now on this process has no renameat2, as on some network file systems.
void refuse_renameat2() {
  std::array<sock_filter, 4> program{{
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_renameat2, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EINVAL),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  }};
  const sock_fprog filter{program.size(), program.data()};
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 || ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) != 0) ::_exit(77);
}

void make(const fs::path& place, bool as_folder, const std::string& text) {
  if (as_folder) fs::create_directory(place);
  std::ofstream(as_folder ? place / "file" : place) << text;
}
std::string read(const fs::path& place, bool is_folder) { return read_text(is_folder ? place / "file" : place); }

/// What happens to a file or a folder (`as_folder`) when a name is free, refused, or replaced.
void expect_kept_or_replaced(const fs::path& folder, bool as_folder) {
  const fs::path target = folder / (as_folder ? "a-folder" : "a-file");
  {
    WholeFile first(target, IfThere::refuse), second(target, IfThere::refuse);
    make(first.path(), as_folder, "first");
    make(second.path(), as_folder, "second");
    second.commit();
    EXPECT_EQ(test::error_of([&] { first.commit(); }),
              target.string() + ": appeared while the output was written, and is kept; expected a free name");
  }
  EXPECT_EQ(read(target, as_folder), "second");
  {
    WholeFile third(target, IfThere::replace);
    make(third.path(), as_folder, "third");
    EXPECT_FALSE(third.commit_if_free());
    EXPECT_EQ(read(target, as_folder), "second");
    third.commit();
  }
  EXPECT_EQ(read(target, as_folder), "third");
  {
    WholeFile other_kind(target, IfThere::replace);
    make(other_kind.path(), !as_folder, "other");
    EXPECT_THROW(other_kind.commit(), Error);
  }
  EXPECT_EQ(read(target, as_folder), "third");
  if (as_folder) {
    remove_whole(target);
    EXPECT_FALSE(fs::exists(target));
    remove_whole(target);
  }
}

TEST(WholeFile, ReplacesOnlyWhatItMay) {
  const test::TemporaryFolder folder;
  for (const bool as_folder : {false, true}) expect_kept_or_replaced(folder.path(), as_folder);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(WholeFile, ReplacesOnlyWhatItMayWhereTheFileSystemKnowsNoRenameat2) {
  const test::TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    refuse_renameat2();
    for (const bool as_folder : {false, true}) expect_kept_or_replaced(folder.path(), as_folder);
    ::_exit(testing::Test::HasFailure() ? 1 : 0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 77) GTEST_SKIP() << "this machine takes no seccomp filter";
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
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
