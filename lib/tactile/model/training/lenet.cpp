#include "tactile/model/training/lenet.hpp"

#include "tactile/model/torch/torch_part.hpp"

namespace tactile::model {
namespace {

/// The moments of an optimizer, with the names in its papers and libtorch.
std::vector<std::string> moment_names(OptimizerKind optimizer) {
  if (optimizer == OptimizerKind::sgd) return {"momentum_buffer"};
  return {"exp_avg", "exp_avg_sq"};
}

}  // namespace

LeNet::LeNet(events::SensorSize input, std::uint64_t seed, const LeNetOptions& options)
    : on_torch_(torch_part().new_lenet(input, seed, options)) {}

LeNet::LeNet(events::SensorSize input, const Weights& weights, const LeNetOptions& options)
    : on_torch_(torch_part().lenet_of(input, weights, options)) {}

LeNet::~LeNet() = default;
LeNet::LeNet(LeNet&&) noexcept = default;
LeNet& LeNet::operator=(LeNet&&) noexcept = default;

const LeNetLayers& LeNet::layers() const { return on_torch_->layers(); }

Weights LeNet::weights() const { return on_torch_->weights(); }

std::vector<Logits> LeNet::logits(std::span<const std::uint8_t> heatmaps, unsigned threads) const {
  return on_torch_->logits(heatmaps, threads);
}

std::vector<ParameterShape> moment_shapes(OptimizerKind optimizer, const std::vector<ParameterShape>& parameters) {
  std::vector<ParameterShape> shapes;
  for (const std::string& moment : moment_names(optimizer)) {
    for (const ParameterShape& parameter : parameters)
      shapes.push_back({"optimizer." + moment + "." + parameter.name, parameter.sizes});
  }
  return shapes;
}

LeNetTrainer::LeNetTrainer(LeNet& network, OptimizerKind optimizer, const std::array<double, touch_count>& class_weights,
                           unsigned threads, const TrainerOptions& options)
    : on_torch_(torch_part().new_trainer(*network.on_torch_, optimizer, class_weights, threads, options)) {}

LeNetTrainer::~LeNetTrainer() = default;

BatchResult LeNetTrainer::learn(std::span<const std::uint8_t> heatmaps, std::span<const Touch> truth, double learning_rate) {
  return on_torch_->learn(heatmaps, truth, learning_rate);
}

OptimizerState LeNetTrainer::state() const { return on_torch_->state(); }

void LeNetTrainer::restore(const OptimizerState& state) { on_torch_->restore(state); }

}  // namespace tactile::model
