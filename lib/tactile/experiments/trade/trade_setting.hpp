#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/definition/engine_kind.hpp"
#include "tactile/model/definition/model_settings.hpp"
#include "tactile/model/inference/lenet_engine.hpp"
#include "tactile/results/traded_setting.hpp"

namespace tactile::trade {

/// All parameters of a detector that trade speed for accuracy. The defaults are the paper's; those that change no verdict are the
/// fastest.
struct TradeSetting {
  model::ModelKind kind = model::ModelKind::lenet;
  heatmaps::HeatmapOptions rendering{};  ///< its tick is the detector's; LeNet may have another
  model::Augmentation augmentation{};    ///< in its training
  model::EngineKind engine = model::EngineKind::fast;
  model::Precision precision = model::Precision::fp32;

  friend bool operator==(const TradeSetting&, const TradeSetting&) = default;
};

/// The same with the defaults of all parameters that only LeNet has, if the kind is another: factor, resize, denoise,
/// augmentation, engine and precision. The history of a stream is its tick.
TradeSetting without_idle_values(TradeSetting setting);

/// "none", "flip+stress:noise:200": as `model::text_of`, but joined by +, so that commas separate values of an option.
std::string joined_text_of(const model::Augmentation& augmentation);
model::Augmentation joined_augmentation_named(std::string text);  ///< @throws Error

/// The same setting, as options name it.
results::SettingValues values_of(const TradeSetting& setting);
void to_json(nlohmann::json& json, const TradeSetting& setting);  ///< as `values_of`

/// A unique name: "th40-tick2-f0.2-area-mean-fast-fp32"; an augmentation adds "-flip+shift" or, with
/// recipes, "-augment-" and a hash, another kind than LeNet "-stream".
std::string id_of(const TradeSetting& setting);

/// Its differences from `base`: "t_h 20 ms, int8"; "as usual" if there is none.
std::string text_of(const TradeSetting& setting, const TradeSetting& base = {});

/// Why the setting is impossible; nothing if it is possible.
std::optional<std::string> why_impossible(const TradeSetting& setting);

}  // namespace tactile::trade
