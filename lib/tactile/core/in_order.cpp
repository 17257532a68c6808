#include "tactile/core/in_order.hpp"

#include <utility>

namespace tactile {

void InOrder::later(std::size_t number, std::function<void()> step) {
  std::unique_lock lock(guard_);
  changed_.wait(lock, [&] { return failed_ || number < next_ + most_waiting_; });
  waiting_.emplace(number, std::move(step));
  if (executing_) return;  // that thread executes this step too
  executing_ = true;
  while (!failed_ && !waiting_.empty() && waiting_.begin()->first == next_) {
    const std::function<void()> ready = std::move(waiting_.extract(waiting_.begin()).mapped());
    lock.unlock();
    try {
      ready();
    } catch (...) {
      fail();
      throw;
    }
    lock.lock();
    ++next_;
    changed_.notify_all();
  }
  executing_ = false;
}

bool InOrder::now(std::size_t number, std::function<void()> step) {
  later(number, std::move(step));
  std::unique_lock lock(guard_);
  changed_.wait(lock, [&] { return failed_ || next_ > number; });
  return next_ > number;
}

void InOrder::fail() {
  const std::scoped_lock lock(guard_);
  failed_ = true;
  changed_.notify_all();
}

}  // namespace tactile
