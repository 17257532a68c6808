#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/evaluation/run_judge.hpp"
#include "tactile/evaluation/run_truth.hpp"

namespace tactile::evaluation {

/// The predictions of a model over one whole run, with or without labels.
struct RunPrediction {
  std::string run;  ///< "fan/03"
  bool simulated = false;
  std::optional<CameraTime> first_event;  ///< the origin of times for people
  results::FullRun full;
  std::vector<Touch> verdicts;  ///< after the decision, one for each tick
  RunTruth truth;
  std::vector<results::Detection> detections;       ///< of the labelled intervals that are not in doubt
  std::vector<results::Detection> true_detections;  ///< of the true intervals of a simulated run
  results::Cell judged;                             ///< whole, as `RunJudge`; where the run has labels or a truth
  model::Decision decision;
};

struct PredictionOptions {
  model::Decision decision{};
  DelayOptions delay{};
  bool include_flagged = false;        ///< flagged intervals are used too
  bool by_truth = false;               ///< `with_truth_as_labels`
  heatmaps::ChangeEvents change = {};  ///< changes the events of the run before they are rendered; the ticks stay the same
  unsigned threads = 1;                ///< > 0
};

/// @throws Error  as `classify_full_run` and `read_run_truth`
RunPrediction predict_run(const RunFolder& run, const model::Classifier& classifier, const PredictionOptions& options = {},
                          const std::function<void(std::size_t ticks)>& advance = {});

/// How the intervals of a run were detected: {"run", "simulated", "tick_ms", "confirm", "thresholds", "intervals": [{"class",
/// "start_us", "end_us", "outcome", "delay_ms"}], "true_intervals": the same by the truth, null of a run without truth,
/// "whole_run": as `Cell` has it, null of a run without labels and truth}. Intervals whose labels are in doubt have the outcome
/// "in doubt".
nlohmann::json outcome_json(const RunPrediction& prediction);

/// One row a tick: t_us, p_none, p_press, p_slip, verdict, label, truth, events, sample. `label` and `truth` are empty where the
/// run has none; truth is "unlabelled" in motion without labels; `sample` is the class where the tick is a balanced sample.
/// Written whole or not at all.
/// @param samples  class of each balanced sample by its tick; may be empty
/// @throws Error   if it cannot be written
void write_prediction(const std::filesystem::path& file, const RunPrediction& prediction,
                      const std::map<CameraTime, Touch>& samples = {});

}  // namespace tactile::evaluation
