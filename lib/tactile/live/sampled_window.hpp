#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"

namespace tactile::live {

/// A stretch of a stream for someone who looks on.
///
/// One thread adds all events. It copies them only while a window is wanted; it allocates no memory and never waits. Another
/// thread wants windows, and reads them once they are full.
class SampledWindow {
 public:
  /// @param length       of a window, > 0
  /// @param most_events  after this many it ends earlier, > 0: memory and work stay bounded
  SampledWindow(microseconds length, std::size_t most_events);

  /// By the thread that adds. @param events  ascending in time. A step back from an earlier call begins the window again.
  void add(std::span<const events::Event> events);

  /// By the other thread: forgets the window, and wants the next one, which begins with the next event that is added.
  void want();
  void put_back() { state_.store(State::idle, std::memory_order_relaxed); }  ///< by the other thread, while it is full
  bool is_full() const { return state_.load(std::memory_order_acquire) == State::full; }

  // By the other thread, while it is full.
  std::span<const events::Event> events() const { return events_; }
  CameraTime end() const { return end_; }           ///< just after the window, of which all events are earlier
  microseconds length() const { return covered_; }  ///< less than wanted if there were too many events

 private:
  enum class State : std::uint8_t { idle, wanted, full };

  microseconds wanted_length_;
  std::size_t most_;
  std::vector<events::Event> events_;  ///< of the thread that adds while one is wanted, else of the other; so are the next two
  CameraTime end_{};
  microseconds covered_{};
  std::atomic<State> state_{State::idle};
};

}  // namespace tactile::live
