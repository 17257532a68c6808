#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>

#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"

namespace tactile::test {

/// The built `tactile` at work, with a pipe as its standard input; killed if it still runs when this goes.
class RunningCommand {
 public:
  explicit RunningCommand(const std::string& arguments, const std::filesystem::path& in = ".") {
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0) std::abort();
    input_ = pipe[1];
    const std::string command = "cd '" + in.string() + "' && exec '" + test::tactile_binary + "' " + arguments + " >'" +
                                out_file() + "' 2>'" + err_file() + "'";
    std::array<std::string, 3> words{"sh", "-c", command};
    const std::array<char*, 4> argv{words[0].data(), words[1].data(), words[2].data(), nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, pipe[0], STDIN_FILENO);
    if (::posix_spawn(&pid_, "/bin/sh", &actions, nullptr, argv.data(), environ) != 0) std::abort();
    posix_spawn_file_actions_destroy(&actions);
    ::close(pipe[0]);
  }
  ~RunningCommand() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
    close_input();
  }
  RunningCommand(const RunningCommand&) = delete;
  RunningCommand& operator=(const RunningCommand&) = delete;

  void type(const std::string& text) const {
    if (::write(input_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) std::abort();
  }
  void close_input() {
    if (input_ >= 0) ::close(input_);
    input_ = -1;
  }
  /// Whether `tactile` itself is there already and holds this signal back, or catches it.
  bool minds(int number) const {
    std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
    bool is_tactile = false;
    for (std::string line; std::getline(status, line);) {
      if (line.starts_with("Name:")) is_tactile = line.find("tactile") != std::string::npos;
      if (!line.starts_with("SigBlk:") && !line.starts_with("SigCgt:")) continue;
      const std::uint64_t signals = std::stoull(line.substr(line.find_first_not_of(" \t", 7)), nullptr, 16);
      if (is_tactile && (signals >> (number - 1) & 1U) != 0) return true;
    }
    return false;
  }
  void signal(int number) const { ::kill(pid_, number); }
  std::string err() const { return text_of(err_file()); }

  /// What stands behind `begin` on the first whole line of the log that has it. @throws std::runtime_error if none comes
  std::string logged_behind(const std::string& begin) const {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (std::chrono::steady_clock::now() < deadline) {
      std::istringstream lines(err());
      for (std::string line; std::getline(lines, line) && !lines.eof();) {
        if (const std::size_t at = line.find(begin); at != std::string::npos) return line.substr(at + begin.size());
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    throw std::runtime_error("no line with '" + begin + "' in: " + err());
  }

  bool has_ended() {
    if (pid_ > 0 && ::waitpid(pid_, &status_, WNOHANG) == pid_) pid_ = 0;
    return pid_ == 0;
  }
  /// Waits until it has ended by itself. @throws std::runtime_error after ten minutes
  CommandResult wait() {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(10);
    while (!has_ended()) {
      if (std::chrono::steady_clock::now() > deadline) throw std::runtime_error("it does not end: " + err());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return {WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_), text_of(out_file()), text_of(err_file())};
  }

 private:
  static std::string text_of(const std::string& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }
  std::string out_file() const { return (folder_ / "out").string(); }
  std::string err_file() const { return (folder_ / "err").string(); }

  TemporaryFolder folder_;
  pid_t pid_ = 0;
  int input_ = -1;
  int status_ = 0;
};

}  // namespace tactile::test
