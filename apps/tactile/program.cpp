#include "program.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <span>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "command.hpp"
#include "help_text.hpp"
#include "interruption.hpp"
#include "standard_streams.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/version.hpp"
#include "usage_error.hpp"

namespace tactile::cli {

namespace {

/// The standard library's message does not explain the problem.
int fail_for_lack_of_memory() noexcept {
  std::fputs("tactile: there is not enough memory; expected more memory, or fewer threads (--threads 1)\n", stderr);
  return 1;
}

/// For an exception that cannot be caught, as in a destructor.
[[noreturn]] void end_uncaught() {
  try {
    if (const std::exception_ptr uncaught = std::current_exception()) std::rethrow_exception(uncaught);
  } catch (const std::bad_alloc&) {
    std::_Exit(fail_for_lack_of_memory());
  } catch (const std::exception& e) {
    print_error(sentence_of(e));
  } catch (...) {
    // It has no message.
  }
  std::abort();
}

int run(int argc, char** argv, std::span<void (*const)(CLI::App&)> commands, std::string (*libraries)()) {
  hold_signals();
  spdlog::set_default_logger(spdlog::stderr_color_mt("tactile"));
  spdlog::set_pattern("%^%l%$: %v");

  CLI::App app("Detects press and slip with an event-camera tactile sensor, in recordings and live.", "tactile");
  app.set_help_flag("-h,--help", "Show this help");
  app.set_version_flag(
      "--version",
      [libraries] {
        const std::string program = fmt::format("tactile {} ({})", version(), revision());
        return libraries == nullptr ? program : program + '\n' + libraries();
      },
      "Show version, revision, libraries and CPU features");
  app.require_subcommand(1);
  app.formatter(std::make_shared<HelpText>());
  for (const auto add_command : commands) add_command(app);

  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) {  // --help and --version
      std::ostringstream text;
      app.exit(e, text, text);
      print(text.str());
      return 0;
    }
    std::vector<std::string> names;
    for (const CLI::App* command : listed_commands(std::as_const(app))) names.push_back(command->get_name());
    if (argc > 1 && argv[1][0] != '-' && std::find(names.begin(), names.end(), argv[1]) == names.end()) {
      const std::string nearest = nearest_name(argv[1], names);
      print_error(fmt::format("'{}' is not a command; {}'tactile --help' lists all", argv[1],
                              nearest.empty() ? "" : fmt::format("the nearest is '{}', and ", nearest)));
      return e.get_exit_code();
    }
    const UsageError error = usage_error(app, e);
    print_error(error.sentence);
    return error.exit_code;
  }
}

}  // namespace

int run_program(int argc, char** argv, std::span<void (*const)(CLI::App&)> commands, std::string (*libraries)()) {
  open_missing_streams();
  fail_at_file_size_limit();
  std::set_terminate(end_uncaught);
  int exit_code = 0;
  try {
    exit_code = run(argc, argv, commands, libraries);
  } catch (const CheckFailed&) {
    exit_code = 2;
  } catch (const Interrupted&) {
    print_error("interrupted");
    return exit_code_of_interruption();
  } catch (const std::bad_alloc&) {
    return fail_for_lack_of_memory();
  } catch (const std::exception& e) {
    print_error(sentence_of(e));
    return 1;
  }
  if (exit_code != 0 && exit_code != 2) return exit_code;  // the reason has been printed
  const std::string lost = what_output_lost();
  if (lost.empty()) return exit_code;
  print_error(lost);
  return 1;
}

namespace {

/// Whether `program` can be loaded within the limit on memory. A child process tries it first, because the loader ends a process
/// with its own message if the program cannot be loaded. Not `ChildProcess`: it has no time limit. Without enough memory
/// a library may wait for its threads for ever, or try again for ever (OpenBLAS 0.3.29). Both limits stay after the exec.
bool can_be_loaded(const std::string& program) {
  rlimit limit{};
  const auto is_limited = [&limit](auto which) { return ::getrlimit(which, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY; };
  if (!is_limited(RLIMIT_AS) && !is_limited(RLIMIT_DATA)) return true;
  constexpr unsigned longest_s = 60, longest_work_s = 10;  // it takes 0.1 s
  const pid_t child = ::fork();
  if (child == 0) {
    const int nothing = ::open("/dev/null", O_RDWR);
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nothing, descriptor);
    ::alarm(longest_s);
    const rlimit most_work{.rlim_cur = longest_work_s, .rlim_max = longest_work_s};
    ::setrlimit(RLIMIT_CPU, &most_work);
    ::execl(program.c_str(), "tactile", "--version", nullptr);
    ::_exit(1);
  }
  int status = 0;
  while (child > 0 && ::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return child > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// The folder with the other programs: that of this program, or the one where an installation puts them.
std::filesystem::path folder_of(const char* program) {
  std::error_code failed;
  std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", failed).parent_path();
  if (std::filesystem::exists(here / program, failed)) return here;
  std::filesystem::path installed = (here / "../libexec/tactile").lexically_normal();  // as in cmake/install.cmake
  return std::filesystem::exists(installed / program, failed) ? installed : here;
}

}  // namespace

int hand_over_to_all(char** argv) {
  constexpr const char* program = "tactile-all";
  open_missing_streams();
  hold_signals();
  std::error_code failed;
  const std::string file = (folder_of(program) / program).string();
  // OpenCV loads OpenBLAS, which starts a thread with 128 MB for each core. Without this memory the threads spin, and the process
  // waits for them in the end. One thread is enough: libtorch has its own threads.
  ::setenv("OPENBLAS_NUM_THREADS", "1", 1);
  // libtorch's threads sleep while they wait for each other. By default they spin: if another program uses the same cores, a
  // training then takes five to ten times as long. libgomp reads this only when it is loaded.
  ::setenv("OMP_WAIT_POLICY", "passive", 0);
  if (std::filesystem::exists(file, failed) && !can_be_loaded(file)) {
    print_error(
        fmt::format("{}: cannot be loaded within the limit on memory (ulimit -v); expected a higher limit, or none", file));
    return 1;
  }
  ::execv(file.c_str(), argv);
  print_error(
      fmt::format("{}: cannot be run ({}); expected this part of tactile in the folder of the program, or in ../libexec/tactile",
                  file, std::strerror(errno)));
  return 1;
}

}  // namespace tactile::cli
