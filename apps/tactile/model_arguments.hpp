#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "command.hpp"
#include "tactile/model/train_model.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile {

/// The dataset that DATA means: DATA/dataset.h5, or DATA itself where it is a file.
std::filesystem::path dataset_file(const std::string& data);

/// Makes a missing dataset by windows' defaults, and says so. True if it did. @throws Error as `write_dataset`
bool make_missing_dataset(const std::string& data, bool strict, const CommonArguments& common);

/// Warns of runs and objects of these splits that are not those asked for, and of what lifts flags.
/// @return  the sentences  @throws Error  if an object has no run with samples and `strict` is set
std::vector<std::string> warn_of_splits(const Dataset& dataset, std::span<const SplitOptions> splits, bool strict);

/// k/n of `--confirm`.
CLI::Validator is_confirmation();

/// The objects to hold out: those named, or those of the paper's five that the dataset has.
/// @throws Error  where none was named and none of those, or nothing else, is there
std::vector<std::string> objects_to_hold_out(const std::vector<std::string>& named, const Dataset& dataset);

/// What a training works through, for people: "3636 samples, 10 epochs".
std::string training_size(const Dataset& dataset, const ModelSettings& settings);

/// Passes a training's progress on, and logs how much longer it takes once its first epoch is done: by what that took, which no
/// one knows before. It logs that once more where an epoch shows that it was wrong by a quarter.
ProgressCallback with_estimates(ProgressCallback progress, unsigned epochs);

/// `--engine`, what a model is run with.
void add_engine_option(CLI::App& command, std::string& engine);

}  // namespace tactile
