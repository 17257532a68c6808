#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

namespace tactile::cli {

/// What a shell offers for a value.
enum class Completion : std::uint8_t {
  nothing,
  words,        ///< one of a few words
  list,         ///< some of a few words, separated by commas
  files,        ///< files, and folders on the way to them
  folders,      ///< folders
  recordings,   ///< files, and run folders below data/
  run_folders,  ///< folders, and run folders below data/
  runs,         ///< names of runs, "fan/01"
  models,       ///< names of models, and folders
  sources       ///< event sources: "sim", "file:" with recordings, ...
};

struct CompletedValue {
  Completion what = Completion::nothing;
  std::vector<std::string> words{};  ///< of `words` and `list`
  std::string extension{};           ///< of `files`: "csv"; empty: all
};

/// The function that lists these values in bash and zsh: "_tactile_runs"; empty if another way completes them.
std::string function_of(Completion what);

/// The words that the checks of an option declare; none if any value is right.
std::vector<std::string> words_of(CLI::Option& option);

/// What completes an option's value. It follows from the words of its checks and from the name that stands for the value in the
/// help: FILE.csv, DIR, DATA, RUN, MODEL, SOURCE.
CompletedValue completed_value(CLI::Option& option);

}  // namespace tactile::cli
