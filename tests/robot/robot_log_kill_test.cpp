#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>

#include "robot/fake_controller.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile {
namespace {

TEST(RobotLogKilled, LeavesWholeRowsAtTwentyMoments) {
  test::FakeController controller({.split_writes = true});
  Random random(20);
  std::size_t with_rows = 0;
  for (int moment = 0; moment < 20; ++moment) {
    const test::TemporaryFolder folder;
    const std::filesystem::path file = folder / "robot.csv";
    std::string binary = LOG_ROBOT_BINARY, port = std::to_string(controller.port()), name = file.string();
    const std::array<char*, 4> arguments{binary.data(), port.data(), name.data(), nullptr};
    pid_t child = 0;
    ASSERT_EQ(::posix_spawn(&child, binary.c_str(), nullptr, nullptr, arguments.data(), environ), 0);
    while (!std::filesystem::exists(file) && ::waitpid(child, nullptr, WNOHANG) == 0) std::this_thread::sleep_for(1ms);
    std::this_thread::sleep_for(std::chrono::microseconds(random.below(400'000)));
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << "it ended by itself";

    const RobotLogFile log_file = read_robot_log(file);
    EXPECT_LE(log_file.pieces.size(), 1U);
    const RobotLog& log = log_file.longest();
    EXPECT_TRUE(log.gaps.empty());
    const std::vector<double> sent = controller.sent();
    auto at = sent.begin();
    for (const RobotState& state : log.states) {
      at = std::find_if(at, sent.end(), [&](double t) { return std::llround(t * 1e6) == us_of(state.t); });
      ASSERT_NE(at, sent.end()) << "a row that was never sent";
    }
    with_rows += log.states.empty() ? 0 : 1;
  }
  EXPECT_GT(with_rows, 5U) << "too few kills came while rows were written";
}

}  // namespace
}  // namespace tactile
