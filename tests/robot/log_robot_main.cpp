#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "tactile/robot/robot_monitor.hpp"

/// log_robot PORT FILE [LIMIT]: logs the controller on loopback into FILE until it is killed. With LIMIT no file may grow beyond
/// so many bytes, which is what a full disk is like: once the log has failed and the robot is still heard, prints why and ends
/// with 3.
int main(int argc, char** argv) {
  using namespace std::chrono_literals;
  if (argc < 3) return 2;
  // Whatever becomes of the test, this ends.
  ::alarm(120);
  try {
    tactile::robot::RobotMonitor monitor({.host = "127.0.0.1",
                                          .port = static_cast<std::uint16_t>(std::atoi(argv[1])),
                                          .frequency_hz = 0,
                                          .extra_fields = {},
                                          .required_fields = {},
                                          .patience = 5'000ms,
                                          .log = {}});
    if (argc > 3) {
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit{static_cast<rlim_t>(std::atoll(argv[3])), static_cast<rlim_t>(std::atoll(argv[3]))};
      if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) return 2;
    }
    monitor.start_log(argv[2]);
    while (monitor.state().error.empty()) std::this_thread::sleep_for(5ms);
    const double failed_at = monitor.newest("timestamp").value_or(0);
    while (monitor.newest("timestamp").value_or(0) < failed_at + 0.2) std::this_thread::sleep_for(5ms);
    std::printf("%s\n", monitor.state().error.c_str());
    try {
      monitor.stop_log();
    } catch (const std::exception&) {
      return 3;
    }
    return 4;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "log_robot: %s\n", e.what());
    return 1;
  }
}
