#include "tactile/model/training/open_classifier.hpp"

#include <fmt/core.h>

#include <memory>

#include "tactile/core/error.hpp"
#include "tactile/core/loaded_part.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/opencv/opencv_networks.hpp"
#include "tactile/model/torch/torch_part.hpp"
#include "tactile/model/training/lenet.hpp"

namespace tactile::model {
namespace {

constexpr std::uint64_t largest_network = std::uint64_t{2} << 30;  // [bytes]

OpenOwnNetwork own_network_on_opencv(const std::filesystem::path& file, const NetworkPorts& ports) {
  static const auto& networks =
      *static_cast<const OpenCvNetworks*>(load_part("tactile-opencv.so", "tactile_opencv_networks", std::size_t{256} << 20));
  return [file, ports, onnx = std::make_shared<const std::string>(read_text(file, largest_network))] {
    try {
      return networks.open(*onnx, ports);
    } catch (const Error& e) {
      throw Error(file.string() + ": " + e.what());
    }
  };
}

Classifier own_classifier_of(const std::filesystem::path& file, EngineKind engine, const EngineOptions& options) {
  const bool is_onnx = file.extension() == ".onnx";
  if (options.precision != Precision::fp32)
    throw Error(fmt::format("--precision {}: {} runs as it is; expected fp32", name_of(options.precision), file.string()));
  if (is_onnx && engine == EngineKind::libtorch)
    throw Error(fmt::format("--engine libtorch: {} is run by OpenCV's dnn; expected no --engine", file.string()));
  if (const auto size = std::filesystem::file_size(file); size > largest_network)
    throw Error(fmt::format("{}: {} bytes; expected {} at most", file.string(), size, largest_network));
  return {file, is_onnx ? EngineKind::opencv : EngineKind::libtorch, [&](const NetworkPorts& ports) {
            return is_onnx ? own_network_on_opencv(file, ports) : torch_part().own_network(file.string(), ports);
          }};
}

}  // namespace

Classifier open_classifier(const std::filesystem::path& bundle, unsigned threads, EngineKind engine,
                           const EngineOptions& options) {
  if (is_own_network(bundle)) return own_classifier_of(bundle, engine, options);
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
