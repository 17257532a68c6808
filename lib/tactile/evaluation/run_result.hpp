#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/evaluation/baselines.hpp"
#include "tactile/evaluation/calibration.hpp"
#include "tactile/evaluation/evaluation.hpp"
#include "tactile/evaluation/run_judge.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/model/inference/decision.hpp"

namespace tactile::evaluation {

/// Detectors that ignore their input.
inline constexpr std::size_t trivial_count = 3;
inline constexpr std::array<const char*, trivial_count> trivial_names{"always_press", "always_slip", "random"};

/// What one run that has samples gives.
struct RunResult {
  std::vector<results::Cell> cells;       ///< as `judged_along_curve`, by the truth if there is one; then those of baselines
  results::Cell by_labels;                ///< the verdicts as they were decided, by the labels in use
  std::optional<results::Cell> by_truth;  ///< the same by the truth; each sample with the class that its tick truly has
  std::array<results::Cell, trivial_count> trivial;  ///< by the labels
  Reliability reliability;                           ///< of the balanced samples
  Reliability every_tick;                            ///< of every tick that has a sure class
  std::size_t ticks = 0, close_ticks = 0;
};

/// How every run is scored.
struct RunScoring {
  const windows::Dataset& dataset;
  const model::Classifier& classifier;
  const EvaluationOptions& options;
  const Baselines* baselines = nullptr;  ///< that are judged too; null: none
};

struct FittedBaselines {
  std::optional<Baselines> baselines{};  ///< nothing: the model learned from no run of the dataset with a touch, or `why_not`
  std::string why_not{};                 ///< a sentence without its full stop: a run has changed, or cannot be read
};

/// Baselines that learn from the runs that the model learned from.
FittedBaselines fit_baselines(const windows::Dataset& dataset, const model::Classifier& classifier, unsigned threads);

/// Renders and classifies every tick of a run, and scores it. The cells have no training; only those of baselines have a setting,
/// their name. @throws Error  as `evaluate`
RunResult score_run(const RunScoring& scoring, std::uint32_t run_index, unsigned threads,
                    const std::function<void(std::size_t)>& advance);

/// The same cells of any run. @param index  in the dataset; nothing: it has no samples. @throws Error  if it cannot be read
std::vector<results::Cell> judge_whole_run(const RunScoring& scoring, const RunFolder& folder, std::optional<std::uint32_t> index,
                                           unsigned threads, const std::function<void(std::size_t)>& advance = {});

/// @throws Error  if the model is of another dataset and may not, or of heatmaps of another size
void check_fits(const windows::Dataset& dataset, const model::Classifier& classifier, const EvaluationOptions& options);

/// How predictions become verdicts.
model::Decision decision_of(const EvaluationOptions& options);

RunFolder folder_of(const windows::Dataset& dataset, std::uint32_t run);
std::vector<RunFolder> folders_of(const windows::Dataset& dataset, std::span<const std::uint32_t> runs);

/// The dataset's samples of a run, ascending in time.
std::vector<windows::Sample> samples_in(const windows::Dataset& dataset, std::uint32_t run);

/// The samples that a dataset would have of a run with these labels.
/// @param ticks    the run's full ticks
/// @param history  of the heatmaps
std::vector<windows::Sample> samples_by(const windows::SamplingOptions& options, std::uint32_t run, const RunFolder& folder,
                                        std::span<const windows::SampledInterval> labels, const RunTruth& truth,
                                        const TickRange& ticks, microseconds history);

/// The index of a sample's tick in a full run. @throws Error  if it is at none
std::size_t place_of(const windows::Sample& sample, const TickRange& ticks, const std::string& run);

/// The number of ticks of all runs together, by the lists of their packets.
/// @throws Error  if a run folder has changed since the dataset was made
std::uint64_t ticks_of_unchanged(const windows::Dataset& dataset, const model::Classifier& classifier,
                                 std::span<const std::uint32_t> runs, unsigned threads);

/// Calls `work` for each run, and reports how many ticks are done.
/// @param total       ticks of all runs, as `ticks_of_unchanged`
/// @param others      calls of `other_work`, with 0, 1, …, which share the threads and begin before the first run
void for_full_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> runs, std::uint64_t total, unsigned threads,
                   const ProgressCallback& progress,
                   const std::function<void(std::size_t, const std::function<void(std::size_t)>&)>& work, std::size_t others = 0,
                   const std::function<void(std::size_t)>& other_work = {});

}  // namespace tactile::evaluation
