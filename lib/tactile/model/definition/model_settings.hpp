#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/definition/lenet_layers.hpp"
#include "tactile/model/definition/training_options.hpp"
#include "tactile/windows/split.hpp"

namespace tactile {

/// The model whose weights a training goes on from.
struct StartingPoint {
  std::string name;
  std::string weights_sha256;
};

/// All that decides, with the dataset, what a model becomes. The number of threads does not belong to it: it moves no more than
/// the last bits.
struct ModelSettings {
  HeatmapOptions rendering;
  SplitOptions split;
  LeNetOptions network;
  TrainingOptions training;
  std::optional<StartingPoint> from;
};

/// "rendering" as HeatmapOptions, "split" with "kind", "train_run" and, for unseen, "held_out" in alphabetical order, "network"
/// as LeNetOptions, "training" as TrainingOptions with "from": null, or the "name" and "weights_sha256" of a model.
void to_json(nlohmann::json& json, const ModelSettings& settings);
void from_json(const nlohmann::json& json, ModelSettings& settings);  ///< @throws Error

/// Whether the two make the same model of the same dataset.
bool same_settings(const ModelSettings& a, const ModelSettings& b);

/// "th040-single-run-01-s1": history, split, training run, seed. Settings off their default append "-" and the first 8 of their
/// hash.
std::string default_name(const ModelSettings& settings);

}  // namespace tactile
