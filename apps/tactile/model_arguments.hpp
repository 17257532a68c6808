#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "command.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile {

/// The dataset that DATA means: DATA/dataset.h5, or DATA itself where it is a file.
std::filesystem::path dataset_file(const std::string& data);

/// Makes a missing dataset by windows' defaults, and says so. Nothing if there is one. Its errors are for `end_with`.
/// @throws Error as `write_dataset`
std::optional<DatasetSummary> make_missing_dataset(const std::string& data, bool strict, const CommonArguments& common);

/// Warns of runs and objects of these splits that are not those asked for, and of what lifts flags.
/// @return  the sentences  @throws Error  if an object has no run with samples and `strict` is set
std::vector<std::string> warn_of_splits(const Dataset& dataset, std::span<const SplitOptions> splits, bool strict);

/// k/n of `--confirm`.
Check is_confirmation();

/// The objects to hold out: those named, or those of the paper's five that the dataset has.
/// @throws Error  where none was named and none of those, or nothing else, is there
std::vector<std::string> objects_to_hold_out(const std::vector<std::string>& named, const Dataset& dataset);

/// What a training works through, for people: "3636 samples, 10 epochs".
std::string training_size(const Dataset& dataset, const ModelSettings& settings);

/// Logs how much longer a training takes once its first epoch has shown it, and once more where an epoch shows that this was
/// wrong by a quarter.
class TrainingEstimate {
 public:
  /// @param progress  gets what `see` gets
  TrainingEstimate(unsigned epochs, ProgressCallback progress) : epochs_(epochs), progress_(std::move(progress)) {}

  void begin(unsigned epoch, double done);  ///< as `TrainModelOptions::begins`: what comes before is no training
  void see(const Progress& progress);

 private:
  using Clock = std::chrono::steady_clock;

  unsigned epochs_;
  ProgressCallback progress_;
  bool has_begun_ = false;
  Clock::time_point measured_from_{};
  double measured_from_epochs_ = 0;  ///< so many were done then
  std::optional<Clock::time_point> expected_end_;
};

/// `--engine`, what a model is run with.
void add_engine_option(Command command, std::string& engine);

}  // namespace tactile
