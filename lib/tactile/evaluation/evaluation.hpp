#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/accuracy_over_time.hpp"
#include "tactile/evaluation/baselines.hpp"
#include "tactile/evaluation/calibration.hpp"
#include "tactile/evaluation/class_scores.hpp"
#include "tactile/evaluation/confirmation.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/evaluation/false_alarms.hpp"
#include "tactile/evaluation/operating_curve.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

struct EvaluationOptions {
  std::optional<microseconds> guard =
      std::nullopt;  ///< after an interval, alarms are counted apart for so long; >= 0, the dataset's own if not given
  Confirmation confirmation{};
  bool gate = false;  ///< the verdict is none below the model's limit of events
  DelayOptions delay{};
  OverTimeOptions over_time{};
  BootstrapOptions bootstrap{};
  unsigned threads = 0;  ///< 0: as many as the machine has cores; no figure depends on it

  /// Whether the model may be of another dataset, as labels that were corrected or runs that were added make one.
  bool of_another_dataset = false;
};

/// Delays and false alarms of one detector over full runs.
struct DetectorScore {
  DelayTable press, slip;
  FalseAlarmTable false_alarms;
};

/// A baseline on the same test samples as the network, fitted on the same training samples.
struct BaselineScore {
  std::string name;  ///< "majority", "event_count", "logistic_moments", "logistic_position"
  Accuracy accuracy;
};

/// Accuracy on balanced samples whose none keeps another distance from every interval.
struct GuardScore {
  microseconds guard{0};
  Accuracy accuracy;
  Accuracy difference;  ///< to the accuracy on the dataset's own samples, paired over runs
  Confusion confusion;
};

/// Against what truly happened, of simulated runs.
struct TruthScore {
  Accuracy accuracy;  ///< on the same samples, each with the class that its tick truly has
  Confusion confusion;
  DelayTable press, slip;  ///< from the true onset
  DelayTable gross_slip;   ///< from `gross_us`, negative where told before it
  FalseAlarmTable false_alarms;
  OverTime over_time;
};

/// The same without the gate, and how often it is closed.
struct GateOff {
  std::uint64_t limit = 0;  ///< events in t_h
  std::uint64_t ticks = 0, gated = 0;
  Accuracy accuracy;
  Confusion confusion;
  DetectorScore network;
};

/// What a model does on runs that it was not trained on.
struct Evaluation {
  nlohmann::json model;  ///< its name, settings and the hash of its weights
  std::string dataset, manifest_hash;
  bool simulated = false;
  microseconds guard{0}, sampling_guard{0}, tick{0};
  Confirmation confirmation;
  BootstrapOptions bootstrap;
  std::vector<std::string> test_runs;
  EngineKind engine = EngineKind::fast;
  std::uint64_t ticks = 0, close_ticks = 0;  ///< of all test runs; of them those where another engine's verdict may differ

  std::vector<RunConfusion> runs;         ///< of the balanced samples of each test run, in order
  std::vector<RunDetections> detections;  ///< likewise: how each labelled interval was met
  Accuracy accuracy;
  Confusion confusion;
  ClassScores classes;
  Calibration calibration;               ///< of the network's own verdicts, unconfirmed
  std::vector<GuardScore> guards;        ///< the dataset's own first, then 100 ms and 0 where they are others
  std::vector<BaselineScore> baselines;  ///< empty where the dataset has no run that the model learned from
  DetectorScore network;                 ///< against the labels
  std::optional<GateOff> gate_off;       ///< where the gate is on, beside all the rest
  std::map<std::string, DetectorScore>
      trivial;  ///< "always_press", "always_slip", "random", unconfirmed, against the same labels
  OverTime over_time;
  std::vector<OperatingPoint> operating_curve;  ///< confirmed as the verdicts are
  std::optional<TruthScore> truth;

  /// Whether the network's accuracy interval lies above that of every baseline; nothing where one of them is not known.
  std::optional<bool> above_baselines() const;
};

/// Evaluates a model on runs of a dataset, all by one pass over every tick of their run folders: a
/// balanced sample has the verdict at its tick.
///
/// @param test_runs  indexes into the dataset's runs, none of them trained on
/// @throws Error  if the model is of another dataset and may not, or of heatmaps of another size, a run folder's events or labels
/// are not those the dataset was made from, a
///                sample lies at no tick of the model's, or a recording cannot be read
Evaluation evaluate(const Dataset& dataset, const Classifier& classifier, std::span<const std::uint32_t> test_runs,
                    const EvaluationOptions& options = {}, const ProgressCallback& progress = {});

/// As eval.json has it; docs/cli.md lists its keys.
void to_json(nlohmann::json& json, const Evaluation& evaluation);

/// "Evaluation of th040-single-run-01-s1 on simulated runs"
std::string title_of(const Evaluation& evaluation);

/// What the network says of the balanced samples of these runs, one entry a run: from the dataset's heatmaps, or from every tick
/// of the run folders where verdicts are to be confirmed.
/// @throws Error as `evaluate`
std::vector<RunConfusion> sample_confusions(const Dataset& dataset, const Classifier& classifier,
                                            std::span<const std::uint32_t> runs, const EvaluationOptions& options = {},
                                            const ProgressCallback& progress = {});

/// Compares on `runs`, which neither model was trained on. @throws Error as `evaluate`
UnseenComparison compare_unseen(const Dataset& dataset, const Classifier& seen, const Classifier& held_out,
                                std::span<const std::uint32_t> runs, const EvaluationOptions& options = {},
                                const ProgressCallback& progress = {});

/// The runs that neither model learned from, of the objects that `held_out` holds out. @throws Error  if none has samples
std::vector<std::uint32_t> runs_neither_saw(const Dataset& dataset, const ModelDescription& seen,
                                            const ModelDescription& held_out);

}  // namespace tactile
