#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tactile/detect/detection_session.hpp"

namespace tactile::cli {

/// The model of a detection, and what ran it.
struct DetectModel {
  std::string name, engine, precision;
};

/// @param all  also every part of a tick's time, and how it is distributed
std::string text_of(const detect::DetectionSummary& summary, const DetectModel& model, bool all);
nlohmann::json json_of(const detect::DetectionSummary& summary, const DetectModel& model);

}  // namespace tactile::cli
