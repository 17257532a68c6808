// What is left of an output that a command cannot finish: nothing, whatever ends it.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <system_error>

#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

/// A run with labels and a dataset, made once.
class UnfinishedOutput : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    made = std::make_unique<test::TemporaryFolder>();
    for (const char* command :
         {"simulate --preset tiny --objects fan --runs 2", "label --no-pictures", "windows", "heatmaps --th 40"})
      ASSERT_EQ(test::run_tactile(command, made->path()).exit_code, 0) << command;
  }
  static void TearDownTestSuite() { made.reset(); }

  UnfinishedOutput() { fs::copy(*made / "data", folder / "data", fs::copy_options::recursive); }

  std::set<std::string> paths() const {
    std::set<std::string> paths;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder.path()))
      paths.insert(entry.path().lexically_relative(folder.path()).string());
    return paths;
  }
  /// Also while a command writes, and files go.
  bool has_hidden_folder() const {
    std::error_code failed;
    for (fs::recursive_directory_iterator entry(folder.path(), failed), end; !failed && entry != end; entry.increment(failed)) {
      if (entry->path().filename().string().find(".part-") != std::string::npos) return true;
    }
    return false;
  }

  static inline std::unique_ptr<test::TemporaryFolder> made;
  test::TemporaryFolder folder;
};

TEST_F(UnfinishedOutput, IsNotLeftWhereAFileMayNotBecomeAsLarge) {
  const std::set<std::string> before = paths();
  for (const char* arguments :
       {"windows --out other.h5", "heatmaps --th 20", "heatmaps --th 40 --png pictures", "convert data/fan/01 a.csv",
        "convert data/fan/01 run.h5", "simulate other --preset tiny --objects usb-hub", "view data/fan/01 --out film.mp4",
        "view data/fan/01 --out still.png", "split data/fan/01 --at 1.2 --object mug --out pieces",
        "import data/fan/01/events.aedat4 --object mug --out imported", "repair data/fan/01/events.aedat4 repaired.aedat4",
        "train --epochs 1 --name small --th 40"}) {
    const auto result =
        test::run_shell(fmt::format("ulimit -f 8; exec '{}' {} --quiet", test::tactile_binary, arguments), folder.path());
    EXPECT_EQ(result.exit_code, 1) << arguments << "\n" << result.err;
    EXPECT_NE(result.err.find("File too large"), std::string::npos) << arguments << "\n" << result.err;
    fs::remove_all(folder / "models/small.training");  // a training keeps what it can continue from
    fs::remove(folder / "models");                     // unless it has anything else
    EXPECT_EQ(paths(), before) << arguments;
  }
}

TEST_F(UnfinishedOutput, IsNotLeftAfterASignal) {
  for (const int signal : {SIGTERM, SIGHUP, SIGINT}) {
    for (const char* arguments : {"heatmaps --th 2,4,6,8,10,12,14,16 --threads 1", "convert data/fan/01 a.csv",
                                  "split data/fan/01 --at 1.2 --object mug --out pieces",
                                  "simulate other --preset tiny --objects usb-hub,fan --threads 1"}) {
      int ended = 0;
      for (int i = 0; i < 20 && ended == 0; ++i) {  // it may be done before the signal comes
        for (const char* output : {"a.csv", "pieces", "other"}) fs::remove_all(folder / output);
        test::RunningCommand command(std::string(arguments) + " --quiet", folder.path());
        while (!has_hidden_folder() && !command.has_ended()) {
        }
        command.signal(signal);
        const auto result = command.wait();
        if (result.exit_code != 0) {
          ++ended;
          EXPECT_EQ(result.exit_code, 128 + signal) << arguments;
          EXPECT_EQ(result.err, "tactile: interrupted\n") << arguments;
        }
        EXPECT_FALSE(has_hidden_folder()) << arguments << " after signal " << signal;
      }
      EXPECT_EQ(ended, 1) << arguments << " after signal " << signal;
    }
  }
}

}  // namespace
}  // namespace tactile::cli
