#include "tactile/detect/recorded_copy.hpp"

#include <utility>

namespace tactile::detect {

RecordedCopy::RecordedCopy(capture::CameraSource& original, bool waits)
    : original_(original),
      waits_(waits),
      simulated_(original.simulated()),
      live_(original.live()),
      writes_files_(original.begins_again()),
      name_(original.name()),
      streams_(original.streams().begin(), original.streams().end()),
      camera_(original.camera()) {}

void RecordedCopy::put(const capture::CameraPacket& packet) {
  if (ended_early_) return;
  if (!packet.events.empty()) {
    if (last_event_ && packet.events.front().t < *last_event_) {
      ended_early_ = true;
      queue_.close();
      return;
    }
    last_event_ = packet.events.back().t;
  }
  capture::PacketQueue::Packet copy = queue_.take();
  copy.front().elements = packet;
  if (queue_.push(copy, waits_) || !queue_.is_open()) return;
  const capture::LostElements lost = capture::count_of(packet);
  const std::scoped_lock lock(guard_);
  lost_ += {.packets = lost.packets, .events = lost.events, .others = lost.others, .back_in_time = {}};
}

void RecordedCopy::end() { queue_.close(); }

capture::CameraSource::Received RecordedCopy::receive(capture::CameraPacket& packet, std::chrono::microseconds patience) {
  capture::PacketQueue::Packet next;
  if (!queue_.pop(next, patience)) return Received::ended;
  if (next.empty()) return Received::nothing;
  std::swap(packet, next.front().elements);
  queue_.give_back(std::move(next));
  return Received::packet;
}

capture::SourceDrops RecordedCopy::drops() const {
  const std::scoped_lock lock(guard_);
  return lost_;
}

void RecordedCopy::end_run(const RunFolder& run, bool wants_robot, bool wants_video) {
  if (writes_files_) original_.end_run(run, wants_robot, wants_video);
}

}  // namespace tactile::detect
