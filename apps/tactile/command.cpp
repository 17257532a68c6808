#include "command.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "effective_settings.hpp"
#include "interruption.hpp"
#include "option_checks.hpp"
#include "standard_streams.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/time_left.hpp"

namespace tactile::cli {
namespace {

std::vector<std::string> texts_of(const nlohmann::json& value, const std::string& where) {
  if (value.is_string()) return {value.get<std::string>()};
  if (value.is_boolean()) return {value.get<bool>() ? "true" : "false"};
  if (value.is_number()) return {value.dump()};
  if (!value.is_array() || value.empty())
    throw Error(where + " has no plain value; expected a number, a text, true or false, or a list of these");
  std::vector<std::string> texts;
  for (const nlohmann::json& element : value) {
    if (element.is_array()) throw Error(where + " has a list within a list; expected a list of plain values");
    texts.push_back(texts_of(element, where).front());
  }
  return texts;
}

/// The command line has priority: only options that were not given take their value from the file.
void fill_in_from(const std::string& file, CLI::App& command) {
  const nlohmann::json json = read_json(file);
  if (!json.is_object()) throw Error(file + ": no JSON object; expected {\"option\": value, ...}");
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    if (const std::string name = option->get_single_name(); name != "help" && name != "config" && name != "print-config")
      names.push_back(name);
  }
  for (const auto& [key, value] : json.items()) {
    if (key == "comment") continue;
    if (std::find(names.begin(), names.end(), key) == names.end()) {
      const std::string nearest = nearest_name(key, names);
      throw Error(fmt::format("{}: '{}' is not an option of '{}'; {}", file, key, command.get_name(),
                              nearest.empty() ? fmt::format("'tactile {} --help' lists all", command.get_name())
                                              : fmt::format("the nearest is '{}'", nearest)));
    }
    const auto has_this_name = [&name = key](CLI::Option* option) { return option->get_single_name() == name; };
    CLI::Option* option = command.get_options(has_this_name).front();
    if (option->count() > 0) continue;
    option->add_result(texts_of(value, fmt::format("{}: '{}'", file, key)));
    try {
      option->run_callback();
    } catch (const CLI::ValidationError& e) {
      const std::string what = e.what(), begin = option->get_name() + ": ";
      throw CLI::ValidationError(
          fmt::format("{}: '{}': {}", file, key, what.starts_with(begin) ? what.substr(begin.size()) : what),
          CLI::ExitCodes::ValidationError);
    }
  }
}

}  // namespace

Command add_command(CLI::App& app, const std::string& name, const std::string& description,
                    std::function<void(const CommonArguments&)> run, CtrlC ctrl_c) {
  CLI::App* const declared = app.add_subcommand(name, description);
  Command command(*declared);
  auto common = std::make_shared<CommonArguments>();
  common->threads = threads_or_all(0);
  command.add_option("--config", common->config, "JSON file with option values; the command line overrides them")
      .type_name("FILE.json")
      .check(is_existing_file());
  command.add_flag("--print-config", common->print_config, "Print the effective settings as a file for --config, and exit");
  command.add_flag("--json", common->json, "Print the result as JSON");
  command.add_flag("--quiet", common->quiet, "Hide progress and all log messages below warnings");
  command.add_option("--threads", common->threads, "Number of worker threads")
      .check(in_range(1U, 1024U))
      .default_text("one per core that it may use");
  declared->callback([declared, common, run = std::move(run), ctrl_c] {
    if (!common->config.empty()) fill_in_from(common->config, *declared);
    common->settings = effective_settings(*declared);
    if (common->print_config) return print(json_text(common->settings, 2) + "\n");
    catch_signals();
    if (ctrl_c == CtrlC::is_the_end) fail_at_broken_pipes();
    release_signals();
    if (ctrl_c == CtrlC::breaks_off) stop_if_interrupted();
    if (common->quiet) spdlog::set_level(spdlog::level::warn);
    run(*common);
  });
  return command;
}

void stop_if_interrupted() {
  if (interrupted()) throw Interrupted{};
}

void print_result(const CommonArguments& common, const nlohmann::json& json, const std::string& text) {
  print(common.json ? json_text(json, 2) + "\n" : text);
}

void write_settings(const CommonArguments& common, const std::filesystem::path& file, const nlohmann::json& decided) {
  nlohmann::json settings = common.settings;
  settings.merge_patch(decided);
  write_json(file, settings);
}

void end_with(const std::vector<std::string>& errors) {
  if (errors.empty()) return;
  for (std::size_t i = 0; i + 1 < errors.size(); ++i) print_error(errors[i]);
  throw Error(errors.back());
}

ProgressCallback progress_line(const CommonArguments& common) {
  using Clock = std::chrono::steady_clock;
  struct Line {
    Clock::time_point begun = Clock::now(), drawn = begun;
    TimeLeft left;
    bool visible = false;
    ~Line() {
      if (visible) std::fputs("\r\033[K", stderr);
    }
  };
  // Without a terminal, progress is logged in whole lines, and seldom.
  const bool draws = isatty(STDERR_FILENO) != 0;
  const auto first = draws ? std::chrono::milliseconds(1000) : std::chrono::milliseconds(30'000);
  const auto period = draws ? std::chrono::milliseconds(100) : first;
  return [line = std::make_shared<Line>(), quiet = common.quiet, draws, first, period](const Progress& progress) {
    stop_if_interrupted();
    const auto now = Clock::now();
    const auto left = line->left.after(progress, now);
    if (quiet || now - line->begun < first || now - line->drawn < period) return;
    line->drawn = now;
    line->visible = draws;
    std::string text = progress.what;
    if (progress.total > 0) {
      text = fmt::format("{:3.0f} %  {}", 100 * static_cast<double>(progress.done) / static_cast<double>(progress.total), text);
      if (left) text += fmt::format("  ETA {}", clock_text(left->count()));
    }
    if (!draws) return spdlog::info("{}", text);
    winsize window{};
    const std::size_t columns = ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0 ? window.ws_col : 80;
    std::fprintf(stderr, "\r\033[K%s", text.substr(0, columns - 1).c_str());
  };
}

std::string clock_text(double seconds) {
  const auto whole = std::llround(seconds);
  return whole < 3600 ? fmt::format("{}:{:02}", whole / 60, whole % 60)
                      : fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

}  // namespace tactile::cli
