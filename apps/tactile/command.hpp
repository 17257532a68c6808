#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "options.hpp"
#include "tactile/core/progress.hpp"

namespace tactile {

/// What every command takes.
struct CommonArguments {
  std::string config;
  bool json = false;
  bool quiet = false;
  unsigned threads = 0;  ///< as given by --threads; the machine's cores where it was not given
};

/// A check that failed although nothing went wrong: the command ends with 2.
struct CheckFailed {};

/// Ctrl-C: the command ends with 130, and what it wrote so far stays.
struct Interrupted {};

/// What Ctrl-C is to a command: it breaks off what is to be finished, or is the usual end.
enum class CtrlC : std::uint8_t { breaks_off, is_the_end };

/// Declares a command with --config, --json, --quiet and --threads, and what it runs once its options are read. Values from
/// --config fill in for options that were not given; a key that no option has is an error that names the nearest one. A Ctrl-C
/// that came before the command ran breaks it off then, unless it is the command's end: then the command finds `interrupted()`,
/// and SIGTERM and SIGHUP are the same.
Command add_command(CLI::App& app, const std::string& name, const std::string& description,
                    std::function<void(const CommonArguments&)> run, CtrlC ctrl_c = CtrlC::breaks_off);

void stop_if_interrupted();  ///< @throws Interrupted after Ctrl-C

/// Prints a result to stdout: the JSON with --json, else the text.
void print_result(const CommonArguments& common, const nlohmann::json& json, const std::string& text);

/// Ends the command with 1 where there are errors: one a line, and `tactile` before each. To be called once what could be done is
/// done and printed. @throws Error  the last of `errors`
void end_with(const std::vector<std::string>& errors);

/// Draws progress with an ETA on stderr where that is a terminal, once a step has lasted a second; ends the step on Ctrl-C. With
/// --quiet it only does the latter.
ProgressCallback progress_line(const CommonArguments& common);

/// A time span for people: "0:42", "1:05:09".
std::string clock_text(double seconds);

}  // namespace tactile
