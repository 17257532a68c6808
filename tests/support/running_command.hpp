#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"

namespace tactile::test {

/// The built `tactile`, running beside the test; killed if the test leaves it behind.
class RunningTactile {
 public:
  explicit RunningTactile(std::vector<std::string> arguments, const std::filesystem::path& in = ".") {
    arguments.insert(arguments.begin(), TACTILE_BINARY);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const std::string out = (folder_ / "out").string(), err = (folder_ / "err").string(), where = in.string();
    pid_ = ::fork();
    if (pid_ < 0) throw std::runtime_error("fork");
    if (pid_ > 0) return;
    const int none = ::open("/dev/null", O_RDONLY);
    const int out_file = ::open(out.c_str(), O_WRONLY | O_CREAT, 0600), err_file = ::open(err.c_str(), O_WRONLY | O_CREAT, 0600);
    if (none >= 0 && out_file >= 0 && err_file >= 0 && ::dup2(none, 0) == 0 && ::dup2(out_file, 1) == 1 &&
        ::dup2(err_file, 2) == 2 && ::chdir(where.c_str()) == 0) {
      ::execv(argv.front(), argv.data());
    }
    ::_exit(127);
  }
  ~RunningTactile() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  RunningTactile(const RunningTactile&) = delete;
  RunningTactile& operator=(const RunningTactile&) = delete;

  std::string out() const { return text_of("out"); }
  std::string err() const { return text_of("err"); }

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

  void signal(int number) const { ::kill(pid_, number); }

  /// Waits until it has ended by itself. @throws std::runtime_error after two minutes
  CommandResult wait() {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    int status = 0;
    while (::waitpid(pid_, &status, WNOHANG) == 0) {
      if (std::chrono::steady_clock::now() > deadline) throw std::runtime_error("it does not end: " + err());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    pid_ = -1;
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), out(), err()};
  }

 private:
  std::string text_of(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(folder_ / name).rdbuf();
    return text.str();
  }

  TemporaryFolder folder_;
  pid_t pid_ = -1;
};

}  // namespace tactile::test
