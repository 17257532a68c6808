#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include "tactile/core/time.hpp"
#include "tactile/transport/network_address.hpp"

namespace tactile::transport {

/// A client's connection. Every wait has a limit.
class Connection {
 public:
  /// Connects, and tries every address of the host's name.
  /// @throws Error  if there is no such host or socket, the connection is refused, or there is no answer within `patience`
  Connection(const NetworkAddress& address, std::chrono::milliseconds patience);
  ~Connection();
  Connection(Connection&&) noexcept;
  Connection& operator=(Connection&&) noexcept;

  /// Waits up to `patience` for bytes and writes them to the front of `bytes`.
  /// @return  how many bytes were received, 0 if none; nothing once the server has closed the connection
  /// @throws Error  if the connection broke
  std::optional<std::size_t> receive(std::span<std::byte> bytes, std::chrono::microseconds patience);

  /// When the last byte received reached this machine, even if it was read later. The system's network code takes this time,
  /// over TCP only; bytes that follow closely may have the same time. Nothing if the system does not report it.
  std::optional<HostTime> arrived() const;
  bool reports_arrivals() const;  ///< whether the system reports arrival times; the first ones may be missing

  /// @throws Error  if the connection broke, or the server did not accept all bytes within `patience`
  void send(std::span<const std::byte> bytes, std::chrono::milliseconds patience);

  const NetworkAddress& address() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::transport
