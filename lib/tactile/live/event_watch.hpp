#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "tactile/characterise/scene.hpp"
#include "tactile/events/event.hpp"
#include "tactile/live/sampled_window.hpp"

namespace tactile::live {

/// What a live page needs of a stream of events: their number, now and then the events of a history, and a second of them for the
/// scene. The thread that adds never waits.
class EventWatch {
 public:
  static constexpr std::size_t most_events = characterise::SceneWindow::most_events;

  /// @param history  of a picture, > 0
  explicit EventWatch(microseconds history)
      : picture_(history, most_events), scene_(characterise::SceneWindow::length, most_events) {}

  /// By one thread at a time. @param events  ascending in time; any may lie outside the sensor
  void add(std::span<const events::Event> events) {
    events_.fetch_add(events.size(), std::memory_order_relaxed);
    picture_.add(events);
    scene_.add(events);
  }

  std::uint64_t events() const { return events_.load(std::memory_order_relaxed); }  ///< since the start

  // For the thread that looks on.
  SampledWindow& picture() { return picture_; }
  SampledWindow& scene() { return scene_; }

 private:
  std::atomic<std::uint64_t> events_{0};
  SampledWindow picture_, scene_;
};

}  // namespace tactile::live
