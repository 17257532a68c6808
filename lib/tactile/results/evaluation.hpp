#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/results/accuracy.hpp"
#include "tactile/results/calibration.hpp"
#include "tactile/results/class_scores.hpp"
#include "tactile/results/confusion.hpp"
#include "tactile/results/delay_table.hpp"
#include "tactile/results/detection.hpp"
#include "tactile/results/label_sensitivity.hpp"
#include "tactile/results/over_time.hpp"
#include "tactile/results/whole_runs.hpp"

namespace tactile::results {

/// Delays of one detector on the runs that have samples.
struct DetectorScore {
  DelayTable press, slip;
};

/// A baseline on the same test samples as the network, fitted on the same training samples.
struct BaselineScore {
  std::string name;  ///< "majority", "event_count", "logistic_moments"
  Accuracy accuracy;
};

/// Accuracy on balanced samples whose none keeps another distance from every interval.
struct GuardScore {
  microseconds guard{0};
  Accuracy accuracy;
  Accuracy difference;  ///< to the accuracy on the dataset's own samples, paired over runs
  Confusion confusion;
};

/// Against the truth of simulated runs.
struct TruthScore {
  Accuracy accuracy;  ///< on the same samples, each with the class that its tick truly has
  Confusion confusion;
  DelayTable press, slip;  ///< from the true onset
  DelayTable gross_slip;   ///< from `gross_us`, negative where slip is predicted before it
  OverTime over_time;
};

/// A model that was evaluated, and on what.
struct EvaluatedModel {
  std::string name;
  nlohmann::json settings;
  std::string weights_sha256;
  std::vector<std::string> test_runs;  ///< "fan/03", in order
};

/// Figures of the trainings of one setting, each on runs that it was not trained on.
struct Evaluation {
  std::vector<EvaluatedModel> models;  ///< one for each training
  std::string dataset, manifest_hash;
  bool simulated = false;
  microseconds sampling_guard{0}, tick{0};
  std::string thresholds{};     ///< "1.4:-2.6:20": of a decision by two thresholds; empty: none
  std::string confirm = "1/1";  ///< "2/3": a class is reported once 2 of the last 3 ticks predict it
  BootstrapOptions bootstrap;
  std::string engine;                        ///< "fast" or "libtorch"
  std::uint64_t ticks = 0, close_ticks = 0;  ///< of all test runs; of them those where another engine's verdict may differ

  std::vector<RunConfusion> runs;         ///< of the balanced samples of each training's test runs, in order; not in JSON
  std::vector<RunDetections> detections;  ///< of the same runs: how each labelled interval was detected
  Accuracy accuracy;
  Confusion confusion;
  ClassScores classes;
  Calibration calibration;                       ///< of the network's own verdicts, unconfirmed
  Calibration whole_run_calibration;             ///< the same at every tick of a sure class
  std::vector<GuardScore> guards;                ///< the dataset's own first, then 100 ms and 0 where they are others
  std::vector<BaselineScore> baselines;          ///< empty where the dataset has no run that the model learned from
  DetectorScore network;                         ///< against the labels
  LabelUncertainty label_uncertainty;            ///< of accuracy and delays against the labels
  std::map<std::string, DetectorScore> trivial;  ///< "always_press", "always_slip", "random": unconfirmed, same labels
  OverTime over_time;
  WholeRuns whole_runs;  ///< on every run of these objects that no training learned from
  std::optional<TruthScore> truth;

  std::vector<std::string> test_runs() const;  ///< of all trainings, each once, by name

  /// Whether the network's accuracy interval lies above that of every baseline; nothing where one of them is not known.
  std::optional<bool> above_baselines() const;
};

/// As eval.json has it; docs/format/evaluation.md lists its keys.
void to_json(nlohmann::json& json, const Evaluation& evaluation);
void from_json(const JsonView& json, Evaluation& evaluation);

/// "Evaluation of th40-single-1 on simulated runs", "… and 4 more trainings on …"
std::string title_of(const Evaluation& evaluation);

}  // namespace tactile::results
