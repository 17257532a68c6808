#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "tactile/detect/reported_tick.hpp"
#include "tactile/transport/network_address.hpp"

namespace tactile::detect {

inline constexpr std::size_t verdict_record_size = 64;
using VerdictRecord = std::array<std::byte, verdict_record_size>;

/// One tick as a UDP record: 64 bytes, little-endian; docs/format/ has the table.
/// @param sent  host time; also determines how long ago the tick closed
VerdictRecord verdict_record(const ReportedTick& tick, HostTime sent);

/// Sends records, one datagram each, and never waits. Records that the system does not accept at once are lost and counted.
class UdpRecords {
 public:
  /// @throws Error  if there is no such host
  explicit UdpRecords(const transport::NetworkAddress& to);
  ~UdpRecords();
  UdpRecords(const UdpRecords&) = delete;
  UdpRecords& operator=(const UdpRecords&) = delete;

  bool send(const ReportedTick& tick);  ///< false if it was not sent

  std::uint64_t sent() const { return sent_; }
  std::uint64_t failed() const { return failed_; }  ///< also if no program on this machine listens

 private:
  int socket_ = -1;
  std::uint64_t sent_ = 0, failed_ = 0;
};

}  // namespace tactile::detect
