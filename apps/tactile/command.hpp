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

namespace tactile::cli {

/// The options of every command.
struct CommonArguments {  // NOLINT(bugprone-exception-escape): moving nlohmann::json does not throw
  std::string config;
  bool json = false;
  bool quiet = false;
  bool print_config = false;
  unsigned threads = 0;     ///< of --threads; default: the machine's cores
  nlohmann::json settings;  ///< the `effective_settings` of the command
};

/// A check failed, without an error: the command ends with 2.
struct CheckFailed {};

/// Ctrl-C, SIGTERM or SIGHUP: the command ends with 130, 143 or 129, and keeps what it wrote so far.
struct Interrupted {};

/// The meaning of these signals for a command: it interrupts the work, or is its usual end.
enum class CtrlC : std::uint8_t { breaks_off, is_the_end };

/// Declares a command with --config, --print-config, --json, --quiet and --threads, and the function that runs once its options
/// are read. Options that were not given take their value from --config; an unknown key there is an error that names the nearest
/// option. With --print-config, the effective settings are printed instead, and nothing runs. A Ctrl-C
/// before the command runs interrupts it. If Ctrl-C is the command's end, `interrupted()` returns true instead.
Command add_command(CLI::App& app, const std::string& name, const std::string& description,
                    std::function<void(const CommonArguments&)> run, CtrlC ctrl_c = CtrlC::breaks_off);

void stop_if_interrupted();  ///< @throws Interrupted after Ctrl-C, SIGTERM and SIGHUP

/// Prints a result to stdout: the JSON with --json, else the text.
void print_result(const CommonArguments& common, const nlohmann::json& json, const std::string& text);

/// Writes the command's effective settings to a file for --config.
/// @param decided  values that the command chose itself, such as the model without --model; null leaves an option out
/// @throws Error  if it cannot be written
void write_settings(const CommonArguments& common, const std::filesystem::path& file,
                    const nlohmann::json& decided = nlohmann::json::object());

/// Ends the command with 1 if there are errors, and prints each on a line after `tactile`. Call it after the result is printed.
/// @throws Error  the last of `errors`
void end_with(const std::vector<std::string>& errors);

/// Draws progress and the remaining time on stderr, if that is a terminal, after a step's first second. Ends the step on Ctrl-C,
/// also with --quiet.
ProgressCallback progress_line(const CommonArguments& common);

/// A duration: "0:42", "1:05:09".
std::string clock_text(double seconds);

}  // namespace tactile::cli
