#include "tactile/core/in_order.hpp"

#include <cassert>
#include <utility>

namespace tactile {

void InOrder::later(std::size_t number, std::function<void()> step) {
  std::unique_lock lock(guard_);
  changed_.wait(lock, [&] { return failed_ || number < next_ + most_ahead_; });
  if (failed_) return;
  assert(number >= next_ && !waiting_.contains(number));
  waiting_.emplace(number, std::move(step));
  if (!executing_) execute(lock);  // else that thread executes this step too
}

bool InOrder::now(std::size_t number, std::function<void()> step) {
  std::unique_lock lock(guard_);
  changed_.wait(lock, [&] { return failed_ || (number == next_ && !executing_); });
  if (failed_) return false;
  waiting_.emplace(number, std::move(step));
  execute(lock);
  return true;
}

void InOrder::execute(std::unique_lock<std::mutex>& lock) {
  executing_ = true;
  while (!failed_ && !waiting_.empty() && waiting_.begin()->first == next_) {
    {
      const std::function<void()> ready = std::move(waiting_.extract(waiting_.begin()).mapped());
      lock.unlock();
      try {
        ready();
      } catch (...) {
        fail();
        throw;
      }
    }
    lock.lock();
    ++next_;
    changed_.notify_all();
  }
  executing_ = false;
  changed_.notify_all();
}

void InOrder::fail() {
  const std::scoped_lock lock(guard_);
  failed_ = true;
  changed_.notify_all();
}

}  // namespace tactile
