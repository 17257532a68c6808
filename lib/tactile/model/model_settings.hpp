#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/training.hpp"
#include "tactile/windows/split.hpp"

namespace tactile {

/// All that decides, with the dataset, what a model becomes. The number of threads does not belong to it: it moves no more than
/// the last bits.
struct ModelSettings {
  HeatmapOptions rendering;
  SplitOptions split;
  TrainingOptions training;
};

/// "rendering" as HeatmapOptions, "split" with "kind", "train_run" and, for unseen, "held_out" in alphabetical order, "training"
/// as TrainingOptions.
void to_json(nlohmann::json& json, const ModelSettings& settings);
void from_json(const nlohmann::json& json, ModelSettings& settings);  ///< @throws Error

/// Whether the two make the same model of the same dataset.
bool same_settings(const ModelSettings& a, const ModelSettings& b);

/// "th040-single-run-01-s1": history, split, training run, seed. Settings off their default append "-" and the first 8 of their
/// hash.
std::string default_name(const ModelSettings& settings);

}  // namespace tactile
