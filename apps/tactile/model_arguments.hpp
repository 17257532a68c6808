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
  std::string usual_thresholds = thresholds;  ///< the command's default
};

/// `--confirm`.
void add_confirm_option(Command command, DecisionArguments& args);

/// `--thresholds`.
void add_thresholds_option(Command command, DecisionArguments& args);

Confirmation confirmation_of(const DecisionArguments& args);

/// The thresholds; nothing if they are off, or if they are the command's default and a confirmation is given.
/// @param kind    of the model
/// @throws Error  if others than the default are given with a confirmation
std::optional<model::TwoThresholds> thresholds_of(const DecisionArguments& args, model::ModelKind kind);

model::Decision decision_of(const DecisionArguments& args, model::ModelKind kind);  ///< @throws Error  as `thresholds_of`

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
void add_engine_option(Command command, model::EngineKind& engine);

}  // namespace tactile::cli
