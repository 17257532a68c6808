#include "tactile/detect/scene_watch.hpp"

#include <utility>

namespace tactile::detect {

SceneWatch::SceneWatch(SceneWatchOptions options, std::function<void(const characterise::SceneChange&)> report)
    : options_(std::move(options)), report_(std::move(report)), state_(options_.training) {
  summary_.training = options_.training;
}

void SceneWatch::add(std::span<const events::Event> events) {
  while (!events.empty() && !is_full_.load(std::memory_order_acquire)) {
    if (std::exchange(pauses_, false)) next_begin_ = after(events.front().t, options_.pause);
    if (next_begin_ && events.back().t < *next_begin_) return;
    next_begin_.reset();
    if (window_.events().empty()) lost_ = 0;
    events = events.subspan(window_.add(events));
    if (!window_.is_full()) return;
    is_full_.store(true, std::memory_order_release);
    if (options_.at_once) look();
  }
}

void SceneWatch::lose(std::uint64_t events) {
  if (!is_full_.load(std::memory_order_acquire)) lost_ += events;
}

void SceneWatch::restart() {
  if (is_full_.load(std::memory_order_acquire)) return;  // a full window is still of one stream
  window_.clear();
  lost_ = 0;
  pauses_ = false;
  next_begin_.reset();
}

void SceneWatch::look() {
  if (!is_full_.load(std::memory_order_acquire)) return;
  measure();
  is_full_.store(false, std::memory_order_release);
}

void SceneWatch::finish() {
  if (!is_full_ && window_.is_half_full()) measure();
  look();
}

void SceneWatch::measure() {
  constexpr std::uint64_t one_of = 20;
  if (one_of * lost_ > window_.events().size()) {
    ++summary_.skipped;
    return window_.clear();
  }
  const characterise::Scene scene = characterise::scene_of(window_.events(), window_.seconds(), options_.sensor, options_.mask);
  window_.clear();
  ++summary_.windows;
  summary_.last = scene;
  const auto change = state_.next(scene);
  pauses_ = !state_.is_undecided();
  summary_.is_outside = state_.is_outside();
  if (!change) return;
  ++(change->leaves ? summary_.left : summary_.returned);
  report_(*change);
}

}  // namespace tactile::detect
