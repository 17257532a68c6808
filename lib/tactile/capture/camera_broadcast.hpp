#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "tactile/capture/camera_source.hpp"
#include "tactile/transport/dv/dv_stream_server.hpp"

namespace tactile::capture {

struct CameraBroadcastOptions {
  microseconds packet_span{1'000};   ///< longest time within a packet, > 0
  std::size_t packet_events = 8192;  ///< most events per packet, > 0
};

/// What the servers received, with or without clients.
struct BroadcastCounts {
  std::uint64_t packets = 0;
  std::uint64_t events = 0;
  std::uint64_t imu_samples = 0;
  std::uint64_t triggers = 0;
  std::uint64_t frames = 0;
};

/// Sends a camera's streams to servers, in packets of limited span.
class CameraBroadcast {
 public:
  /// @throws Error  if an option is out of range
  explicit CameraBroadcast(CameraBroadcastOptions options = {});

  /// From now on `server` receives the stream, and must outlive this. A stream may have several servers.
  void add(std::int32_t stream_id, transport::DvStreamServer& server) { servers_.emplace(stream_id, &server); }

  /// Elements of a stream without server are dropped. @throws Error  as the server does
  void send(const CameraPacket& packet);

  const BroadcastCounts& counts() const { return counts_; }

 private:
  CameraBroadcastOptions options_;
  std::multimap<std::int32_t, transport::DvStreamServer*> servers_;
  BroadcastCounts counts_;
};

}  // namespace tactile::capture
