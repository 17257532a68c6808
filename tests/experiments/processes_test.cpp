#include "tactile/experiments/processes.hpp"

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "support/comes_true.hpp"
#include "support/error_of.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::experiments {
namespace {

namespace fs = std::filesystem;

class Processes : public testing::Test {
 protected:
  ProcessPlan shell(const std::string& name, const std::string& script) const {
    return {name, {"-c", script}, folder_ / "logs" / (name + ".log")};
  }
  ProcessesOptions options(unsigned at_once = 1) const {
    return {.program = "/bin/sh", .at_once = at_once, .while_waiting = {}, .ended = {}};
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  test::TemporaryFolder folder_;
};

/// Whether a process still runs; one that waits to be reaped does not.
bool runs(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("State:")) return line.find('Z') == std::string::npos;
  }
  return false;
}

bool ends_soon(pid_t pid) {
  for (int i = 0; i < 6000 && runs(pid); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return !runs(pid);
}

TEST_F(Processes, RunToTheirEndAndAreReported) {
  std::vector<std::size_t> ended;
  auto how = options();
  how.ended = [&](std::size_t index, double seconds) {
    EXPECT_GE(seconds, 0);
    ended.push_back(index);
  };
  run_processes({shell("one", "echo 1 >> " + file("out")), shell("two", "echo 2 >> " + file("out"))}, how);
  EXPECT_EQ(ended, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(read_text(file("out")), "1\n2\n") << "one at a time, in their order";
}

TEST_F(Processes, RunSideBySide) {
  // Each waits for the other: alone neither would come to its end.
  const auto waits = [&](const std::string& mine, const std::string& other) {
    return "touch " + file(mine) + "; while [ ! -e " + file(other) + " ]; do sleep 0.01; done";
  };
  run_processes({shell("a", waits("a.there", "b.there")), shell("b", waits("b.there", "a.there"))}, options(2));
}

TEST_F(Processes, OneThatWaitsForAnotherLetsLaterOnesPass) {
  const auto writes = [&](const std::string& name) { return "echo " + name + " >> " + file("out"); };
  std::vector<ProcessPlan> plans{
      shell("first", "while [ ! -s " + file("out") + " ]; do sleep 0.01; done; sleep 0.1; " + writes("first")),
      shell("after-it", writes("after it")), shell("third", writes("third"))};
  plans[1].after = 0;
  run_processes(plans, options(2));
  EXPECT_EQ(read_text(file("out")), "third\nfirst\nafter it\n");
}

TEST_F(Processes, AFailureIsReportedWithItsLastMessageAndEndsTheOthers) {
  const std::string error = test::error_of([&] {
    run_processes(
        {shell("tactile train b", "echo $$ > " + file("pid") + "; exec sleep 600"),
         shell("tactile train a", "while [ ! -s " + file("pid") +
                                      " ]; do sleep 0.01; done; echo first >&2; echo 'tactile: no such dataset' >&2; exit 1")},
        options(2));
  });
  EXPECT_EQ(error, "'tactile train a' failed: no such dataset");
  EXPECT_FALSE(runs(static_cast<pid_t>(std::stol(read_text(file("pid"))))));
}

TEST_F(Processes, ThoseThatEndedWellBesideAFailureAreReported) {
  std::vector<std::size_t> ended;
  auto how = options(2);
  how.ended = [&](std::size_t index, double) { ended.push_back(index); };
  const auto write_number = [&](const std::string& name) { return "echo $$ >" + file(name); };
  const auto has_ended = [&](const std::string& name) {
    const std::string number = test::text_in_file(file(name));
    return number.ends_with('\n') && !runs(static_cast<pid_t>(std::stol(number)));
  };
  bool both_are_over = false;
  how.while_waiting = [&] {
    if (both_are_over) return;
    both_are_over = test::comes_true([&] { return has_ended("a") && has_ended("b"); });
  };
  const std::string error = test::error_of([&] {
    run_processes({shell("bad", write_number("a") + "; exit 3"), shell("good", write_number("b"))}, how);
  });
  EXPECT_EQ(error, "'bad' failed: it ended with 3 and no message");
  EXPECT_EQ(ended, (std::vector<std::size_t>{1}));
}

TEST_F(Processes, OneThatIsKilledIsReported) {
  const std::string error = test::error_of([&] { run_processes({shell("tactile train", "kill -9 $$")}, options()); });
  EXPECT_NE(error.find("'tactile train' failed: it was killed by signal 9"), std::string::npos) << error;
}

TEST_F(Processes, OneThatCannotStartIsReported) {
  auto how = options();
  how.program = "/no/such/program";
  EXPECT_EQ(test::error_of([&] { run_processes({shell("x", "")}, how); }),
            "x: no process could be started (No such file or directory)");
}

TEST_F(Processes, EndWhenWaitingIsEnded) {
  struct Enough {};
  auto how = options();
  how.while_waiting = [&] {
    if (fs::exists(file("pid")) && fs::file_size(file("pid")) > 0) throw Enough{};
  };
  EXPECT_THROW(run_processes({shell("x", "echo $$ > " + file("pid") + "; exec sleep 600")}, how), Enough);
  EXPECT_FALSE(runs(static_cast<pid_t>(std::stol(read_text(file("pid"))))));
}

TEST_F(Processes, EndWhenTheProcessThatStartedThemIsKilled) {
  const pid_t parent = ::fork();
  if (parent == 0) {
    try {
      run_processes({shell("x", "echo $$ > " + file("pid") + "; exec sleep 600")}, options());
    } catch (...) {
    }
    ::_exit(0);
  }
  ASSERT_TRUE(test::comes_true([&] { return fs::exists(file("pid")) && fs::file_size(file("pid")) > 0; }));
  const auto child = static_cast<pid_t>(std::stol(read_text(file("pid"))));
  EXPECT_TRUE(runs(child));
  ::kill(parent, SIGKILL);
  ::waitpid(parent, nullptr, 0);
  EXPECT_TRUE(ends_soon(child));
}

}  // namespace
}  // namespace tactile::experiments
