#pragma once

#include <cstdint>

#include "tactile/capture/packet_queue.hpp"

namespace tactile::detect {

/// A source of packets for a detector, used from one thread.
class PacketSupply {
 public:
  virtual ~PacketSupply() = default;

  /// Puts the next packet into `packet`, or none if none arrives within `patience`. False once there will be no more.
  /// @param rest  packets that arrive within this time can wait, which saves waking up for each of them; at most `patience`
  virtual bool next(capture::PacketQueue::Packet& packet, microseconds patience, microseconds rest) = 0;

  virtual void give_back(capture::PacketQueue::Packet packet) = 0;  ///< to reuse its memory

  virtual std::uint64_t lost_events() const = 0;  ///< so far, dropped for lack of room
};

}  // namespace tactile::detect
