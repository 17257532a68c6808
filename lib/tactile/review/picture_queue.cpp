#include "tactile/review/picture_queue.hpp"

namespace tactile::review {

PictureQueue::PictureQueue(Draw draw) : draw_(std::move(draw)), thread_([this] { work(); }) {}

PictureQueue::~PictureQueue() {
  {
    const std::scoped_lock lock(guard_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void PictureQueue::draw(const RunFolder& run, const labels::Labels& labels) {
  if (!draw_) return;
  {
    const std::scoped_lock lock(guard_);
    waiting_[run.name()] = {run, labels};
  }
  changed_.notify_all();
}

void PictureQueue::work() {
  std::unique_lock lock(guard_);
  while (true) {
    changed_.wait(lock, [&] { return ends_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const Waiting next = std::move(waiting_.begin()->second);
    waiting_.erase(waiting_.begin());
    lock.unlock();
    draw_(next.run, next.labels);
    lock.lock();
  }
}

}  // namespace tactile::review
