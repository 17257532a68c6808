#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include "tactile/detect/live_detector.hpp"

namespace tactile {

/// Takes ticks from the thread that tells them to one that shows and writes them, which may take its time. Of bounded size.
class TickLog {
 public:
  /// @param waits  where it is full, until there is room; else what finds none is left out and counted
  TickLog(std::size_t limit, bool waits) : limit_(limit), waits_(waits) { ticks_.reserve(limit); }

  void add(const ToldTick& tick) {
    std::unique_lock lock(guard_);
    if (waits_) emptied_.wait(lock, [this] { return closed_ || ticks_.size() < limit_; });
    if (ticks_.size() < limit_) {
      ticks_.push_back(tick);
    } else {
      ++left_out_;
    }
  }

  /// All that came since, in place of what is in `ticks`, whose memory is used again.
  void take(std::vector<ToldTick>& ticks) {
    ticks.clear();
    ticks.reserve(limit_);
    {
      const std::scoped_lock lock(guard_);
      ticks.swap(ticks_);
    }
    emptied_.notify_all();
  }

  void close() {  ///< nobody waits any more
    {
      const std::scoped_lock lock(guard_);
      closed_ = true;
    }
    emptied_.notify_all();
  }

  std::uint64_t left_out() const {
    const std::scoped_lock lock(guard_);
    return left_out_;
  }

 private:
  const std::size_t limit_;
  const bool waits_;
  mutable std::mutex guard_;
  std::condition_variable emptied_;
  std::vector<ToldTick> ticks_;
  std::uint64_t left_out_ = 0;
  bool closed_ = false;
};

}  // namespace tactile
