#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include "tactile/detect/reported_tick.hpp"

namespace tactile::detect {

/// Passes ticks from the thread that reports them to one that shows and writes them, which may be slow. Its size is bounded.
class TickLog {
 public:
  /// @param waits  whether `add` waits for room; else ticks without room are left out and counted
  TickLog(std::size_t limit, bool waits) : limit_(limit), waits_(waits) { ticks_.reserve(limit); }

  void add(const ReportedTick& tick) {
    std::unique_lock lock(guard_);
    if (waits_) emptied_.wait(lock, [this] { return closed_ || ticks_.size() < limit_; });
    if (ticks_.size() < limit_) {
      ticks_.push_back(tick);
    } else {
      ++left_out_;
    }
  }

  /// Replaces `ticks` by all ticks since the last call, and reuses its memory.
  void take(std::vector<ReportedTick>& ticks) {
    ticks.clear();
    ticks.reserve(limit_);
    {
      const std::scoped_lock lock(guard_);
      ticks.swap(ticks_);
    }
    emptied_.notify_all();
  }

  void close() {  ///< ends every wait for room
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
  std::vector<ReportedTick> ticks_;
  std::uint64_t left_out_ = 0;
  bool closed_ = false;
};

}  // namespace tactile::detect
