#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "robot/fake_controller.hpp"

/// A UR controller on loopback for so many seconds, for scripts: prints "port N" once it listens.
int main(int argc, char** argv) {
  using tactile::test::FakeController;
  tactile::test::FakeControllerOptions options;
  double seconds = 10;
  std::string version = "5.11.6.1071234", session_file;
  std::size_t session_packages = 50;
  double restart_at = -1, garbage_at = -1;
  std::vector<double> stall, away;  // start and length [s]

  CLI::App app{"A UR controller on loopback that speaks RTDE version 2"};
  app.add_option("--port", options.port, "To listen on; 0: any that is free")->capture_default_str();
  app.add_option("--seconds", seconds, "How long it runs")->capture_default_str();
  app.add_option("--controller", version, "Version, four numbers")->capture_default_str();
  app.add_option("--highest-hz", options.highest_hz, "Rate of the controller")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--skew-ppm", options.skew_ppm, "Its clock runs so much faster")->capture_default_str();
  app.add_flag("--jitter", options.jitter, "Packages leave late by 0.2 ms and an exponential of 1 ms");
  app.add_flag("--split-writes", options.split_writes, "The stream leaves in random pieces");
  app.add_option("--drop", options.drop_share, "Share of packages that are never sent")->check(CLI::Range(0.0, 1.0));
  app.add_option("--text-every", options.text_every, "A text message ahead of each so manieth package");
  app.add_option("--not-found", options.not_found, "Outputs that it does not have")->delimiter(',');
  app.add_option("--restart-at", restart_at, "Its clock starts again after so long [s]");
  app.add_option("--garbage-at", garbage_at, "It sends garbage after so long [s]");
  app.add_option("--stall", stall, "It stays silent: start, length [s]")->expected(2);
  app.add_option("--away", away, "It closes all connections and refuses new ones: start, length [s]")->expected(2);
  app.add_option("--seed", options.seed, "Of all that is random")->capture_default_str();
  app.add_option("--session", session_file, "Write what a controller sends in a session into this file, and end");
  app.add_option("--packages", session_packages, "Data packages of --session")->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  if (!session_file.empty()) {
    const auto bytes = tactile::test::fake_session(session_packages);
    std::ofstream out(session_file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    out.close();
    return out ? 0 : 1;
  }
  if (std::sscanf(version.c_str(), "%u.%u.%u.%u", &options.version.major, &options.version.minor, &options.version.bugfix,
                  &options.version.build) != 4) {
    std::fprintf(stderr, "fake_controller: '%s' is no version; expected four numbers such as 3.15.8.106339\n", version.c_str());
    return 1;
  }

  try {
    FakeController controller(options);
    std::printf("port %u\n", controller.port());
    std::fflush(stdout);
    std::vector<std::pair<double, std::function<void()>>> plan{{seconds, [] {}}};
    if (restart_at >= 0) plan.emplace_back(restart_at, [&] { controller.restart_clock(); });
    if (garbage_at >= 0) plan.emplace_back(garbage_at, [&] { controller.send_garbage(); });
    if (stall.size() == 2) {
      plan.emplace_back(stall[0], [&] { controller.stall(true); });
      plan.emplace_back(stall[0] + stall[1], [&] { controller.stall(false); });
    }
    if (away.size() == 2) {
      plan.emplace_back(away[0], [&] {
        controller.listen(false);
        controller.close_connections();
      });
      plan.emplace_back(away[0] + away[1], [&] { controller.listen(true); });
    }
    std::stable_sort(plan.begin(), plan.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    const auto begin = std::chrono::steady_clock::now();
    for (const auto& [at, step] : plan) {
      if (at > seconds) break;
      std::this_thread::sleep_until(
          begin + std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(at)));
      step();
    }
  } catch (const std::exception& e) {
    std::fprintf(stderr, "fake_controller: %s\n", e.what());
    return 1;
  }
  return 0;
}
