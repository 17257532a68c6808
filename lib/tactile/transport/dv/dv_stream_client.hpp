#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/stream.hpp"
#include "tactile/transport/network_address.hpp"

namespace tactile::transport {

/// Faults of a stream so far. Such packets are skipped.
struct DvStreamProblems {
  std::uint64_t broken_packets = 0;       ///< cannot be decompressed or decoded
  std::uint64_t mismatched_packets = 0;   ///< contain another type than the stream's
  std::uint64_t foreign_packets = 0;      ///< have an id that the header does not declare
  std::uint64_t out_of_range_events = 0;  ///< outside the sensor, or with a polarity above 1; dropped
};

/// A client of a DV stream server: DV's network output, dv-processing's `NetworkWriter`, `tactile serve`. One connection carries
/// one stream. The client sends nothing, because servers treat any byte as an error.
///
/// Memory: a buffer for small packets, and one packet of at most `dv_packet_limit` bytes as sent and `packet_limit` bytes
/// decompressed. Sizes are checked before memory is allocated.
/// Source: the DV network stream as dv-processing writes it (IOHE header, then packets as in AEDAT4).
class DvStreamClient {
 public:
  /// Connects and reads the header.
  /// @throws Error  if that fails or takes longer than `patience`; if the server sends no DV stream or no header (DV before 1.6);
  /// if the header declares a number of streams other than 1, or a type that is not one of the four
  explicit DvStreamClient(const NetworkAddress& address, std::chrono::milliseconds patience = std::chrono::seconds(5));
  ~DvStreamClient();
  DvStreamClient(DvStreamClient&&) noexcept;
  DvStreamClient& operator=(DvStreamClient&&) noexcept;

  const NetworkAddress& address() const;
  const events::Stream& stream() const;
  events::Compression compression() const;

  enum class Received : std::uint8_t { packet, nothing, closed };
  /// Waits up to `patience` for a complete packet. A server may be silent between packets. `closed`: the server ended the stream
  /// between two packets.
  /// @throws Error  if the stream ends inside a packet, or pauses there for longer than the constructor's patience; if a packet's
  /// size is impossible, so that the next one cannot be found; if the connection broke
  Received receive(std::chrono::microseconds patience);

  // Contents of the last packet; empty for other types than the stream's. Valid until the next `receive`.
  std::span<events::Event> events();
  std::span<const events::ImuSample> imu() const;
  std::span<const events::Trigger> triggers() const;
  const std::optional<events::Frame>& frame() const;
  /// When its last bytes reached this machine, even if they were read later. Nothing if the system does not report it: it does
  /// so over TCP only.
  std::optional<HostTime> arrived() const;
  bool more_came() const;         ///< bytes of the next packet were read with it, and `arrived` is their time
  bool reports_arrivals() const;  ///< as `Connection` has it

  const DvStreamProblems& problems() const;
  std::uint64_t bytes_received() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The largest packet as sent [B].
inline constexpr std::uint32_t dv_packet_limit = std::uint32_t{64} << 20;

}  // namespace tactile::transport
