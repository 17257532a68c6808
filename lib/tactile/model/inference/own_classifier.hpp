#pragma once

#include <memory>
#include <string>

#include "tactile/events/pixel_mask.hpp"
#include "tactile/model/bundle/own_description.hpp"
#include "tactile/model/inference/event_classifier.hpp"
#include "tactile/model/inference/own_network.hpp"

namespace tactile::model {

/// A network of one's own on the events of a stream. With heatmaps and without states, the logits of a tick depend on its history
/// alone; else it advances at every whole multiple of its tick, as `TickClassifier` does.
/// @param file       names it in errors
/// @param rendering  the description's own, except for tick and mask
/// @throws Error     if the tick is not its own and it has states or counts events, or as HeatmapRenderer and StreamCounts
std::unique_ptr<EventClassifier> own_classifier(const std::string& file, const OwnDescription& description,
                                                events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering,
                                                std::unique_ptr<OwnNetwork> network);

}  // namespace tactile::model
