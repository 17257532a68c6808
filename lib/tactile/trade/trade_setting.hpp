#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tactile/evaluation/confirmation.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/definition/engine_kind.hpp"
#include "tactile/model/inference/lenet_engine.hpp"

namespace tactile {

/// One way to come from events to verdicts: everything that trades speed for accuracy. The defaults are the paper's, and what
/// costs least without changing a verdict.
struct TradeSetting {
  HeatmapOptions rendering{};  ///< its tick is the detector's; the model's own may be another
  EngineKind engine = EngineKind::fast;
  Precision precision = Precision::fp32;
  bool sparse = true;  ///< the network skips what is empty; false: it computes all, to the same logits
  Confirmation confirmation{};
  bool gate = false;

  friend bool operator==(const TradeSetting&, const TradeSetting&) = default;
};

/// {"th_ms", "tick_ms", "factor", "resize", "denoise", "engine", "precision", "pass", "confirm", "gate"}
void to_json(nlohmann::json& json, const TradeSetting& setting);

/// A name that no other setting has: "th40-tick2-f0.2-area-mean-fast-fp32-sparse-1of1-open".
std::string id_of(const TradeSetting& setting);

/// In what it differs from `base`, for people: "t_h 20 ms, confirm 2/3"; "as usual" where in nothing.
std::string text_of(const TradeSetting& setting, const TradeSetting& base = {});

/// Why the setting makes no sense; nothing if it does.
std::optional<std::string> why_impossible(const TradeSetting& setting);

}  // namespace tactile
