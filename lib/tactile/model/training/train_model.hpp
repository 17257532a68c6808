#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/training/checkpoint.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/split.hpp"

namespace tactile::model {

/// The split of a dataset's runs. @throws Error as `split_runs`
windows::Split split_of(const windows::Dataset& dataset, const windows::SplitOptions& options);

/// The test runs of a model: those of its split. In another dataset, such as one that has grown, all runs; of a model with
/// held-out objects, those of all objects that it did not learn from. Runs that the model, or its starting model, learned from
/// are excluded. @throws Error  if none with samples remains
std::vector<std::uint32_t> test_runs_of(const windows::Dataset& dataset, const ModelDescription& model);

/// The runs whose recordings the model, or its starting model, learned from.
std::vector<std::uint32_t> learned_runs_of(const windows::Dataset& dataset, const ModelDescription& model);

/// The samples of these runs, by their index, in the dataset's order.
std::vector<std::uint32_t> samples_of_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> run_indexes);

/// The heatmaps of samples, read from the dataset if that rendering is stored, otherwise rendered from its events. Both give the
/// same bytes.
/// @return  [sample_indexes, height, width]
/// @throws Error as `render_samples`
std::vector<std::uint8_t> sample_heatmaps(const windows::Dataset& dataset, const heatmaps::HeatmapOptions& options,
                                          std::span<const std::uint32_t> sample_indexes, unsigned threads = 0,
                                          const ProgressCallback& progress = {});

/// The model that training starts from, for these settings.
/// @throws Error  if the bundle is damaged, its rendering, network or heatmap size differ, or it learned from a held-out object
StartingPoint starting_point(const ModelBundle& from, const windows::Dataset& dataset, const ModelSettings& settings);

struct TrainModelOptions {
  unsigned threads = 0;  ///< 0: one per core, or as in the resumed state
  bool resume = false;   ///< resumes from the state that an interrupted training of this name left, if any
  std::chrono::duration<double> save_every{30};  ///< between two saved states, in addition to those after each epoch; >= 0
  std::filesystem::path from{};                  ///< the bundle of `settings.from`
  IfThere if_there = IfThere::replace;           ///< what becomes of an existing bundle when training ends
  nlohmann::json command_settings{};             ///< for the bundle's `settings.json`; null: it has none
  std::filesystem::path tensorboard{};           ///< folder for an event file of the scalars of each epoch; empty: none

  /// Called when the heatmaps are ready, with the epoch (from 1) and the finished part of it in [0, 1]. A new training begins
  /// with 1 and 0. May be empty.
  std::function<void(unsigned epoch, double done)> begins{};
};

/// Trains a model of a dataset and writes it to `bundle`. An existing bundle is replaced only when the new one is complete. Until
/// then the state is saved in the bundle's CheckpointFolder, with the `history.csv` of the epochs that are finished. It stays
/// there if training is interrupted or the bundle cannot be written.
/// @throws Error  as `split_of`, `sample_heatmaps`, `train_lenet` and CheckpointFolder; then nothing is replaced
TrainingSummary train_model(const windows::Dataset& dataset, const ModelSettings& settings, const ModelBundle& bundle,
                            const TrainModelOptions& options = {}, const ProgressCallback& progress = {});

}  // namespace tactile::model
