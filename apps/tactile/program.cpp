#include "program.hpp"

#include <fmt/core.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "command.hpp"
#include "help_text.hpp"
#include "interruption.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/version.hpp"
#include "usage_error.hpp"

namespace tactile {

int run_program(int argc, char** argv, const std::vector<void (*)(CLI::App&)>& commands) {
  hold_signals();
  spdlog::set_default_logger(spdlog::stderr_color_mt("tactile"));
  spdlog::set_pattern("%^%l%$: %v");

  CLI::App app("Event-camera tactile sensing: from recordings of a sensor skin to verdicts a robot can act on.", "tactile");
  app.set_help_flag("-h,--help", "Tell this");
  app.set_version_flag("--version", fmt::format("tactile {} ({})", version(), revision()), "Tell version and revision");
  app.require_subcommand(1);
  app.formatter(std::make_shared<HelpText>());
  for (const auto add_command : commands) add_command(app);

  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // --help and --version
    std::vector<std::string> names;
    for (const CLI::App* command : std::as_const(app).get_subcommands({})) names.push_back(command->get_name());
    if (argc > 1 && argv[1][0] != '-' && std::find(names.begin(), names.end(), argv[1]) == names.end()) {
      const std::string nearest = nearest_name(argv[1], names);
      fmt::print(stderr, "tactile: '{}' is no command; {}'tactile --help' lists all\n", argv[1],
                 nearest.empty() ? "" : fmt::format("the nearest is '{}', and ", nearest));
      return e.get_exit_code();
    }
    const UsageError error = usage_error(app, e);
    fmt::print(stderr, "tactile: {}\n", error.sentence);
    return error.exit_code;
  } catch (const CheckFailed&) {
    return 2;
  } catch (const Interrupted&) {
    fmt::print(stderr, "tactile: interrupted\n");
    return 130;
  } catch (const std::bad_alloc&) {
    const auto asked_for = app.get_subcommands();
    fmt::print(stderr,
               "tactile: memory does not suffice for '{}'; expected more of it: end other programs, or give fewer --threads\n",
               asked_for.empty() ? "tactile" : asked_for.front()->get_name());
    return 1;
  } catch (const std::exception& e) {
    fmt::print(stderr, "tactile: {}\n", sentence_of(e));
    return 1;
  }
}

int hand_over_to(const char* program, char** argv) {
  hold_signals();
  std::error_code failed;
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", failed).parent_path();
  const std::string file = (here / program).string();
  ::execv(file.c_str(), argv);
  fmt::print(stderr, "tactile: {}: cannot be run ({}); expected this part of tactile beside the program itself\n", file,
             std::strerror(errno));
  return 1;
}

}  // namespace tactile
