#include <fmt/core.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/version.hpp"

int main(int argc, char** argv) {
  using namespace tactile;
  spdlog::set_default_logger(spdlog::stderr_color_mt("tactile"));
  spdlog::set_pattern("%^%l%$: %v");

  CLI::App app("Event-camera tactile sensing: from recordings of a sensor skin to verdicts a robot can act on.", "tactile");
  app.set_version_flag("--version", fmt::format("tactile {} ({})", version(), revision()));
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);

  add_simulate_command(app);
  add_info_command(app);
  add_repair_command(app);
  add_convert_command(app);
  add_label_command(app);
  add_windows_command(app);
  add_heatmaps_command(app);
  add_view_command(app);
  add_train_command(app);
  add_eval_command(app);
  add_doctor_command(app);

  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // --help and --version
    std::vector<std::string> names;
    for (const CLI::App* command : std::as_const(app).get_subcommands({})) names.push_back(command->get_name());
    if (argc > 1 && argv[1][0] != '-' && std::find(names.begin(), names.end(), argv[1]) == names.end()) {
      fmt::print(stderr, "tactile: '{}' is no command; the nearest is '{}'. 'tactile --help' lists them.\n", argv[1],
                 nearest_name(argv[1], names));
      return e.get_exit_code();
    }
    fmt::print(stderr, "tactile: {}\nTry 'tactile --help', or --help behind a command.\n", e.what());
    return e.get_exit_code();
  } catch (const CheckFailed&) {
    return 2;
  } catch (const Interrupted&) {
    fmt::print(stderr, "tactile: interrupted\n");
    return 130;
  } catch (const std::exception& e) {
    fmt::print(stderr, "tactile: {}\n", e.what());
    return 1;
  }
}
