#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tactile/windows/dataset.hpp"

namespace tactile {

/// Which runs a study learns from, chooses its settings on, and reports on; by their index in the dataset.
struct StudyRuns {
  std::vector<std::uint32_t> train;
  std::vector<std::uint32_t> choice;    ///< empty where no run would be left to report on
  std::vector<std::uint32_t> reported;  ///< those that are neither trained nor chosen on
  std::vector<std::uint32_t> all_test;  ///< all but those trained on
};

/// Runs without samples are in none of them. Trained on are those of a single-run split.
/// @param train_run    id of the run that each object is trained on; the next one where it has no samples
/// @param choice_runs  ids of the runs to choose on, may be empty
/// @throws Error  as `split_of`
StudyRuns study_runs(const Dataset& dataset, const std::string& train_run, std::span<const std::string> choice_runs);

/// Of each object that is trained on, which of the other sets it has no run in: "mug: not tested, none of its runs but 02 has
/// samples".
std::vector<std::string> remarks_on(const Dataset& dataset, const StudyRuns& runs);

/// "fan/03" of each. In the order given.
std::vector<std::string> names_of(const Dataset& dataset, std::span<const std::uint32_t> runs);

}  // namespace tactile
