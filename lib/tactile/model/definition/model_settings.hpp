#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/definition/lenet_layers.hpp"
#include "tactile/model/definition/model_kind.hpp"
#include "tactile/model/definition/stream_options.hpp"
#include "tactile/model/definition/training_options.hpp"
#include "tactile/windows/split.hpp"

namespace tactile::model {

/// The model whose weights a training starts from.
struct StartingPoint {
  std::string name;
  std::string weights_sha256;
};

/// Everything that, with the dataset, determines a trained model. The number of threads is not included, see
/// `depends_on_threads`.
struct ModelSettings {
  heatmaps::HeatmapOptions rendering;  ///< of stream, tick and mask; its history is the tick
  windows::SplitOptions split;
  LeNetOptions network;      ///< of LeNet
  TrainingOptions training;  ///< of stream only the seed
  std::optional<StartingPoint> from;
  ModelKind kind = ModelKind::lenet;
  StreamOptions stream{};  ///< of kind stream
};

/// "rendering" as HeatmapOptions, "split" with "kind", "train_run" and, for unseen, "held_out" in alphabetical order, "network"
/// as LeNetOptions, "training" as TrainingOptions with "from": null, or the "name" and "weights_sha256" of a model. Of
/// stream, "network" has "kind" and its options, and "training" only "seed" and "from".
void to_json(nlohmann::json& json, const ModelSettings& settings);
void from_json(const nlohmann::json& json, ModelSettings& settings);  ///< @throws Error

/// The share of the training samples that an early stop is judged by, where none is given.
inline constexpr double usual_validation_share = 0.2;

/// The options of `tactile train` that give these settings: "--th" of a LeNet, "--kind" of others, and those off their defaults.
std::vector<OptionValue> train_options(const ModelSettings& settings);

/// The options off their defaults that have no meaning for the settings' kind of model: "--lr" of a stream.
std::vector<std::string> idle_options(const ModelSettings& settings);

/// Whether the last digits of the weights depend on the number of threads: where libtorch's layers are trained.
bool depends_on_threads(const ModelSettings& settings);

/// Whether both give the same model with the same dataset.
bool same_settings(const ModelSettings& a, const ModelSettings& b);

/// The usual name of a model: "th40-single-7" with history, split and seed; "stream-single-7" of
/// kind stream, "th40-single-run02-7" of another training run than 01. Up to three settings off their default follow as words:
/// "th40-unseen-1-epochs3-denoise-none"; more, or such as are no words, as the first 8 characters of their hash. Different
/// settings have different names.
std::string default_name(const ModelSettings& settings);

}  // namespace tactile::model
