#pragma once

#include <cstdint>

#include "tactile/capture/packet_queue.hpp"

namespace tactile {

/// Where a detector's packets come from, one after the other, for one thread.
class PacketSupply {
 public:
  virtual ~PacketSupply() = default;

  /// The next packet into `packet`, or none if none came within `patience`; false once there will be no more.
  /// @param rest  nothing that matters is expected so long: packets that come meanwhile may lie until then, since to wake up for
  ///              each is most of what a quiet scene takes; at most `patience`
  virtual bool next(PacketQueue::Packet& packet, microseconds patience, microseconds rest) = 0;

  virtual void give_back(PacketQueue::Packet packet) = 0;  ///< to be used again

  virtual std::uint64_t lost_events() const = 0;  ///< so far, for lack of room
};

}  // namespace tactile
