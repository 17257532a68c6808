#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/baselines.hpp"
#include "tactile/evaluation/detection_delay.hpp"
#include "tactile/evaluation/false_alarms.hpp"
#include "tactile/model/classifier.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

struct EvaluationOptions {
  std::optional<microseconds> guard =
      std::nullopt;  ///< after an interval, alarms are counted apart for so long; >= 0, the dataset's own if not given
  DelayOptions delay{};
  BootstrapOptions bootstrap{};
  unsigned threads = 0;  ///< 0: as many as the machine has cores; no figure depends on it
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

/// What a model does on runs that it was not trained on.
struct Evaluation {
  nlohmann::json model;  ///< its name, settings and the hash of its weights
  std::string dataset, manifest_hash;
  bool simulated = false;
  microseconds guard{0}, tick{0};
  BootstrapOptions bootstrap;
  std::vector<std::string> test_runs;

  Accuracy accuracy;
  Confusion confusion;
  std::vector<BaselineScore> baselines;
  DetectorScore network;                         ///< against the labels
  std::map<std::string, DetectorScore> trivial;  ///< "always_press", "always_slip", "random", against the same labels

  /// Of simulated runs: delays against the true onsets, and of slips against `gross_us`, negative where told before it.
  std::optional<DelayTable> true_press, true_slip, gross_slip;

  /// Whether the network's accuracy interval lies above that of every baseline; nothing where one of them is not known.
  std::optional<bool> above_baselines() const;
};

/// Evaluates a model on runs of the dataset that it was trained on: accuracy and baselines on balanced samples; delays and false
/// alarms at every tick of the run folders.
///
/// @param test_runs  indexes into the dataset's runs, none of them trained on
/// @throws Error  if the model is of another dataset, a run folder's events or labels are not those the dataset was made from, or
/// a
///                recording cannot be read
Evaluation evaluate(const Dataset& dataset, const Classifier& classifier, std::span<const std::uint32_t> test_runs,
                    const EvaluationOptions& options = {}, const ProgressCallback& progress = {});

/// As eval.json has it; docs/cli.md lists its keys.
void to_json(nlohmann::json& json, const Evaluation& evaluation);

/// "Evaluation of th040-single-run-01-s1 on simulated runs"
std::string title_of(const Evaluation& evaluation);

/// What the network says of the balanced samples of these runs, one entry a run.
std::vector<RunConfusion> sample_confusions(const Dataset& dataset, const Classifier& classifier,
                                            std::span<const std::uint32_t> runs, unsigned threads = 0,
                                            const ProgressCallback& progress = {});

/// Accuracies of two models on the same runs.
struct UnseenComparison {
  std::string seen_model, held_out_model;  ///< trained with the objects, and without them
  Accuracy seen, held_out;
  Accuracy difference;  ///< held out - seen, paired over runs: below 0 where not having seen an object costs accuracy
  std::vector<std::string> runs;
};

/// {"models", "runs", "mean", "objects"}, with "seen", "held_out" and "difference" in "mean" and in each of "objects".
void to_json(nlohmann::json& json, const UnseenComparison& comparison);

/// Compares on `runs`, which neither model was trained on. @throws Error as `evaluate`
UnseenComparison compare_unseen(const Dataset& dataset, const Classifier& seen, const Classifier& held_out,
                                std::span<const std::uint32_t> runs, const BootstrapOptions& options = {}, unsigned threads = 0,
                                const ProgressCallback& progress = {});

/// The runs that neither of two splits trains on, of the objects that `held_out` holds out.
std::vector<std::uint32_t> runs_neither_saw(const Dataset& dataset, const SplitOptions& seen, const SplitOptions& held_out);

}  // namespace tactile
