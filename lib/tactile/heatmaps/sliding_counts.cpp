#include "tactile/heatmaps/sliding_counts.hpp"

#include <cassert>
#include <string>

#include "tactile/core/error.hpp"

namespace tactile {
namespace {

constexpr std::int64_t most_pixels = std::int64_t{1}
                                     << 26;  // no event camera comes near; a size read from a file may be anything

}  // namespace

SlidingCounts::SlidingCounts(SensorSize size, microseconds history) : size_(size), history_(history) {
  if (size.width <= 0 || size.height <= 0 || std::int64_t{size.width} * size.height > most_pixels) {
    throw Error("sensor of " + std::to_string(size.width) + "x" + std::to_string(size.height) + " px; expected 1 to " +
                std::to_string(most_pixels) + " pixels");
  }
  if (history <= microseconds{0}) throw Error("history of " + std::to_string(history.count()) + " us; expected more than 0");
  counts_.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
  place_in_active_.resize(counts_.size());
}

void SlidingCounts::add(std::span<const Event> events) {
  CameraTime last = last_;
  for (const Event& event : events) {
    if (event.t < last) {
      throw Error("events go back in time, from " + std::to_string(us_of(last)) + " us to " + std::to_string(us_of(event.t)) +
                  " us; expected them in ascending order");
    }
    if (event.x < 0 || event.x >= size_.width || event.y < 0 || event.y >= size_.height) {
      throw Error("an event at (" + std::to_string(event.x) + ", " + std::to_string(event.y) +
                  ") lies outside the sensor; expected one of " + std::to_string(size_.width) + "x" +
                  std::to_string(size_.height) + " px");
    }
    last = event.t;
  }
  for (const Event& event : events) waiting_.push_back({event.t, static_cast<std::uint32_t>(index(event.x, event.y))});
  last_ = last;
}

void SlidingCounts::move_to(CameraTime tick) {
  if (tick < tick_) {
    throw Error("the window goes back in time, from " + std::to_string(us_of(tick_)) + " us to " + std::to_string(us_of(tick)) +
                " us; expected ticks in ascending order");
  }
  tick_ = tick;
  const CameraTime begin = before(tick, history_);
  while (!waiting_.empty() && waiting_.front().t < begin) {
    if (counted_ > 0) {
      forget(waiting_.front().pixel);
      --counted_;
    }
    waiting_.pop_front();
  }
  for (; counted_ < waiting_.size() && waiting_[counted_].t < tick; ++counted_) count(waiting_[counted_].pixel);
}

void SlidingCounts::count(std::uint32_t pixel) {
  if (counts_[pixel]++ == 0) {
    place_in_active_[pixel] = static_cast<std::uint32_t>(active_.size());
    active_.push_back(pixel);
  }
  ++in_window_;
}

void SlidingCounts::forget(std::uint32_t pixel) {
  assert(counts_[pixel] > 0 && "only what was counted is forgotten");
  if (--counts_[pixel] == 0) {
    const std::uint32_t place = place_in_active_[pixel];
    active_[place] = active_.back();
    place_in_active_[active_[place]] = place;
    active_.pop_back();
  }
  --in_window_;
}

}  // namespace tactile
