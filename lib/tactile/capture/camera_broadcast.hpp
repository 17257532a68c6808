#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "tactile/capture/camera_source.hpp"
#include "tactile/network/dv_stream_server.hpp"

namespace tactile {

struct CameraBroadcastOptions {
  microseconds packet_span{1'000};   ///< a packet's last element comes earlier than this after its first, > 0
  std::size_t packet_events = 8192;  ///< and it has at most so many events, > 0
};

/// What was handed to the servers, whether or not a client was there.
struct BroadcastCounts {
  std::uint64_t packets = 0;
  std::uint64_t events = 0;
  std::uint64_t imu_samples = 0;
  std::uint64_t triggers = 0;
  std::uint64_t frames = 0;
};

/// Hands a camera's streams to the servers that carry them, cut to packets of bounded span.
class CameraBroadcast {
 public:
  /// @throws Error  if an option is out of range
  explicit CameraBroadcast(CameraBroadcastOptions options = {});

  /// From here on the stream goes to `server`, which must outlive this. One stream may have several.
  void add(std::int32_t stream_id, DvStreamServer& server) { servers_.emplace(stream_id, &server); }

  /// Elements of a stream that has no server go nowhere. @throws Error as the server does
  void send(const CameraPacket& packet);

  const BroadcastCounts& counts() const { return counts_; }

 private:
  CameraBroadcastOptions options_;
  std::multimap<std::int32_t, DvStreamServer*> servers_;
  BroadcastCounts counts_;
};

}  // namespace tactile
