#include <fmt/format.h>
#include <torch/csrc/jit/python/update_graph_executor_opt.h>
#include <torch/script.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/model/inference/own_outputs.hpp"
#include "tactile/model/torch/torch_part.hpp"
#include "tactile/model/torch/torch_training.hpp"

namespace tactile::model {
namespace {

/// Several threads may share a module: a call changes nothing in it.
class OwnOnTorch final : public OwnNetwork {
 public:
  OwnOnTorch(const torch::jit::Module& module, NetworkPorts ports) : module_(module), ports_(std::move(ports)) {}

  void run(std::span<const std::vector<float>> inputs, std::span<std::vector<float>> outputs) override {
    use_one_thread();
    // The optimizer compiles anew at the second call: the logits of a tick would depend on the ticks before, and come later.
    torch::jit::setGraphExecutorOptimize(false);
    try {
      const torch::NoGradGuard no_gradients;
      std::vector<torch::jit::IValue> given;
      for (std::size_t i = 0; i < inputs.size(); ++i)
        given.emplace_back(torch::from_blob(const_cast<float*>(inputs[i].data()), ports_.inputs[i].shape, torch::kFloat32));
      take(module_.forward(std::move(given)), outputs);
    } catch (const Error&) {
      throw;
    } catch (const std::exception& e) {
      throw Error(
          fmt::format("libtorch cannot run it ({}); expected a network that takes what its description says", line_of(e.what())));
    }
  }

 private:
  void take(const torch::jit::IValue& result, std::span<std::vector<float>> outputs) const {
    const std::vector<torch::jit::IValue> found =
        result.isTuple() ? result.toTupleRef().elements().vec() : std::vector<torch::jit::IValue>{result};
    if (found.size() != outputs.size())
      throw Error(fmt::format("it gives {} values; expected {}: the logits, then the next states", found.size(), outputs.size()));
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      if (!found[i].isTensor()) throw Error(fmt::format("its output {} is no tensor; expected one", ports_.outputs[i].name));
      const torch::Tensor tensor = found[i].toTensor();
      check_output(ports_.outputs[i], {tensor.sizes().begin(), tensor.sizes().end()});
      outputs[i] = values_of(tensor);
    }
  }

  mutable torch::jit::Module module_;
  NetworkPorts ports_;
};

}  // namespace

OpenOwnNetwork own_network_on_torch(const std::string& file, const NetworkPorts& ports) {
  try {
    use_one_thread();
    torch::jit::Module module = torch::jit::load(file, torch::kCPU);
    module.eval();
    return [module, ports] { return std::make_unique<OwnOnTorch>(module, ports); };
  } catch (const std::exception& e) {
    throw Error(fmt::format("{}: libtorch cannot read it ({}); expected a file of torch.jit.save", file, line_of(e.what())));
  }
}

}  // namespace tactile::model
