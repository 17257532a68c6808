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
#include "tactile/network/network_address.hpp"

namespace tactile {

/// What was wrong with a stream so far; such packets give nothing, and the stream goes on.
struct DvStreamProblems {
  std::uint64_t broken_packets = 0;       ///< that do not decompress or decode
  std::uint64_t mismatched_packets = 0;   ///< that hold another type than the stream's
  std::uint64_t foreign_packets = 0;      ///< of an id that the header does not declare
  std::uint64_t out_of_range_events = 0;  ///< outside the sensor, or of a polarity above 1; dropped
};

/// A client of a DV stream server: DV's network output, dv-processing's `NetworkWriter`, `tactile serve`. One connection carries
/// one stream. It sends nothing, for servers take any byte for an error.
///
/// Memory: a buffer for small packets that come together, and one packet, of at most `dv_packet_limit` bytes as sent and
/// `packet_limit` decompressed; sizes are checked before anything is allocated. Source: the DV network stream as dv-processing
/// writes it (IOHE header, then packets as in AEDAT4).
class DvStreamClient {
 public:
  /// Connects and reads the header. @throws Error  if that fails within `patience`, or what comes is no DV stream: too old a
  /// server (DV before 1.6 sends no header), garbage, more or less than one stream, a type that is not one of the four
  explicit DvStreamClient(const NetworkAddress& address, std::chrono::milliseconds patience = std::chrono::seconds(5));
  ~DvStreamClient();
  DvStreamClient(DvStreamClient&&) noexcept;
  DvStreamClient& operator=(DvStreamClient&&) noexcept;

  const NetworkAddress& address() const;
  const Stream& stream() const;
  Compression compression() const;

  enum class Received : std::uint8_t { packet, nothing, closed };
  /// Waits up to `patience` for a packet to be whole; silence is legal. `closed`: the server ended the stream between two
  /// packets.
  /// @throws Error  if the stream ends inside a packet or stops there for longer than the patience it was opened with, a packet's
  /// size is impossible (there is no way to find the next one), or the connection broke
  Received receive(std::chrono::microseconds patience);

  // The packet last received; those of another type than the stream's are empty. Valid until the next `receive`.
  std::span<Event> events();
  std::span<const ImuSample> imu() const;
  std::span<const Trigger> triggers() const;
  const std::optional<Frame>& frame() const;
  /// When its last bytes came to this machine, however late they were asked for. Nothing where the system does not tell: over
  /// TCP alone it does.
  std::optional<HostTime> arrived() const;
  bool more_came() const;       ///< bytes of the next packet were read with it: `arrived` is when those came
  bool tells_arrivals() const;  ///< as a rule

  const DvStreamProblems& problems() const;
  std::uint64_t bytes_received() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The most that one packet may take on the wire [B].
inline constexpr std::uint32_t dv_packet_limit = std::uint32_t{64} << 20;

}  // namespace tactile
