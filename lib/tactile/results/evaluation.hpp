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
#include "tactile/results/false_alarm_table.hpp"
#include "tactile/results/label_sensitivity.hpp"
#include "tactile/results/operating_point.hpp"
#include "tactile/results/over_time.hpp"

namespace tactile::results {

/// Delays and false alarms of one detector over full runs.
struct DetectorScore {
  DelayTable press, slip;
  FalseAlarmTable false_alarms;
};

/// A baseline on the same test samples as the network, fitted on the same training samples.
struct BaselineScore {
  std::string name;  ///< "majority", "event_count", "logistic_moments", "logistic_position", "boosted_trees",
                     ///< "temporal_convolution"
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
  FalseAlarmTable false_alarms;
  OverTime over_time;
};

/// The figures without the gate, and how often the gate is closed.
struct GateOff {
  std::uint64_t limit = 0;        ///< events in t_h; 0 if the gate compares with the background
  std::optional<double> ratio{};  ///< then its least likelihood ratio, as a logarithm
  std::uint64_t ticks = 0, gated = 0;
  Accuracy accuracy;
  Confusion confusion;
  DetectorScore network;
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
  microseconds guard{0}, sampling_guard{0}, tick{0};
  std::optional<double> alarm_cost{};  ///< of the decision filter; without one, verdicts are confirmed
  std::string thresholds{};            ///< "1.4:-2.6:20": of a decision by two thresholds; empty: none
  std::string confirm = "1/1";         ///< "2/3": a class is reported once 2 of the last 3 ticks predict it
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
  std::optional<WithFlagged> with_flagged;       ///< where a run or an interval is flagged
  std::size_t of_runs = 0;                       ///< runs of these objects that no training learned from; 0: not known
  std::optional<GateOff> gate_off;               ///< where the gate is on
  std::map<std::string, DetectorScore> trivial;  ///< "always_press", "always_slip", "random": unconfirmed, same labels
  OverTime over_time;
  std::vector<OperatingPoint> operating_curve;  ///< confirmed as the verdicts are
  std::optional<TruthScore> truth;

  std::vector<std::string> test_runs() const;  ///< of all trainings, each once, by name

  /// "on 80 of 100 runs: the others have no press or no slip without a flag"
  std::string counted_on() const;
  /// "Counted on 80 of 100 runs: the others have no press or no slip without a flag." Empty if `of_runs` is not known.
  std::string runs_counted() const;

  /// Whether the network's accuracy interval lies above that of every baseline; nothing where one of them is not known.
  std::optional<bool> above_baselines() const;
};

/// As eval.json has it; docs/format/evaluation.md lists its keys.
void to_json(nlohmann::json& json, const Evaluation& evaluation);
void from_json(const JsonView& json, Evaluation& evaluation);

/// "Evaluation of th40-single-1 on simulated runs", "… and 4 more trainings on …"
std::string title_of(const Evaluation& evaluation);

}  // namespace tactile::results
