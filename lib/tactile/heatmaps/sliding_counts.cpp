#include "tactile/heatmaps/sliding_counts.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <string>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/events/event_checks.hpp"

namespace tactile::heatmaps {
namespace {

// Larger than any event camera; a size from a file may have any value.
constexpr int most_in_a_row = 1 << 15;
constexpr std::int64_t most_pixels = std::int64_t{1} << 26;

std::uint64_t pixels_of(events::SensorSize size) {
  const bool is_sound = size.width > 0 && size.width <= most_in_a_row && size.height > 0 && size.height <= most_in_a_row;
  if (!is_sound || std::int64_t{size.width} * size.height > most_pixels) {
    throw Error("sensor of " + std::to_string(size.width) + "x" + std::to_string(size.height) + " px; expected 1 to " +
                std::to_string(most_in_a_row) + " in each direction, and " + std::to_string(most_pixels) + " pixels at most");
  }
  return static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
}

/// Reports the first event that goes back in time or lies outside the sensor. Any polarity is counted.
void refuse_unsound(std::span<const events::Event> events, CameraTime last, events::SensorSize size) {
  for (const events::Event& event : events) {
    if (event.t < last) {
      throw Error("events go back in time, from " + std::to_string(us_of(last)) + " us to " + std::to_string(us_of(event.t)) +
                  " us; expected ascending times");
    }
    if (event.x < 0 || event.x >= size.width || event.y < 0 || event.y >= size.height) {
      throw Error("an event at (" + std::to_string(event.x) + ", " + std::to_string(event.y) +
                  ") lies outside the sensor; expected one of " + std::to_string(size.width) + "x" + std::to_string(size.height) +
                  " px");
    }
    last = event.t;
  }
}

CellGrid on(events::SensorSize sensor, CellGrid grid) {
  grid.sensor = sensor;
  return grid;
}

}  // namespace

SlidingCounts::SlidingCounts(events::SensorSize size, microseconds history, const CellGrid& grid)
    : size_(size),
      history_(history),
      small_counts_(pixels_of(size)),
      large_counts_(small_counts_.size()),
      histogram_(static_cast<std::uint32_t>(small_counts_.size())),
      cells_(grid.read <= 15 ? Cells(CellCounts<std::uint8_t>(on(size, grid)))
                             : Cells(CellCounts<std::uint32_t>(on(size, grid)))),
      ring_(capacity_ + ahead) {
  if (history <= microseconds{0}) throw Error("history of " + std::to_string(history.count()) + " us; expected more than 0");
}

void SlidingCounts::add(std::span<const events::Event> events) {
  if (events.empty()) return;
  const events::EventsCheck check = events::check_events(events, size_);
  if (!check.inside || !check.ascending || events.front().t < last_) refuse_unsound(events, last_, size_);
  make_room(events.size());
  const auto width = static_cast<std::uint32_t>(size_.width);
  std::visit(
      [&](const auto& cells) {
        const auto append = [&](std::span<const events::Event> part) {
          Waiting* const place = &ring_[(front_ + given_) & (capacity_ - 1)];
          for (std::size_t i = 0; i < part.size(); ++i) {
            const events::Event& event = part[i];
            place[i] = {event.t, static_cast<std::uint32_t>(event.y) * width + static_cast<std::uint32_t>(event.x),
                        cells.place_of(event.x, event.y)};
          }
          given_ += part.size();
        };
        const std::size_t unbroken = std::min(events.size(), capacity_ - ((front_ + given_) & (capacity_ - 1)));
        append(events.first(unbroken));
        append(events.subspan(unbroken));
      },
      cells_);
  last_ = events.back().t;
}

void SlidingCounts::move_to(CameraTime tick) {
  if (tick < tick_) {
    throw Error("the window goes back in time, from " + std::to_string(us_of(tick_)) + " us to " + std::to_string(us_of(tick)) +
                " us; expected ticks in ascending order");
  }
  tick_ = tick;
  const std::size_t past = waiting_before(before(tick, history_), 0, given_);  // some may leave before they were counted
  change_counts<-1>(0, std::min(past, counted_));
  front_ = (front_ + past) & (capacity_ - 1);
  given_ -= past;
  counted_ -= std::min(past, counted_);
  const std::size_t in_window = waiting_before(tick, counted_, given_);
  change_counts<1>(counted_, in_window);
  counted_ = in_window;
  update_histogram();
}

/// The first waiting event in [from, to) that is not before `t`.
std::size_t SlidingCounts::waiting_before(CameraTime t, std::size_t from, std::size_t to) const {
  if (from == to || waiting(to - 1).t < t) return to;
  // It is usually near: a tick has few of the waiting events.
  std::size_t step = 64;
  while (from + step < to && waiting(from + step).t < t) from += step, step *= 2;
  to = std::min(to, from + step);
  while (from < to) {
    const std::size_t middle = from + (to - from) / 2;
    waiting(middle).t < t ? from = middle + 1 : to = middle;
  }
  return from;
}

void SlidingCounts::make_room(std::size_t events) {
  if (given_ + events <= capacity_) return;
  const std::size_t capacity = std::bit_ceil(given_ + events);
  std::vector<Waiting> larger(capacity + ahead);
  for (std::size_t i = 0; i < given_; ++i) larger[i] = waiting(i);
  ring_.swap(larger);
  capacity_ = capacity;
  front_ = 0;
}

/// Changes the counts of the events in [from, to) by 1 or -1.
template <int by>
void SlidingCounts::change_counts(std::size_t from, std::size_t to) {
  if (from == to) return;
  const std::size_t begin = (front_ + from) & (capacity_ - 1), length = to - from;
  const std::size_t unbroken = std::min(length, capacity_ - begin);
  const std::uint32_t any_count = std::visit(
      [&](auto& cells) {
        return change_counts_of<by>(std::span(ring_).subspan(begin, unbroken), cells) |
               change_counts_of<by>(std::span(ring_).first(length - unbroken), cells);
      },
      cells_);
  any_changed_ |= any_count;
}

/// Updates the histogram by the pixels that went from each low count to the next, minus those that returned.
void SlidingCounts::update_histogram() {
  const std::uint32_t end = std::bit_ceil(any_changed_ + 1);
  std::uint32_t from_below = 0;
  for (std::uint32_t count = 0; count < end; ++count) {
    const std::uint32_t upwards = std::exchange(changes_[count], 0);
    if (upwards != from_below) histogram_.add(count, from_below - upwards);
    from_below = upwards;
  }
  if (from_below != 0) histogram_.add(end, from_below);
  any_changed_ = 0;
  histogram_.settle();
}

/// @return  the lower of the counts before and after, or'ed
template <int by, class AnyCells>
std::uint32_t SlidingCounts::change_counts_of(std::span<const Waiting> events, AnyCells& cells) {
  const typename AnyCells::Change change_cell(cells);
  std::uint16_t* const small_counts = small_counts_.data();
  std::uint32_t* const changes = changes_.data();
  std::uint32_t any_count = 0;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Waiting& event = events[i];
    __builtin_prefetch(small_counts + events.data()[i + ahead].pixel, 1);  // may be beyond these events, but is inside the ring
    const std::uint32_t pixel = event.pixel, place = event.place, from = small_counts[pixel];
    if (from + (by > 0 ? 1 : 0) >= large) [[unlikely]] {  // the larger of the two counts
      change_high_count(pixel, by);
      continue;
    }
    assert((by > 0 || from > 0) && "only counted events leave the window");
    const std::uint32_t to = from + static_cast<std::uint32_t>(by);
    small_counts[pixel] = static_cast<std::uint16_t>(to);
    const std::uint32_t lower = by > 0 ? from : to;
    changes[lower] += static_cast<std::uint32_t>(by);
    any_count |= lower;
    change_cell(place, from, to);
  }
  return any_count;
}

/// The pixel belongs to the class `many` of its cell before and after.
void SlidingCounts::change_high_count(std::uint32_t pixel, int by) {
  const std::uint32_t from = small_counts_[pixel] < large ? small_counts_[pixel] : large_counts_[pixel];
  const std::uint32_t to = from + static_cast<std::uint32_t>(by);
  histogram_.move_one(from, to);
  small_counts_[pixel] = static_cast<std::uint16_t>(std::min<std::uint32_t>(to, large));
  if (std::max(from, to) >= large) large_counts_[pixel] = to;
}

}  // namespace tactile::heatmaps
