#include "tactile/features/sliding_sums.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"

namespace tactile::features {
namespace {

std::vector<std::uint16_t> parts_of(int pixels, std::size_t parts, std::size_t step) {
  std::vector<std::uint16_t> part(static_cast<std::size_t>(std::max(pixels, 0)));
  for (std::size_t i = 0; i < part.size(); ++i) part[i] = static_cast<std::uint16_t>(i * parts / part.size() * step);
  return part;
}

}  // namespace

SlidingSums::SlidingSums(events::SensorSize sensor, microseconds history, microseconds bin, const events::MaskPixels& mask)
    : history_(history),
      bin_(bin),
      waiting_(sensor, mask),
      column_of_(parts_of(sensor.width, grid_columns, 1)),
      row_of_(parts_of(sensor.height, grid_rows, grid_columns)) {
  if (bin <= microseconds{0} || history < bin || history % bin != microseconds{0} || history / bin > most_bins) {
    throw Error(fmt::format("a history of {} us in bins of {} us; expected a whole number of bins, 1 to {}", history.count(),
                            bin.count(), most_bins));
  }
  bins_.resize(static_cast<std::size_t>(history / bin));
}

void SlidingSums::count(const events::Event& event) {
  const auto since = static_cast<std::size_t>(between(before(tick_, history_), event.t) / bin_);
  EventSums& sums = bins_[(front_ + since) % bins_.size()];
  const std::size_t polarity = event.on != 0 ? 1 : 0;
  const auto x = static_cast<std::uint64_t>(event.x), y = static_cast<std::uint64_t>(event.y);
  EventSums::OfPolarity& of = sums.of[polarity];
  ++of.events;
  of.x += x, of.y += y, of.xx += x * x, of.yy += y * y, of.xy += x * y;
  ++sums.cells[polarity][column_of_[x] + std::size_t{row_of_[y]}];
}

void SlidingSums::move_to(CameraTime t) {
  if (t < tick_)
    throw Error(fmt::format("a tick at {} us after one at {} us; expected ticks in order of time", us_of(t), us_of(tick_)));
  if (us_of(t) % bin_.count() != 0)
    throw Error(fmt::format("a tick at {} us; expected a whole number of {} us", us_of(t), bin_.count()));
  const bool is_near = tick_ != CameraTime::min() && between(tick_, t) < history_;
  const std::size_t steps = is_near ? static_cast<std::size_t>(between(tick_, t) / bin_) : bins_.size();
  for (std::size_t step = 0; step < steps; ++step) {
    bins_[front_] = {};
    front_ = (front_ + 1) % bins_.size();
  }
  tick_ = t;
  const CameraTime begin = before(t, history_);
  for (const events::Event& event : waiting_.take_before(t)) {
    if (event.t >= begin) count(event);
  }
}

EventSums SlidingSums::sum(std::size_t first, std::size_t count) const {
  EventSums sum = bin(first);
  for (std::size_t k = first + 1; k < first + count; ++k) sum += bin(k);
  return sum;
}

std::uint64_t SlidingSums::events() const {
  std::uint64_t sum = 0;
  for (const EventSums& bin : bins_) sum += bin.of[0].events + bin.of[1].events;
  return sum;
}

}  // namespace tactile::features
