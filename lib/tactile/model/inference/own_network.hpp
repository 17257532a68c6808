#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tactile/model/inference/logits.hpp"

namespace tactile::model {

struct OwnDescription;

/// An input or output of a network: float32 values in this shape, row by row.
struct NetworkPort {
  std::string name;
  std::vector<std::int64_t> shape;
};

/// The input, then each state; the logits [1, 3], then each next state.
struct NetworkPorts {
  std::vector<NetworkPort> inputs, outputs;
};

NetworkPorts ports_of(const OwnDescription& description);

/// A network that another program trained, in the library that runs its file. Of one thread.
class OwnNetwork {
 public:
  OwnNetwork() = default;
  OwnNetwork(const OwnNetwork&) = delete;
  OwnNetwork& operator=(const OwnNetwork&) = delete;
  virtual ~OwnNetwork() = default;

  /// One call.
  /// @param inputs   values of each input
  /// @param outputs  where the values of each output go, of the right size
  /// @throws Error   if the network fails, or an output has another shape; leading sizes of 1 do not count
  virtual void run(std::span<const std::vector<float>> inputs, std::span<std::vector<float>> outputs) = 0;
};

/// Opens the network for one more thread. Must be thread-safe. @throws Error  if the file cannot be used
using OpenOwnNetwork = std::function<std::unique_ptr<OwnNetwork>()>;

/// A network with its states, tick after tick.
class OwnTicks {
 public:
  /// @param file  names it in errors
  OwnTicks(std::string file, const NetworkPorts& ports, std::unique_ptr<OwnNetwork> network);

  std::span<float> input() { return inputs_.front(); }  ///< to be filled before each call

  /// The logits of the input; the states move on.
  /// @throws Error  as OwnNetwork; also if a logit or a state is not finite
  Logits advance();

  void restart();  ///< all states are 0 again

 private:
  std::string file_;
  std::vector<std::string> outputs_named_;  ///< for errors
  std::unique_ptr<OwnNetwork> network_;
  std::vector<std::vector<float>> inputs_, outputs_;
};

}  // namespace tactile::model
