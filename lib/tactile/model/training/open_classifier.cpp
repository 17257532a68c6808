#include "tactile/model/training/open_classifier.hpp"

#include <memory>

#include "tactile/model/training/lenet.hpp"

namespace tactile::model {

Classifier open_classifier(const std::filesystem::path& bundle, unsigned threads, EngineKind engine,
                           const EngineOptions& options) {
  if (engine == EngineKind::fast) return Classifier(bundle, threads, options);
  return {bundle, threads, engine, [](const ModelDescription& model, const Weights& weights) -> HeatmapNetwork {
            const auto network = std::make_shared<LeNet>(model.input, weights, model.settings.network);
            return {[network](std::span<const std::uint8_t> heatmaps, unsigned on_threads) {
                      return network->logits(heatmaps, on_threads);
                    },
                    [network]() -> ClassifyHeatmap {
                      return [network](std::span<const std::uint8_t> heatmap) { return network->logits(heatmap, 1).front(); };
                    }};
          }};
}

}  // namespace tactile::model
