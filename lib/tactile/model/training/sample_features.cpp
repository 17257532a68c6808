#include "tactile/model/training/sample_features.hpp"

#include "tactile/features/step_features.hpp"
#include "tactile/features/tick_features.hpp"
#include "tactile/model/training/follow_samples.hpp"

namespace tactile::model {

std::vector<float> sample_features(const windows::Dataset& dataset, std::uint32_t run, std::span<const std::uint32_t> samples,
                                   const heatmaps::HeatmapOptions& rendering) {
  features::SlidingSums sums(dataset.sensor(), rendering.history, features::bin_of(rendering.tick, rendering.history),
                             rendering.mask);
  std::vector<float> features;
  features.reserve(samples.size() * features::feature_count);
  follow_samples(
      dataset, run, samples, [&](std::span<const events::Event> events) { sums.add(events); },
      [&](CameraTime t) {
        sums.move_to(t);
        const features::TickFeatures of_sample = features::tick_features(sums, dataset.sensor());
        features.insert(features.end(), of_sample.begin(), of_sample.end());
      });
  return features;
}

std::vector<float> sample_steps(const windows::Dataset& dataset, std::uint32_t run, std::span<const std::uint32_t> samples,
                                const heatmaps::HeatmapOptions& rendering) {
  features::StepFeatures steps(dataset.sensor(), features::step_windows(rendering.history, rendering.tick, rendering.tick),
                               rendering.mask);
  std::vector<float> features;
  features.reserve(samples.size() * features::step_values);
  follow_samples(
      dataset, run, samples, [&](std::span<const events::Event> events) { steps.add(events); },
      [&](CameraTime t) {
        steps.move_to(t);
        const auto& of_sample = steps.features();
        features.insert(features.end(), of_sample.begin(), of_sample.end());
      });
  return features;
}

}  // namespace tactile::model
