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

namespace tactile {

/// A packet on its way from its source to the file.
struct QueuedPacket {
  std::size_t source_index = 0;
  HostTime arrived{};
  CameraPacket elements;
};

/// Takes packets from the threads that receive them to the one that writes them. Its memory is bounded: a packet counts with all
/// that its buffers have allocated, and one that finds no room is refused. Emptied packets are used again, so that once it is
/// warm nothing is allocated; those that nobody needed for some ten thousand packets, since a burst left them behind, are freed.
/// Elements are never copied: a packet moves as a node of a list.
class PacketQueue {
 public:
  using Packet = std::list<QueuedPacket>;  ///< one packet; or none

  explicit PacketQueue(std::size_t limit) : limit_(limit) {}  ///< of those that wait and those kept for later [B]

  Packet take();  ///< an empty packet to fill

  /// True, and `packet` is gone, if there was room. With `wait` it waits for room. One larger than the limit goes in if nothing
  /// else waits. False: it is still the caller's, for lack of room or because the queue is closed.
  /// @param wakes  whoever waits for packets; else it is found when they look
  bool push(Packet& packet, bool wait, bool wakes = true);

  /// The next packet into `packet`, or none if none came within `patience`; false once the queue is closed and empty.
  bool pop(Packet& packet, std::chrono::microseconds patience);

  void give_back(Packet packet);  ///< to be taken again

  void open();
  void close();  ///< nothing goes in any more, nobody waits for room; what is in it can still be taken out
  bool is_open() const;

  std::size_t waiting_bytes() const { return waiting_bytes_.load(std::memory_order_relaxed); }
  std::uint64_t packets_made() const {
    return made_.load(std::memory_order_relaxed);
  }  ///< ever, because none could be used again
  std::size_t limit() const { return limit_; }

 private:
  std::size_t limit_;
  mutable std::mutex guard_;
  std::condition_variable filled_, emptied_;
  std::list<QueuedPacket> waiting_, spare_;
  std::atomic<std::size_t> waiting_bytes_{0};
  std::size_t spare_bytes_ = 0;
  std::size_t never_taken_ = 0;  ///< of the spare ones, those at the end, since the last look at them
  unsigned given_back_ = 0;      ///< likewise
  std::atomic<std::uint64_t> made_{0};
  bool open_ = true;
};

}  // namespace tactile
