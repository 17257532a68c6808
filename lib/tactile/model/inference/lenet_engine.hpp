#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/model/bundle/weights.hpp"
#include "tactile/model/definition/lenet_layers.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile {

/// What the first fully connected layer's weights, nine tenths of all, are kept in.
enum class Precision : std::uint8_t {
  fp32,
  int8,  ///< whole numbers of -127 to 127 times a float32 for each output; sums stay float32
};

std::string_view name_of(Precision precision);     ///< "fp32", "int8"
Precision precision_named(std::string_view name);  ///< @throws Error

struct EngineOptions {
  Precision precision = Precision::fp32;
  bool skip_empty = true;  ///< false: all is computed, whatever the heatmap; the logits are the same to the last bit
  std::string target{};    ///< of `LeNetEngine::targets()`; the fastest if empty
};

/// LeNet's forward pass for one heatmap at a time, without libtorch.
///
/// Where no cell under an output's receptive field is lit, the output is what an empty heatmap gives, and is not computed; the
/// first fully connected layer adds to an empty heatmap's sums what the differences make. In float32 the logits are libtorch's
/// within 1e-5 of the largest; they depend on the processor's vector instructions, within the same.
///
/// Keeps its own working memory: each thread wants a copy, which shares the weights.
class LeNetEngine {
 public:
  /// @throws Error  if the layers are others than ReLU and max-pooling, or as `lenet_layers`; if the weights are not of the
  ///                network's shapes, not finite, or so large that a heatmap's sums may leave float32
  LeNetEngine(SensorSize input, const Weights& weights, const LeNetOptions& layers = {}, const EngineOptions& options = {});
  ~LeNetEngine();
  LeNetEngine(const LeNetEngine& other);
  LeNetEngine& operator=(const LeNetEngine& other);
  LeNetEngine(LeNetEngine&&) noexcept;
  LeNetEngine& operator=(LeNetEngine&&) noexcept;

  const LeNetLayers& layers() const;
  std::string_view target() const;  ///< the vector instructions in use, "AVX2"

  /// The vector instructions that this was built for and the processor has, the fastest first.
  static std::vector<std::string> targets();

  /// The logits of none, press, slip; allocates nothing.
  /// @param heatmap  [height, width] of the input's size; the network sees it as H / 255
  /// @throws Error   if it is of another size
  Logits classify(std::span<const std::uint8_t> heatmap);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
