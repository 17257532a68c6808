#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tactile/model/inference/own_network.hpp"
#include "tactile/model/training/fit_stream.hpp"
#include "tactile/model/training/lenet.hpp"

namespace tactile::model {

/// `LeNet` on libtorch; its members do what those of `LeNet` say.
class LeNetOnTorch {
 public:
  LeNetOnTorch() = default;
  LeNetOnTorch(const LeNetOnTorch&) = delete;
  LeNetOnTorch& operator=(const LeNetOnTorch&) = delete;
  virtual ~LeNetOnTorch() = default;

  virtual const LeNetLayers& layers() const = 0;
  virtual Weights weights() const = 0;
  virtual std::vector<Logits> logits(std::span<const std::uint8_t> heatmaps, unsigned threads) const = 0;
};

/// `LeNetTrainer` on libtorch.
class TrainerOnTorch {
 public:
  TrainerOnTorch() = default;
  TrainerOnTorch(const TrainerOnTorch&) = delete;
  TrainerOnTorch& operator=(const TrainerOnTorch&) = delete;
  virtual ~TrainerOnTorch() = default;

  virtual BatchResult learn(std::span<const std::uint8_t> heatmaps, std::span<const Touch> truth, double learning_rate) = 0;
  virtual OptimizerState state() const = 0;
  virtual void restore(const OptimizerState& state) = 0;
};

/// What `tactile-torch.so` provides. It is loaded at the first use, because loading libtorch takes most of a second and 100 MB,
/// and only training and `--engine libtorch` need it.
struct TorchPart {
  std::unique_ptr<LeNetOnTorch> (*new_lenet)(events::SensorSize input, std::uint64_t seed, const LeNetOptions& options);
  std::unique_ptr<LeNetOnTorch> (*lenet_of)(events::SensorSize input, const Weights& weights, const LeNetOptions& options);
  /// @param network  of this part
  std::unique_ptr<TrainerOnTorch> (*new_trainer)(LeNetOnTorch& network, OptimizerKind optimizer,
                                                 const std::array<double, touch_count>& class_weights, unsigned threads,
                                                 const TrainerOptions& options);
  decltype(fit_stream)* stream_fit;
  decltype(stream_logits_by_libtorch)* stream_logits;
  OpenOwnNetwork (*own_network)(const std::string& file, const NetworkPorts& ports);
};

/// As `fit_stream` and `stream_logits_by_libtorch`, in the part.
decltype(fit_stream) fit_stream_on_torch;
decltype(stream_logits_by_libtorch) stream_logits_on_torch;

/// A network in a TorchScript file. @throws Error  if libtorch cannot read it
OpenOwnNetwork own_network_on_torch(const std::string& file, const NetworkPorts& ports);

/// @throws Error  if the part cannot be loaded
const TorchPart& torch_part();

}  // namespace tactile::model
