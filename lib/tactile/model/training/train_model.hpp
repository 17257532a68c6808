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

namespace tactile {

/// "fan/01"
std::string name_of(const DatasetRun& run);

/// The split of a dataset's runs. @throws Error as `split_runs`
Split split_of(const Dataset& dataset, const SplitOptions& options);

/// The runs that a model may be tested on: those of its split, in another dataset all (of the objects held out), but for those
/// that it, or a model that it went on from, learned from. @throws Error  if none with samples is left
std::vector<std::uint32_t> test_runs_of(const Dataset& dataset, const ModelDescription& model);

/// The samples of these runs, by their index, in the dataset's order.
std::vector<std::uint32_t> samples_of_runs(const Dataset& dataset, std::span<const std::uint32_t> run_indexes);

/// Heatmaps of samples: read from the dataset where that rendering is stored, else rendered from its events; the bytes are the
/// same.
/// @return  [sample_indexes, height, width]
/// @throws Error as `render_samples`
std::vector<std::uint8_t> sample_heatmaps(const Dataset& dataset, const HeatmapOptions& options,
                                          std::span<const std::uint32_t> sample_indexes, unsigned threads = 0,
                                          const ProgressCallback& progress = {});

enum class BundleState : std::uint8_t {
  missing,
  unchanged,  ///< made with these settings from this dataset, and whole
  changed,    ///< made with others, or damaged
};

/// What lies under a bundle's name, against what `train_model` would put there.
BundleState state_of(const ModelBundle& bundle, const Dataset& dataset, const ModelSettings& settings);

/// The model to go on from, for settings that are otherwise as given.
/// @throws Error  if it is no whole bundle, its rendering, its network or its heatmaps' size are others, or it learned from an
/// object that is to be held out
StartingPoint starting_point(const ModelBundle& from, const Dataset& dataset, const ModelSettings& settings);

struct TrainModelOptions {
  unsigned threads = 0;                          ///< 0: as many as the machine has cores, or as the state resumed was begun with
  bool resume = false;                           ///< goes on from the state that a training of this name left, where it left one
  std::chrono::duration<double> save_every{30};  ///< between two states that are kept, beside those at each epoch's end; >= 0
  std::filesystem::path from{};                  ///< the bundle that `settings.from` names
  IfThere if_there = IfThere::replace;           ///< what happens to a bundle that is there when the training ends

  /// Told once the heatmaps are there, and whether there is a state to go on from: its epoch, from 1 on, and how much of that is
  /// done, in [0, 1]; 1 and 0 where a training begins. May be empty.
  std::function<void(unsigned epoch, double done)> begins{};
};

/// Trains a model of a dataset and writes it to `bundle`, replacing what is there, if at all, only when the new one is whole.
/// Until then what it has come to is kept in the bundle's CheckpointFolder, and stays there if it is ended, or if the bundle is
/// refused.
/// @throws Error  as `split_of`, `sample_heatmaps`, `train_lenet` and CheckpointFolder; nothing is overwritten then
TrainingSummary train_model(const Dataset& dataset, const ModelSettings& settings, const ModelBundle& bundle,
                            const TrainModelOptions& options = {}, const ProgressCallback& progress = {});

}  // namespace tactile
