#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tactile/evaluation/accuracy.hpp"

namespace tactile {

/// What one model said of the balanced samples of one run.
struct RunVerdicts {
  std::string run;  ///< "fan/03"
  std::string object;
  Confusion confusion;
};

/// {"runs": [{"run", "object", "confusion"}]}, whole or not at all. @throws Error if it cannot be written
void write_verdicts(const std::filesystem::path& file, std::span<const RunVerdicts> verdicts);

/// @throws Error  if it cannot be read or is no such file
std::vector<RunVerdicts> read_verdicts(const std::filesystem::path& file);

/// Those of these runs, in their order. @throws Error  if one of them is not there
std::vector<RunConfusion> verdicts_on(std::span<const RunVerdicts> verdicts, std::span<const std::string> runs);

/// The verdicts of several models on the same runs counted together: a model more is as many samples more of each run.
/// @throws Error  if they are not of the same runs
std::vector<RunConfusion> together(std::span<const std::vector<RunConfusion>> models);

}  // namespace tactile
