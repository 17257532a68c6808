#include "tactile/capture/packet_queue.hpp"

#include <algorithm>
#include <utility>

namespace tactile::capture {
namespace {

/// Packets given back between two checks for unneeded spare packets: half a minute of packets of 1 ms. Not less, because a
/// machine that was busy once may soon be busy again, and new memory is slow.
constexpr unsigned between_looks = 1U << 15;

std::size_t allocated_bytes(const QueuedPacket& packet) {
  const CameraPacket& e = packet.elements;
  return sizeof packet + e.events.capacity() * sizeof(events::Event) + e.imu.capacity() * sizeof(events::ImuSample) +
         e.triggers.capacity() * sizeof(events::Trigger) + (e.frame ? e.frame->pixels.capacity() : 0);
}

std::size_t used_bytes(const QueuedPacket& packet) {
  const CameraPacket& e = packet.elements;
  return sizeof packet + e.events.size() * sizeof(events::Event) + e.imu.size() * sizeof(events::ImuSample) +
         e.triggers.size() * sizeof(events::Trigger) + (e.frame ? e.frame->pixels.size() : 0);
}

}  // namespace

PacketQueue::Packet PacketQueue::take() {
  Packet packet;
  {
    const std::scoped_lock lock(guard_);
    if (!spare_.empty()) {
      spare_bytes_ -= allocated_bytes(spare_.front());
      packet.splice(packet.begin(), spare_, spare_.begin());
      never_taken_ = std::min(never_taken_, spare_.size());
      return packet;
    }
  }
  packet.emplace_back();
  ++made_;
  return packet;
}

bool PacketQueue::push(Packet& packet, bool wait, bool wakes) {
  std::size_t bytes = allocated_bytes(packet.front());
  // A buffer that held a burst may now hold a few samples. If room is short, it is shrunk.
  if (waiting_bytes() > limit_ / 4 && bytes > 2 * used_bytes(packet.front())) {
    CameraPacket& elements = packet.front().elements;
    elements.events.shrink_to_fit();
    elements.imu.shrink_to_fit();
    elements.triggers.shrink_to_fit();
    bytes = allocated_bytes(packet.front());
  }
  Packet surplus;  // freed after the lock is released
  std::unique_lock lock(guard_);
  const auto has_room = [&] { return waiting_.empty() || waiting_bytes_ + bytes <= limit_; };
  if (wait) emptied_.wait(lock, [&] { return !open_ || has_room(); });
  if (!open_ || !has_room()) return false;
  while (!spare_.empty() && waiting_bytes_ + spare_bytes_ + bytes > limit_) {
    spare_bytes_ -= allocated_bytes(spare_.back());
    surplus.splice(surplus.begin(), spare_, std::prev(spare_.end()));
    never_taken_ -= std::min<std::size_t>(never_taken_, 1);
  }
  waiting_bytes_ += bytes;
  waiting_.splice(waiting_.end(), packet);
  lock.unlock();
  if (wakes) filled_.notify_one();
  return true;
}

bool PacketQueue::pop(Packet& packet, std::chrono::microseconds patience) {
  std::unique_lock lock(guard_);
  filled_.wait_for(lock, patience, [&] { return !open_ || !waiting_.empty(); });
  if (waiting_.empty()) return open_;
  waiting_bytes_ -= allocated_bytes(waiting_.front());
  packet.splice(packet.begin(), waiting_, waiting_.begin());
  lock.unlock();
  emptied_.notify_all();
  return true;
}

void PacketQueue::give_back(Packet packet) {
  if (packet.empty()) return;
  packet.front().elements.clear();
  const std::size_t bytes = allocated_bytes(packet.front());
  Packet surplus;  // freed after the lock is released
  const std::scoped_lock lock(guard_);
  if (++given_back_ == between_looks) {
    for (; never_taken_ > 0; --never_taken_) {
      spare_bytes_ -= allocated_bytes(spare_.back());
      surplus.splice(surplus.begin(), spare_, std::prev(spare_.end()));
    }
    given_back_ = 0;
    never_taken_ = spare_.size();
  }
  if (waiting_bytes_ + spare_bytes_ + bytes > limit_) return;
  spare_bytes_ += bytes;
  spare_.splice(spare_.begin(), packet);
}

void PacketQueue::open() {
  const std::scoped_lock lock(guard_);
  open_ = true;
}

void PacketQueue::close() {
  {
    const std::scoped_lock lock(guard_);
    open_ = false;
  }
  filled_.notify_all();
  emptied_.notify_all();
}

bool PacketQueue::is_open() const {
  const std::scoped_lock lock(guard_);
  return open_;
}

}  // namespace tactile::capture
