#include "tactile/live/sampled_window.hpp"

#include <algorithm>

namespace tactile::live {

SampledWindow::SampledWindow(microseconds length, std::size_t most_events) : wanted_length_(length), most_(most_events) {
  events_.reserve(most_);
}

void SampledWindow::add(std::span<const events::Event> events) {
  if (events.empty() || state_.load(std::memory_order_acquire) != State::wanted) return;
  if (!events_.empty() && events.front().t < events_.back().t) events_.clear();
  if (events_.empty()) {
    covered_ = wanted_length_;
    end_ = after(events.front().t, wanted_length_);
  }
  const auto beyond =
      std::lower_bound(events.begin(), events.end(), end_, [](const events::Event& e, CameraTime t) { return e.t < t; });
  const auto here = static_cast<std::size_t>(beyond - events.begin());
  const std::size_t room = std::min(here, most_ - events_.size());
  events_.insert(events_.end(), events.begin(), events.begin() + static_cast<std::ptrdiff_t>(room));
  if (room < here) {
    // All events before that of the first one without room are there.
    end_ = events[room].t;
    while (!events_.empty() && events_.back().t >= end_) events_.pop_back();
    covered_ = events_.empty() ? microseconds{0} : between(events_.front().t, end_);
  } else if (beyond == events.end()) {
    return;
  }
  state_.store(State::full, std::memory_order_release);
}

void SampledWindow::want() {
  if (state_.load(std::memory_order_acquire) == State::wanted) return;
  events_.clear();
  state_.store(State::wanted, std::memory_order_release);
}

}  // namespace tactile::live
