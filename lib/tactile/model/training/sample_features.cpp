#include "tactile/model/training/sample_features.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>

#include "tactile/core/error.hpp"
#include "tactile/features/tick_features.hpp"

namespace tactile::model {

std::vector<float> sample_features(const windows::Dataset& dataset, std::uint32_t run, std::span<const std::uint32_t> samples,
                                   const heatmaps::HeatmapOptions& rendering) {
  const std::optional<microseconds> bin = features::feature_bin(rendering.tick, rendering.history);
  if (!bin) {
    throw Error(
        fmt::format("a history of {} us in ticks of {} us has no features; expected a multiple of 4 us, in at most {} bins",
                    rendering.history.count(), rendering.tick.count(), features::SlidingSums::most_bins));
  }
  features::SlidingSums sums(dataset.sensor(), rendering.history, *bin, rendering.mask);
  const std::vector<events::Event> events = dataset.events(run);
  auto given = events.begin();
  std::vector<float> features;
  features.reserve(samples.size() * features::feature_count);
  for (const std::uint32_t sample : samples) {
    const CameraTime t = dataset.samples()[sample].t;
    const auto end = std::partition_point(given, events.end(), [t](const events::Event& event) { return event.t < t; });
    sums.add(std::span(given, end));
    sums.move_to(t);
    const features::TickFeatures of_sample = features::tick_features(sums, dataset.sensor());
    features.insert(features.end(), of_sample.begin(), of_sample.end());
    given = end;
  }
  return features;
}

}  // namespace tactile::model
