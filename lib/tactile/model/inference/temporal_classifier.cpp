#include "tactile/model/inference/temporal_classifier.hpp"

#include <utility>

namespace tactile::model {

TemporalClassifier::TemporalClassifier(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering, microseconds step,
                                       std::shared_ptr<const TemporalNetwork> network)
    : sensor_(sensor),
      rendering_(rendering),
      windows_(features::step_windows(rendering.history, step, rendering.tick)),
      network_(std::move(network)),
      features_(sensor, windows_, rendering.mask) {}

void TemporalClassifier::restart() { features_ = features::StepFeatures(sensor_, windows_, rendering_.mask); }

}  // namespace tactile::model
