#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include "tactile/core/time.hpp"
#include "tactile/network/network_address.hpp"

namespace tactile {

/// A client's connection: bytes in order, every wait bounded.
class Connection {
 public:
  /// Connects, trying every address of the host's name. @throws Error  that names the address and why: no such host, refused, no
  /// answer within `patience`, no such socket
  Connection(const NetworkAddress& address, std::chrono::milliseconds patience);
  ~Connection();
  Connection(Connection&&) noexcept;
  Connection& operator=(Connection&&) noexcept;

  /// Waits up to `patience` for bytes and puts them at the front of `bytes`; returns how many, 0 if none came, nothing once the
  /// server has closed. @throws Error if the connection broke
  std::optional<std::size_t> receive(std::span<std::byte> bytes, std::chrono::microseconds patience);

  /// When the last of the bytes last received came to this machine, however late they were asked for: by the system's network
  /// code, over TCP alone, which may hold what comes behind them for one with them. Nothing where the system does not tell.
  std::optional<HostTime> arrived() const;
  bool tells_arrivals() const;  ///< as a rule; it may take the system a moment until it does

  /// @throws Error  if the connection broke, or the server did not take all of it within `patience`
  void send(std::span<const std::byte> bytes, std::chrono::milliseconds patience);

  const NetworkAddress& address() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
