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

/// A running `tactile` whose standard input is a pipe. The destructor kills it if it still runs.
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
  /// Whether the process already runs `tactile`, not the shell that starts it, and blocks or catches this signal.
  bool blocks_or_catches(int number) const {
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
  /// Does nothing once `has_ended` was true: `kill` of 0 would end the test itself.
  void signal(int number) const {
    if (pid_ > 0) ::kill(pid_, number);
  }
  std::string out() const { return text_in_file(out_file()); }
  std::string err() const { return text_in_file(err_file()); }

  /// The text after `words` in the first complete line of the log that contains them. Waits for that line.
  /// @throws std::runtime_error after a minute
  std::string logged_after(const std::string& words) const {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (std::chrono::steady_clock::now() < deadline) {
      std::istringstream lines(err());
      for (std::string line; std::getline(lines, line) && !lines.eof();) {
        if (const std::size_t at = line.find(words); at != std::string::npos) return line.substr(at + words.size());
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    throw std::runtime_error("no line with '" + words + "' in: " + err());
  }

  bool has_ended() {
    if (pid_ > 0 && ::waitpid(pid_, &status_, WNOHANG) == pid_) pid_ = 0;
    return pid_ == 0;
  }
  /// Waits for its end. @throws std::runtime_error after ten minutes
  CommandResult wait() {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(10);
    while (!has_ended()) {
      if (std::chrono::steady_clock::now() > deadline) throw std::runtime_error("the command does not end: " + err());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return {WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_), text_in_file(out_file()),
            text_in_file(err_file())};
  }

 private:
  std::string out_file() const { return (folder_ / "out").string(); }
  std::string err_file() const { return (folder_ / "err").string(); }

  TemporaryFolder folder_;
  pid_t pid_ = 0;
  int input_ = -1;
  int status_ = 0;
};

}  // namespace tactile::test
