#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#include "robot/fake_controller.hpp"
#include "support/comes_true.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/robot/robot_log.hpp"

namespace tactile::robot {
namespace {

std::ptrdiff_t lines_in(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return std::count(std::istreambuf_iterator<char>(in), {}, '\n');
}

// The moments are counted in rows written, and then in microseconds: a slow machine is killed later, not elsewhere.
TEST(RobotLogKilled, LeavesWholeRowsAtTwentyMoments) {
  test::FakeController controller({.split_writes = true});
  Random random(20);
  for (int moment = 0; moment < 20; ++moment) {
    const test::TemporaryFolder folder;
    const std::filesystem::path file = folder / "robot.csv";
    std::string binary = LOG_ROBOT_BINARY, port = std::to_string(controller.port()), name = file.string();
    const std::array<char*, 4> arguments{binary.data(), port.data(), name.data(), nullptr};
    pid_t child = 0;
    ASSERT_EQ(::posix_spawn(&child, binary.c_str(), nullptr, nullptr, arguments.data(), environ), 0);
    const auto rows = static_cast<std::ptrdiff_t>(random.below(200));
    const bool has_rows = test::comes_true([&] { return lines_in(file) > rows; });
    std::this_thread::sleep_for(std::chrono::microseconds(random.below(5'000)));
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << "it ended by itself";
    ASSERT_TRUE(has_rows) << rows;

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
    EXPECT_GE(log.states.size(), static_cast<std::size_t>(rows));
  }
}

}  // namespace
}  // namespace tactile::robot
