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
#include "tactile/results/confusion.hpp"
#include "tactile/results/delay_table.hpp"
#include "tactile/results/members.hpp"
#include "tactile/results/whole_runs.hpp"

namespace tactile::results {

/// Delays of one detector on the runs that have samples.
struct DetectorScore {
  DelayTable press{}, slip{};
};

template <class Members>
void list_members(Members& members, DetectorScore& score) {
  members("press", score.press);
  members("slip", score.slip);
}

/// Against the truth of simulated runs.
struct TruthScore {
  Accuracy accuracy{};  ///< on the same samples, each with the class that its tick truly has
  Confusion confusion{};
  DetectorScore delay_ms{};  ///< from the true onset
};

template <class Members>
void list_members(Members& members, TruthScore& truth) {
  members("accuracy", truth.accuracy);
  members("confusion", truth.confusion);
  members("delay_ms", truth.delay_ms);
}

/// A model that was evaluated, and on what.
struct EvaluatedModel {  // NOLINT(bugprone-exception-escape): moving nlohmann::json does not throw
  std::string name{};
  nlohmann::json settings = nullptr;
  std::string weights_sha256{};
  std::vector<std::string> test_runs{};  ///< "fan/03", in order
};

template <class Members>
void list_members(Members& members, EvaluatedModel& model) {
  members("name", model.name);
  members("settings", model.settings);
  members("weights_sha256", model.weights_sha256);
  members("test_runs", model.test_runs);
}

struct NamedDataset {
  std::string file{}, manifest_hash{};
};

template <class Members>
void list_members(Members& members, NamedDataset& dataset) {
  members("file", dataset.file);
  members("manifest_hash", dataset.manifest_hash);
}

/// What computed the verdicts.
struct UsedEngine {
  std::string name{};                        ///< "fast" or "libtorch"
  std::uint64_t ticks = 0, close_ticks = 0;  ///< of all test runs; of them those where another engine's verdict may differ
};

template <class Members>
void list_members(Members& members, UsedEngine& engine) {
  members("name", engine.name);
  members("ticks", engine.ticks);
  members("close_ticks", engine.close_ticks);
}

/// Figures of the trainings of one setting, each on runs that it was not trained on.
struct Evaluation {
  std::vector<EvaluatedModel> models{};  ///< one for each training
  NamedDataset dataset{};
  bool simulated = false;
  microseconds sampling_guard{0}, tick{0};
  std::string onset = "first";  ///< of touches: their first motion; or "visible": when the events show them by eye
  std::string confirm = "1/1";  ///< "2/3": a class is reported once 2 of the last 3 ticks predict it
  std::string thresholds{};     ///< "2.5:-1.5:20:3.5": of a decision by two thresholds; empty: none
  BootstrapOptions bootstrap{};
  UsedEngine engine{};

  Accuracy accuracy{};
  Confusion confusion{};
  Calibration calibration{};                       ///< of the network's own verdicts, unconfirmed
  Calibration whole_run_calibration{};             ///< the same at every tick of a sure class
  std::map<std::string, Baseline> baselines{};     ///< by name; empty where the dataset has no run that the model learned from
  DetectorScore network{};                         ///< against the labels
  std::map<std::string, DetectorScore> trivial{};  ///< "always_press", "always_slip", "random": unconfirmed, same labels
  WholeRuns whole_runs{};                          ///< on every run that no training learned from
  std::optional<TruthScore> truth{};

  std::vector<std::string> test_runs() const;  ///< of all trainings, each once, by name
};

template <class Members>
void list_members(Members& members, Evaluation& evaluation) {
  members("trainings", evaluation.models);
  members("dataset", evaluation.dataset);
  members("simulated", evaluation.simulated);
  members("sampling_guard_ms", evaluation.sampling_guard);
  members("tick_ms", evaluation.tick);
  members("onset", evaluation.onset);
  members("confirm", evaluation.confirm);
  members("thresholds", evaluation.thresholds);
  members("bootstrap", evaluation.bootstrap);
  members("engine", evaluation.engine);
  members("accuracy", evaluation.accuracy);
  members("confusion", evaluation.confusion);
  members("calibration", evaluation.calibration);
  members("calibration_whole_runs", evaluation.whole_run_calibration);
  members("baselines", evaluation.baselines);
  members("delay_ms", evaluation.network);
  members("trivial", evaluation.trivial);
  members("whole_runs", evaluation.whole_runs);
  members("truth", evaluation.truth);
}

/// As eval.json has it: its members, and what follows from them. docs/format/evaluation.md lists its keys.
void to_json(nlohmann::json& json, const Evaluation& evaluation);
void from_json(const JsonView& json, Evaluation& evaluation);  ///< @throws Error  if it has no training

/// "Evaluation of th40-single-1 on simulated runs", "… and 4 more trainings on …"
std::string title_of(const Evaluation& evaluation);

}  // namespace tactile::results
