#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "tactile/detect/live_detector.hpp"
#include "tactile/network/network_address.hpp"

namespace tactile {

inline constexpr std::size_t verdict_record_size = 64;
using VerdictRecord = std::array<std::byte, verdict_record_size>;

/// One tick as it goes out by UDP: 64 bytes, little-endian; docs/format.md has the table.
/// @param sent  host time, and so how long ago the tick closed
VerdictRecord verdict_record(const ToldTick& tick, HostTime sent);

/// Sends records, one datagram each, and never waits: what the network does not take at once is lost and counted.
class UdpRecords {
 public:
  /// @throws Error  if there is no such host
  explicit UdpRecords(const NetworkAddress& to);
  ~UdpRecords();
  UdpRecords(const UdpRecords&) = delete;
  UdpRecords& operator=(const UdpRecords&) = delete;

  bool send(const ToldTick& tick);  ///< false if it is not sent

  std::uint64_t sent() const { return sent_; }
  std::uint64_t failed() const { return failed_; }  ///< that nobody listens on this machine counts too

 private:
  int socket_ = -1;
  std::uint64_t sent_ = 0, failed_ = 0;
};

}  // namespace tactile
