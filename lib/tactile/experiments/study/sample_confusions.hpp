#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tactile/evaluation/accuracy.hpp"

namespace tactile::study {

/// The confusion of one model on the balanced samples of one run.
struct NamedConfusion {
  std::string run;  ///< "fan/03"
  std::string object;
  results::Confusion confusion;
};

/// {"runs": [{"run", "object", "confusion"}]}, complete or not at all. @throws Error if it cannot be written
void write_confusions(const std::filesystem::path& file, std::span<const NamedConfusion> confusions);

/// @throws Error  if it cannot be read or has another form
std::vector<NamedConfusion> read_confusions(const std::filesystem::path& file);

/// Those of these runs, in their order. @throws Error  if one of them is missing
std::vector<results::RunConfusion> confusions_of_runs(std::span<const NamedConfusion> confusions,
                                                      std::span<const std::string> runs, std::size_t training);

}  // namespace tactile::study
