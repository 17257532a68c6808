#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <list>
#include <mutex>

#include "tactile/capture/camera_source.hpp"
#include "tactile/core/time.hpp"

namespace tactile::capture {

/// A packet between its source and the file.
struct QueuedPacket {
  std::size_t source_index = 0;
  HostTime arrived{};
  CameraPacket elements;
};

/// Passes packets from the threads that receive them to the one that writes them. Its memory is bounded: a packet counts with the
/// whole capacity of its buffers, and a packet without room is rejected. Empty packets are reused, so that nothing is allocated
/// after a while. Packets of a burst that were not needed for about ten thousand packets are freed. Elements are never copied: a
/// packet moves as a node of a list.
class PacketQueue {
 public:
  using Packet = std::list<QueuedPacket>;  ///< one packet or none

  explicit PacketQueue(std::size_t limit) : limit_(limit) {}  ///< of waiting packets and of those kept for reuse [B]

  Packet take();  ///< an empty packet to fill

  /// Moves `packet` into the queue. A packet larger than the limit is accepted if no other packet waits.
  /// @param wait   wait for room
  /// @param wakes  wake the thread that waits in `pop`
  /// @return       false if there is no room, or the queue is closed: `packet` stays with the caller
  bool push(Packet& packet, bool wait, bool wakes = true);

  /// Puts the next packet into `packet`, or none if none arrives within `patience`. False once the queue is closed and empty.
  bool pop(Packet& packet, std::chrono::microseconds patience);

  void give_back(Packet packet);  ///< for reuse

  void open();
  void close();  ///< accepts no further packets, and ends waits for room; waiting packets can still be taken
  bool is_open() const;

  std::size_t waiting_bytes() const { return waiting_bytes_.load(std::memory_order_relaxed); }
  std::uint64_t packets_made() const {
    return made_.load(std::memory_order_relaxed);
  }  ///< in total, because none could be reused
  std::size_t limit() const { return limit_; }

 private:
  std::size_t limit_;
  mutable std::mutex guard_;
  std::condition_variable filled_, emptied_;
  std::list<QueuedPacket> waiting_, spare_;
  std::atomic<std::size_t> waiting_bytes_{0};
  std::size_t spare_bytes_ = 0;
  std::size_t never_taken_ = 0;  ///< spare packets at the end of the list that were not needed since the last check
  unsigned given_back_ = 0;      ///< since the last check
  std::atomic<std::uint64_t> made_{0};
  bool open_ = true;
};

}  // namespace tactile::capture
