#include "tactile/capture/receiver.hpp"

#include <exception>
#include <utility>

#include "tactile/core/host_clock.hpp"

namespace tactile::capture {
namespace {

constexpr std::chrono::milliseconds source_patience{50};  // after which the thread checks for a task

}  // namespace

Receiver::Receiver(std::unique_ptr<CameraSource> source, std::size_t index, PacketQueue& queue,
                   std::function<void(const CameraPacket&)> see)
    : source_(std::move(source)),
      index_(index),
      queue_(queue),
      name_(source_->name()),
      live_(source_->live()),
      begins_again_(source_->begins_again()),
      see_(std::move(see)),
      thread_([this] { receive_all(); }) {}

Receiver::~Receiver() {
  {
    const std::scoped_lock lock(guard_);
    stops_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Receiver::discard() {
  ask([this] { discards_ = true; });
}

void Receiver::begin(const RunFolder& run) {
  ask([&] {
    source_->begin_run(run);
    const std::scoped_lock lock(guard_);
    if (error_.empty() && begins_again_) ended_at_.reset();
    queue_full_ = {};
    drops_at_begin_ = drops_now_ = source_->drops();
    hands_over_ = true;
  });
}

nlohmann::json Receiver::camera() {
  nlohmann::json camera;
  ask([&] { camera = source_->camera(); });
  return camera;
}

void Receiver::end(const RunFolder& run, bool wants_robot, bool wants_video) {
  ask([&] { source_->end_run(run, wants_robot, wants_video); });
}

void Receiver::pause() {
  discards_ = true;
  hands_over_ = false;
}

std::optional<HostTime> Receiver::ended_at() const {
  const std::scoped_lock lock(guard_);
  return ended_at_;
}

std::string Receiver::error() const {
  const std::scoped_lock lock(guard_);
  return error_;
}

void Receiver::add_drops(RunDrops& drops) const {
  const std::scoped_lock lock(guard_);
  drops.queue_full += queue_full_;
  const LostElements back_in_time = drops_now_.back_in_time - drops_at_begin_.back_in_time;
  drops.back_in_time += back_in_time;
  drops.source += drops_now_.total() - drops_at_begin_.total() - back_in_time;
}

/// Runs `task` on the source's thread, between two packets. @throws  what it throws
void Receiver::ask(std::function<void()> task) {
  std::packaged_task<void()> asked(std::move(task));
  std::future<void> done = asked.get_future();
  {
    const std::scoped_lock lock(guard_);
    task_ = std::move(asked);
    has_task_ = true;
  }
  wake_.notify_all();
  done.get();
}

/// Whether the thread must not receive now. Before the first `discard` or `begin` a source keeps its packets; between two runs
/// only a source that is not live does.
bool Receiver::rests() const { return !hands_over_ && !(live_ && discards_); }

/// Runs a task, if any; waits for one if there is nothing to receive. @return  false once the thread must end
bool Receiver::do_what_is_asked() {
  std::unique_lock lock(guard_);
  if (ended_at_ || rests()) wake_.wait(lock, [this] { return stops_ || has_task_; });
  if (has_task_) {
    std::packaged_task<void()> task = std::move(task_);
    has_task_ = false;
    lock.unlock();
    task();
    lock.lock();
  }
  return !stops_;
}

void Receiver::receive_all() {
  PacketQueue::Packet packet = queue_.take();
  while (do_what_is_asked()) {
    if (ended_at() || rests()) continue;
    CameraPacket& elements = packet.front().elements;
    elements.clear();
    const bool of_run = hands_over_;  // losses before a run's end count for the run, even if it ends during this wait
    try {
      switch (source_->receive(elements, source_patience)) {
        case CameraSource::Received::packet:
          packets_.fetch_add(1, std::memory_order_relaxed);
          if (see_) see_(elements);
          if (hands_over_) hand_over(packet);
          break;
        case CameraSource::Received::nothing:
          break;
        case CameraSource::Received::ended:
          note_end("");
          break;
      }
    } catch (const std::exception& e) {
      note_end(e.what());
    }
    if (of_run) note_drops();
  }
}

void Receiver::hand_over(PacketQueue::Packet& packet) {
  packet.front().source_index = index_;
  packet.front().arrived = packet.front().elements.arrived.value_or(host_now());
  const LostElements count = count_of(packet.front().elements);
  const bool taken = queue_.push(packet, !live_);
  if (taken) packet = queue_.take();
  if (taken || !hands_over_) return;
  const std::scoped_lock lock(guard_);
  queue_full_ += count;
}

void Receiver::note_end(const std::string& error) {
  const std::scoped_lock lock(guard_);
  ended_at_ = host_now();
  error_ = error;
}

void Receiver::note_drops() {
  const SourceDrops drops = source_->drops();
  if (drops == drops_now_) return;  // only this thread changes it
  const std::scoped_lock lock(guard_);
  drops_now_ = drops;
}

}  // namespace tactile::capture
