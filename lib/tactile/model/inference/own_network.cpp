#include "tactile/model/inference/own_network.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/model/bundle/own_description.hpp"
#include "tactile/model/inference/flushed_denormals.hpp"

namespace tactile::model {
namespace {

/// `read_own_description` has checked the sizes.
std::vector<float> zeros(const NetworkPort& port) {
  const std::int64_t count = std::accumulate(port.shape.begin(), port.shape.end(), std::int64_t{1}, std::multiplies<>());
  return std::vector<float>(static_cast<std::size_t>(count));
}

}  // namespace

NetworkPorts ports_of(const OwnDescription& description) {
  NetworkPorts ports{.inputs = {{description.input_name, description.input_shape()}},
                     .outputs = {{description.output_name, {1, touch_count}}}};
  for (const NetworkState& state : description.states) {
    ports.inputs.push_back({state.input, state.shape});
    ports.outputs.push_back({state.output, state.shape});
  }
  return ports;
}

OwnTicks::OwnTicks(std::string file, const NetworkPorts& ports, std::unique_ptr<OwnNetwork> network)
    : file_(std::move(file)), network_(std::move(network)) {
  for (const NetworkPort& port : ports.inputs) inputs_.push_back(zeros(port));
  for (const NetworkPort& port : ports.outputs) {
    outputs_.push_back(zeros(port));
    outputs_named_.push_back(port.name);
  }
}

Logits OwnTicks::advance() {
  try {
    const FlushedDenormals flushed;
    network_->run(inputs_, outputs_);
  } catch (const Error& e) {
    throw Error(file_ + ": " + e.what());
  }
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const auto bad = std::find_if(outputs_[i].begin(), outputs_[i].end(), [](float value) { return !std::isfinite(value); });
    if (bad == outputs_[i].end()) continue;
    throw Error(fmt::format("{}: value {} of its output {} is {}; expected finite values", file_, bad - outputs_[i].begin() + 1,
                            outputs_named_[i], *bad));
  }
  Logits logits{};
  std::copy(outputs_.front().begin(), outputs_.front().end(), logits.begin());
  for (std::size_t i = 1; i < inputs_.size(); ++i) std::swap(inputs_[i], outputs_[i]);
  return logits;
}

void OwnTicks::restart() {
  for (std::vector<float>& values : inputs_) std::fill(values.begin(), values.end(), 0.0F);
}

}  // namespace tactile::model
