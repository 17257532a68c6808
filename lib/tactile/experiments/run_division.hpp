#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tactile/windows/dataset.hpp"

namespace tactile::experiments {

/// The runs that an experiment trains on, chooses its settings on, and reports on: by their index in the dataset, ascending.
struct RunDivision {
  std::vector<std::uint32_t> train;
  std::vector<std::uint32_t> choice;    ///< empty if no run would be left to report on
  std::vector<std::uint32_t> reported;  ///< neither in `train` nor in `choice`
  std::vector<std::uint32_t> all_test;  ///< all that are not in `train`
};

/// Divides the runs that have samples. Training runs are those of a single-run split.
/// @param train_run    id of each object's training run; the next one if that has no samples
/// @param choice_runs  ids of the runs to choose settings on; may be empty
/// @throws Error  as `split_of`
RunDivision divide_runs(const windows::Dataset& dataset, const std::string& train_run, std::span<const std::string> choice_runs);

/// The id of a run that `steps` runs follow: the ids of all runs with samples form a ring in their order. The first id of the
/// ring stands for one that is in none.
///
///   rotated_run(data of runs 01, 02, 03; "02", 2) = "01"
std::string rotated_run(const windows::Dataset& dataset, const std::string& run, std::size_t steps);

/// The division of one of several trainings: training k learns from the run that follows `train_run` by k, and its choice runs
/// rotate with it. Training 0 is `divide_runs(dataset, train_run, choice_runs)`.
/// @throws Error  as `divide_runs`
RunDivision rotated_division(const windows::Dataset& dataset, const std::string& train_run,
                             std::span<const std::string> choice_runs, std::size_t training);

/// A sentence for each object that is trained on and has no run in another set: "mug: not tested, none of its runs but 02 has
/// samples".
std::vector<std::string> remarks_on(const windows::Dataset& dataset, const RunDivision& runs);

}  // namespace tactile::experiments
