#include "tactile/core/process.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <system_error>
#include <thread>

#include "support/comes_true.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

TEST(ChildProcess, HasItsStreamsAndItsStatus) {
  const test::TemporaryFolder folder;
  write_whole(folder / "in", "text");
  const int in = ::open((folder / "in").c_str(), O_RDONLY | O_CLOEXEC);
  const int out = ::open((folder / "out").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  ChildProcess child({.program = "sh", .arguments = {"-c", "cat; exit 3"}, .in = in, .out = out});
  ::close(in);
  ::close(out);
  const int status = child.wait();
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 3);
  EXPECT_EQ(read_text(folder / "out"), "text");
}

TEST(ChildProcess, AProgramThatDoesNotExistIsAnError) {
  try {
    ChildProcess child({.program = "/no/such/program", .arguments = {}});
    FAIL() << "started";
  } catch (const std::system_error& e) {
    EXPECT_EQ(e.code().value(), ENOENT);
  }
}

TEST(ChildProcess, EndsWithItsObject) {
  const test::TemporaryFolder folder;
  {
    const ChildProcess child(
        {.program = "sh", .arguments = {"-c", "echo $$ > '" + (folder / "pid").string() + "'; exec sleep 600"}});
    const auto pid = folder / "pid";
    ASSERT_TRUE(test::comes_true([&] { return std::filesystem::exists(pid) && std::filesystem::file_size(pid) > 0; }));
  }
  EXPECT_NE(::kill(static_cast<pid_t>(std::stol(read_text(folder / "pid"))), 0), 0);
}

TEST(ChildProcess, EndsBySignalsThatThisProcessIgnores) {
  const auto before = ::signal(SIGINT, SIG_IGN);
  ChildProcess child({.program = "sleep", .arguments = {"600"}});
  ::signal(SIGINT, before);
  EXPECT_FALSE(child.status_if_ended());
  child.send(SIGINT);
  const int status = child.wait();
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGINT);
}

}  // namespace
}  // namespace tactile
