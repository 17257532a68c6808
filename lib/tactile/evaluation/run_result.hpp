#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/evaluation/accuracy_over_time.hpp"
#include "tactile/evaluation/baseline_scores.hpp"
#include "tactile/evaluation/calibration.hpp"
#include "tactile/evaluation/evaluation.hpp"
#include "tactile/evaluation/label_uncertainty.hpp"
#include "tactile/evaluation/run_judge.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/model/inference/decision.hpp"

namespace tactile::evaluation {

/// Detectors that ignore their input.
inline constexpr std::size_t trivial_count = 3;
inline constexpr std::array<const char*, trivial_count> trivial_names{"always_press", "always_slip", "random"};

/// The counts of one run that has samples.
struct RunResult {
  std::vector<results::Cell> cells;  ///< as `judged_along_curve`
  std::size_t ticks = 0, close_ticks = 0;
  results::Confusion confusion;
  Reliability reliability;  ///< of the balanced samples
  Reliability every_tick;   ///< of every tick that has a sure class
  DrawnLabelsScores by_drawn_labels;
  std::vector<results::Confusion> by_guard;  ///< one for each of `RunScoring::sampling_guards`
  std::optional<BaselineConfusions> baselines;
  std::vector<results::Detection> detections;  ///< of the labels in use
  std::array<std::vector<results::Detection>, trivial_count> trivial;
  OverTimeOfRun over_time;

  bool has_truth = false;  ///< of a simulated run; the next four are empty without
  results::Confusion true_confusion;
  std::vector<results::Detection> true_detections;
  std::vector<results::Detection> gross;  ///< delays from gross slip
  OverTimeOfRun true_over_time;
};

/// How every run is scored.
struct RunScoring {
  const windows::Dataset& dataset;
  const model::Classifier& classifier;
  const EvaluationOptions& options;
  std::vector<microseconds> sampling_guards;  ///< the dataset's own first
  model::Decision decision;
  const std::optional<FittedBaselines>& baselines;  ///< nothing where the dataset has no sample that the model learned from
};

/// Renders and classifies every tick of a run, and scores it.
/// @throws Error  as `evaluate`
RunResult score_run(const RunScoring& scoring, std::uint32_t run_index, unsigned threads,
                    const std::function<void(std::size_t)>& advance);

/// A run that has no samples, along the curve of thresholds. @throws Error  if it cannot be read
std::vector<results::Cell> judge_other_run(const RunScoring& scoring, const RunFolder& folder, unsigned threads);

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
