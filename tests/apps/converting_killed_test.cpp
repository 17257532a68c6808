#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "events/made_recording.hpp"
#include "support/kill_moments.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "support/traced_calls.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Starts the built `tactile` in the folder, silent.
pid_t start(const fs::path& folder, const std::vector<std::string>& arguments) {
  std::vector<char*> words{const_cast<char*>(test::tactile_binary)};
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  const pid_t process = ::fork();
  if (process == 0) {
    const int nowhere = ::open("/dev/null", O_RDWR);
    for (const int stream : {0, 1, 2}) ::dup2(nowhere, stream);
    if (::chdir(folder.c_str()) == 0) ::execv(test::tactile_binary, words.data());
    ::_exit(127);
  }
  return process;
}

int status_of(pid_t process) {
  int status = 0;
  EXPECT_EQ(::waitpid(process, &status, 0), process);
  return status;
}

/// A recording that takes a command long enough to be killed in the midst of it.
class KilledCommand : public testing::Test {
 protected:
  KilledCommand() {
    const events::SensorSize size{640, 480};
    events::RecordingWriter writer(in, {events::event_stream_declaration(size, "DVXplorer_DXM00001")},
                                   {.compression = events::Compression::none});
    std::minstd_rand random(7);
    std::vector<events::Event> events;
    for (std::int64_t t = 0; t < 4'000'000; t += 2) {
      events.push_back(
          test::event_at(t, static_cast<int>(random() % 640), static_cast<int>(random() % 480), static_cast<int>(random() % 2)));
    }
    writer.write_events(0, events);
    writer.close();
  }

  std::ptrdiff_t files() const { return std::distance(fs::directory_iterator(folder.path()), {}); }

  /// What the command has written so far, under whatever name; nothing while there is no file of it.
  std::optional<std::uintmax_t> written() const {
    std::optional<std::uintmax_t> most;
    for (const fs::directory_entry& file : fs::directory_iterator(folder.path())) {
      std::error_code renamed;
      const std::uintmax_t size = file.path() == in ? 0 : fs::file_size(file.path(), renamed);
      if (file.path() != in && !renamed) most = std::max(most.value_or(0), size);
    }
    return most;
  }

  /// Waits until the command has written so many bytes, or ends; its status if it ended.
  std::optional<int> wait_for_output(pid_t process, std::uintmax_t bytes = 0) const {
    for (int status = 0;; std::this_thread::sleep_for(200us)) {
      if (::waitpid(process, &status, WNOHANG) == process) return status;
      if (const auto now = written(); now && *now >= bytes) return std::nullopt;
    }
  }

  /// Kills the command at 20 moments, half of them drawn over what it takes undisturbed, half over the bytes that it writes: each
  /// leaves nothing or the whole file, and the input as it was. Another run then does its work and clears away what the killed
  /// ones left.
  void expect_all_or_nothing(const std::vector<std::string>& arguments, const std::string& out) {
    const std::string input = sha256_of_file(in);
    const Clock::time_point begin = Clock::now();
    const pid_t undisturbed = start(folder.path(), arguments);
    ASSERT_EQ(status_of(undisturbed), 0);
    test::KillMoments moments(Clock::now() - begin, 1);
    const std::string whole = sha256_of_file(folder / out);
    const std::uintmax_t whole_size = fs::file_size(folder / out);
    fs::remove(folder / out);

    Random random(1);
    int cut_short = 0;
    for (int i = 0; i < 20; ++i) {
      for (const fs::directory_entry& file : fs::directory_iterator(folder.path())) {
        if (file.path() != in) fs::remove_all(file.path());
      }
      const pid_t process = start(folder.path(), arguments);
      const std::optional<int> ended = i % 2 == 0 ? std::nullopt : wait_for_output(process, random.below(whole_size));
      if (i % 2 == 0) moments.sleep(0, 1);
      if (!ended) ::kill(process, SIGKILL);
      const int status = ended ? *ended : status_of(process);
      if (fs::exists(folder / out)) {
        EXPECT_EQ(sha256_of_file(folder / out), whole);
        if (i % 2 == 0) moments.were_too_late();
      } else if (WIFSIGNALED(status) && files() == 2) {
        ++cut_short;
      }
      EXPECT_EQ(sha256_of_file(in), input);
    }
    EXPECT_GT(cut_short, 0) << "no kill came amid the writing";

    fs::remove(folder / out);
    const pid_t killed = start(folder.path(), arguments);
    ASSERT_FALSE(wait_for_output(killed).has_value());
    ::kill(killed, SIGKILL);
    status_of(killed);
    fs::remove(folder / out);  // it may have come to its end
    ASSERT_EQ(status_of(start(folder.path(), arguments)), 0);
    EXPECT_EQ(sha256_of_file(folder / out), whole);
    EXPECT_EQ(files(), 2) << "what the killed run left is still there";
  }

  test::TemporaryFolder folder;
  const fs::path in = folder / "in.aedat4";
};

TEST_F(KilledCommand, ConvertToAedat4LeavesAllOrNothing) {
  expect_all_or_nothing({"convert", "in.aedat4", "out.aedat4", "--compression", "zstd"}, "out.aedat4");
}

TEST_F(KilledCommand, ConvertToHdf5LeavesAllOrNothing) { expect_all_or_nothing({"convert", "in.aedat4", "out.h5"}, "out.h5"); }

TEST_F(KilledCommand, RepairLeavesAllOrNothing) {
  // Without its table every packet must be read: it takes its time.
  test::cut_off_table(in);
  expect_all_or_nothing({"repair", "in.aedat4", "out.aedat4"}, "out.aedat4");
}

TEST_F(KilledCommand, ConvertKeepsAFileThatAppearsWhileItWorks) {
  bool appeared = false;
  const auto appears_ahead_of_the_renaming = [&](const test::TracedCall& call) {
    if (call.number == SYS_renameat2 && !appeared) {
      write_whole(folder / "out.h5", "of another program");
      appeared = true;
    }
    return true;
  };
  const std::optional<int> exit_code = test::trace_calls({test::tactile_binary, "convert", "in.aedat4", "out.h5"}, folder.path(),
                                                         appears_ahead_of_the_renaming, [](const test::TracedCall&) {});
  if (!exit_code) GTEST_SKIP() << "this machine allows no tracing";
  EXPECT_TRUE(appeared);
  EXPECT_EQ(exit_code, 1);
  EXPECT_EQ(read_text(folder / "out.h5"), "of another program");
  EXPECT_EQ(files(), 2);
}

TEST_F(KilledCommand, OnlyOneOfTwoConvertsToOneOutputEndsWell) {
  const std::array processes{start(folder.path(), {"convert", "in.aedat4", "out.h5"}),
                             start(folder.path(), {"convert", "in.aedat4", "out.h5"})};
  std::array<int, 2> codes{};
  for (std::size_t i : {0, 1}) {
    const int status = status_of(processes.at(i));
    ASSERT_TRUE(WIFEXITED(status));
    codes.at(i) = WEXITSTATUS(status);
  }
  EXPECT_EQ(std::min(codes[0], codes[1]), 0);
  EXPECT_EQ(std::max(codes[0], codes[1]), 1);
  ASSERT_EQ(status_of(start(folder.path(), {"convert", "in.aedat4", "alone.h5"})), 0);
  EXPECT_EQ(sha256_of_file(folder / "out.h5"), sha256_of_file(folder / "alone.h5"));
}

TEST_F(KilledCommand, ConvertsInTwoContainersDoNotWriteIntoEachOther) {
  if (test::run_shell("unshare -pf --mount-proc true").exit_code != 0) GTEST_SKIP() << "this machine makes no process namespace";
  test::cut_off_table(folder / "in.aedat4");
  // A process has the same number in each of them.
  const std::string convert = std::string("unshare -pf --mount-proc '") + test::tactile_binary + "' convert ";
  const auto both = test::run_shell("(" + convert + "in.aedat4 out.h5; echo $? >first) & " + convert +
                                        "in.aedat4 out.h5 --to-us 1000000; echo $? >second; wait",
                                    folder.path());
  const bool first_won = read_text(folder / "first") == "0\n";
  EXPECT_EQ(read_text(folder / "first") + read_text(folder / "second"), first_won ? "0\n1\n" : "1\n0\n") << both.err;
  ASSERT_EQ(
      test::run_tactile(first_won ? "convert in.aedat4 alone.h5" : "convert in.aedat4 alone.h5 --to-us 1000000", folder.path())
          .exit_code,
      0);
  EXPECT_EQ(sha256_of_file(folder / "out.h5"), sha256_of_file(folder / "alone.h5"));
}

}  // namespace
}  // namespace tactile::cli
