#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "command.hpp"
#include "tactile/model/inference/decision.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::cli {

/// The dataset of DATA: DATA/dataset.h5, or DATA itself if it is a file.
std::filesystem::path dataset_file(const std::string& data);

/// Creates a missing dataset with the defaults of `windows`, and logs this. Nothing if there is one. Pass its errors to
/// `end_with`.
/// @throws Error as `write_dataset`
std::optional<windows::DatasetSummary> make_missing_dataset(const std::string& data, bool strict, const CommonArguments& common);

/// Warns if runs or objects of these splits differ from the requested ones, and explains how to include flagged ones.
/// @return  the warnings. @throws Error  if an object has no run with samples and `strict` is set
std::vector<std::string> warn_of_splits(const windows::Dataset& dataset, std::span<const windows::SplitOptions> splits,
                                        bool strict);

/// k/n of `--confirm`.
Check is_confirmation();

/// How predictions become verdicts. "off" leaves a confirmation or thresholds out.
struct DecisionArguments {
  std::string confirm = "off", thresholds = "off";
  bool filter = false;
  double alarm_cost = model::default_alarm_cost;
  std::string usual_thresholds = thresholds;  ///< the command's default
};

/// The gate, which skips the network while the skin is quiet.
struct GateArguments {
  bool on = false;
  double miss = model::gate_share;
};

/// `--gate` and `--gate-miss`.
void add_gate_options(Command command, GateArguments& args);

/// `--confirm`, `--filter` and `--alarm-cost`.
void add_decision_options(Command command, DecisionArguments& args);

/// `--thresholds`.
void add_thresholds_option(Command command, DecisionArguments& args);

Confirmation confirmation_of(const DecisionArguments& args);

/// The alarm cost of the filter; nothing without a filter. @throws Error  if a confirmation is given too
std::optional<double> alarm_cost_of(const DecisionArguments& args);

/// The thresholds; nothing if they are off, or if they are the command's default and a confirmation or a filter is given.
/// @throws Error  if others than the default are given with a confirmation or a filter
std::optional<model::TwoThresholds> thresholds_of(const DecisionArguments& args);

/// @throws Error  also if the model has no transitions for the filter
model::Decision decision_of(const DecisionArguments& args, const model::ModelBundle& bundle,
                            const model::ModelDescription& model);

/// The objects to hold out: `named`, or those of the paper's five that the dataset has.
/// @throws Error  if none is left to hold out, or none to train on
std::vector<std::string> objects_to_hold_out(const std::vector<std::string>& named, const windows::Dataset& dataset);

/// The size of a training: "3636 samples, 10 epochs".
std::string training_size(const windows::Dataset& dataset, const model::ModelSettings& settings);

/// Logs the remaining time of a training after its first epoch, and again after an epoch that shows an error of a quarter.
class TrainingEstimate {
 public:
  /// @param progress  called with what `see` receives
  TrainingEstimate(unsigned epochs, ProgressCallback progress) : epochs_(epochs), progress_(std::move(progress)) {}

  void begin(unsigned epoch, double done);  ///< as `TrainModelOptions::begins`: the training begins here
  void see(const Progress& progress);

 private:
  using Clock = std::chrono::steady_clock;

  unsigned epochs_;
  ProgressCallback progress_;
  bool has_begun_ = false;
  Clock::time_point measured_from_{};
  double measured_from_epochs_ = 0;  ///< epochs that were done then
  std::optional<Clock::time_point> expected_end_;
};

/// `--engine`, which runs a model.
void add_engine_option(Command command, std::string& engine);

/// `--width` and `--last-pool` of a network to train.
void add_network_size(Command command, double& width, int& last_pool);

}  // namespace tactile::cli
