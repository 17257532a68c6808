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

namespace tactile::model {

/// The number format of the first fully connected layer's weights, which are nine tenths of all.
enum class Precision : std::uint8_t {
  fp32,
  bf16,  ///< bfloat16, float32 without the last 16 bits, rounded; half the memory. Sums are float32
  int8,  ///< integers from -127 to 127 with a float32 scale per output; sums are float32
};

inline constexpr std::array<std::string_view, 3> precision_names{"fp32", "bf16", "int8"};
std::string_view name_of(Precision precision);     ///< "fp32", "bf16", "int8"
Precision precision_named(std::string_view name);  ///< @throws Error

struct EngineOptions {
  Precision precision = Precision::fp32;
  bool skip_empty = true;  ///< false: empty cells are computed too; the logits are identical to the last bit
  std::string target{};    ///< of `LeNetEngine::targets()`; the fastest if empty
};

/// LeNet's forward pass for one heatmap at a time, without libtorch.
///
/// If no cell in an output's receptive field is lit, the output is that of an empty heatmap and is not computed. The first fully
/// connected layer adds the differences to the sums of an empty heatmap. In float32 the logits differ from libtorch's by at most
/// 1e-5 of the largest. They depend on the processor's vector instructions within the same limit.
///
/// Has its own working memory: each thread needs a copy. Copies share the weights.
class LeNetEngine {
 public:
  /// @throws Error  if the layers are not ReLU and max-pooling, or as `lenet_layers`; if the weights have other shapes, are not
  ///                finite, or are so large that sums may exceed float32
  LeNetEngine(events::SensorSize input, const Weights& weights, const LeNetOptions& layers = {},
              const EngineOptions& options = {});
  ~LeNetEngine();
  LeNetEngine(const LeNetEngine& other);
  LeNetEngine& operator=(const LeNetEngine& other);
  LeNetEngine(LeNetEngine&&) noexcept;
  LeNetEngine& operator=(LeNetEngine&&) noexcept;

  const LeNetLayers& layers() const;
  std::string_view target() const;  ///< the vector instructions in use, "AVX2"

  /// The vector instructions of this build that the processor supports, the fastest first.
  static std::vector<std::string> targets();

  /// The logits of none, press, slip. Does not allocate memory.
  /// @param heatmap  [height, width] of the input's size; the network's input is H / 255
  /// @throws Error   if it has another size
  Logits classify(std::span<const std::uint8_t> heatmap);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::model
