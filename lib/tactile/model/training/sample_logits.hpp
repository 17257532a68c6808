#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/model/inference/classifier.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::model {

/// The logits of samples by a model of any kind: of heatmaps that are stored or rendered, or of the events that the dataset
/// stores.
/// @param samples  indexes in the dataset, ascending
/// @param threads  > 0
/// @throws Error   as `sample_heatmaps` and `Classifier::on_events`
std::vector<Logits> sample_logits(const windows::Dataset& dataset, const Classifier& classifier,
                                  std::span<const std::uint32_t> samples, unsigned threads);

}  // namespace tactile::model
