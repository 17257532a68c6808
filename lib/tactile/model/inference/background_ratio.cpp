#include "tactile/model/inference/background_ratio.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "tactile/core/error.hpp"

namespace tactile::model {
namespace {

constexpr int cell_side = 80, longest_side = 1 << 15, most_cells_across = 250;
constexpr double least_background = 0.05, surely_moving = 8, memory_steps = 500;
constexpr double active_share = 0.1;
constexpr std::size_t steps_per_lesson = 8;
constexpr std::int64_t most_doublings = 20, least_doublings = -60;

/// 2^(least_doublings + i)
constexpr auto powers = [] {
  std::array<double, most_doublings - least_doublings + 2> values{};
  double power = 1;
  for (std::int64_t i = 0; i > least_doublings; --i) power /= 2;
  for (double& value : values) value = power, power *= 2;
  return values;
}();

std::int64_t step_at(CameraTime t) {
  const std::int64_t us = us_of(t);
  return us / BackgroundRatio::step_us - (us % BackgroundRatio::step_us < 0 ? 1 : 0);
}

/// Cells are larger on sensors of more than 250 cells along a side.
int side_for(events::SensorSize sensor) {
  return std::max(cell_side, (std::max(sensor.width, sensor.height) + most_cells_across - 1) / most_cells_across);
}

}  // namespace

BackgroundRatio::BackgroundRatio(events::SensorSize sensor, microseconds history, const events::MaskPixels& mask)
    : mask_(sensor, mask) {
  if (sensor.width < 1 || sensor.height < 1 || std::max(sensor.width, sensor.height) > longest_side) {
    throw Error(fmt::format("background: a sensor of {} x {} px; expected 1 to {} in each direction", sensor.width, sensor.height,
                            longest_side));
  }
  const int side = side_for(sensor);
  for (int x = 0; x < sensor.width; ++x) column_.push_back(static_cast<std::uint8_t>(x / side));
  for (int y = 0; y < sensor.height; ++y) row_.push_back(static_cast<std::uint8_t>(y / side));
  columns_ = column_.back() + std::size_t{1};
  cells_ = columns_ * (row_.back() + std::size_t{1});
  background_.resize(cells_);
  halvings_.resize(cells_);
  rest_.resize(cells_);
  none_.resize(cells_);
  first_.reserve(cells_ * steps_to_know);
  const std::int64_t steps = std::max<std::int64_t>(1, (history.count() + step_us - 1) / step_us);
  recent_.assign(static_cast<std::size_t>(steps), 0.0);
}

void BackgroundRatio::add(std::span<const events::Event> events) {
  Step* step = ahead_.empty() ? nullptr : &ahead_.back();
  CameraTime end = step != nullptr ? camera_time((step->index + 1) * step_us) : CameraTime::min();
  for (const events::Event& event : mask_.without(events, unmasked_)) {
    if (step == nullptr || event.t >= end) {
      std::vector<std::uint32_t> counts;
      if (!unused_.empty()) {
        counts.swap(unused_.back());
        unused_.pop_back();
      }
      counts.assign(cells_, 0);
      step = &ahead_.emplace_back(Step{step_at(event.t), std::move(counts)});
      end = camera_time((step->index + 1) * step_us);
    }
    ++step->counts[row_[static_cast<std::size_t>(event.y)] * columns_ + column_[static_cast<std::size_t>(event.x)]];
  }
}

double BackgroundRatio::at(CameraTime t) {
  const std::int64_t end = step_at(t);
  if (!begun_ && !ahead_.empty()) {
    begun_ = true;
    next_ = ahead_.front().index + 1;  // the first step is not whole
    unused_.push_back(std::move(ahead_.front().counts));
    ahead_.pop_front();
  }
  while (begun_ && next_ < end) {
    if (!ahead_.empty() && ahead_.front().index == next_) {
      take(ahead_.front().counts);
      unused_.push_back(std::move(ahead_.front().counts));
      ahead_.pop_front();
      ++next_;
    } else {
      skip_silence(ahead_.empty() ? end : std::min(end, ahead_.front().index));
    }
  }
  return is_known() ? *std::max_element(recent_.begin(), recent_.end()) : std::numeric_limits<double>::infinity();
}

/// Takes the empty steps before `end`. Beyond ten times the background's memory they change nothing any more.
void BackgroundRatio::skip_silence(std::int64_t end) {
  constexpr auto enough = static_cast<std::int64_t>(10 * memory_steps);
  for (std::int64_t i = std::min(end - next_, enough); i > 0; --i) take(none_);
  next_ = end;
}

void BackgroundRatio::take(std::span<const std::uint32_t> counts) {
  if (!is_known()) {
    first_.insert(first_.end(), counts.begin(), counts.end());
    if (++seen_ == steps_to_know) know();
    return;
  }
  const double ratio = ratio_of(counts);
  recent_[place_] = ratio;
  place_ = place_ + 1 < recent_.size() ? place_ + 1 : 0;
  if (until_learning_ > 0) {
    --until_learning_;
  } else if (*std::max_element(recent_.begin(), recent_.end()) < surely_moving) {
    learn(counts);
    until_learning_ = steps_per_lesson - 1;
  }
}

void BackgroundRatio::know() {
  std::array<std::uint32_t, steps_to_know> of_cell{};
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    for (std::size_t i = 0; i < steps_to_know; ++i) of_cell[i] = first_[i * cells_ + cell];
    std::nth_element(of_cell.begin(), of_cell.begin() + steps_to_know / 2, of_cell.end());
    set_background(cell, static_cast<double>(of_cell[steps_to_know / 2]));
  }
  first_ = {};
}

void BackgroundRatio::learn(std::span<const std::uint32_t> counts) {
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    const double m = background_[cell], widest = 2 * std::sqrt(m + 1);
    set_background(cell, m + steps_per_lesson * std::clamp(counts[cell] - m, -widest, widest) / memory_steps);
  }
}

void BackgroundRatio::set_background(std::size_t cell, double events) {
  background_[cell] = std::max(least_background, events);
  const double bits = background_[cell] / std::numbers::ln2;
  halvings_[cell] = static_cast<std::int64_t>(bits);
  rest_[cell] = std::exp2(static_cast<double>(halvings_[cell]) - bits);
}

double BackgroundRatio::ratio_of(std::span<const std::uint32_t> counts) const {
  double sum = 0, product = 1;
  std::size_t factors = 0;
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    const std::int64_t doublings = std::clamp<std::int64_t>(counts[cell] - halvings_[cell], least_doublings, most_doublings + 1);
    const double ratio = std::min(rest_[cell] * powers[static_cast<std::size_t>(doublings - least_doublings)], 0x1p20);
    product *= (1 - active_share) + active_share * ratio;
    if (++factors < 48) continue;  // 48 factors of 2^20 fit in a double
    sum += std::log(product);
    product = 1;
    factors = 0;
  }
  return sum + std::log(product);
}

std::vector<double> opening_ratios(events::RecordingReader& recording, std::span<const TouchInterval> intervals,
                                   const heatmaps::HeatmapOptions& rendering) {
  constexpr microseconds in_time{10'000};
  const events::Stream& stream = events::event_stream(recording);
  // With a history of one step, a value is the ratio of that step.
  BackgroundRatio ratio(stream.size.value_or(events::SensorSize{}), microseconds{BackgroundRatio::step_us}, rendering.mask);
  std::vector<std::optional<double>> best(intervals.size());
  std::optional<CameraTime> next;
  const auto take_until = [&](CameraTime last) {
    for (; *next <= last; *next += microseconds{BackgroundRatio::step_us}) {
      const double value = ratio.at(*next);
      for (std::size_t i = 0; i < intervals.size() && ratio.is_known(); ++i) {
        const CameraTime end = std::min(intervals[i].end, after(intervals[i].start, in_time));
        if (*next > intervals[i].start && *next <= end) best[i] = std::max(best[i].value_or(value), value);
      }
    }
  };
  events::for_all_events(recording, stream.id, [&](std::span<const events::Event> events) {
    if (events.empty()) return;
    if (!next) next = camera_time((step_at(events.front().t) + 1) * BackgroundRatio::step_us);
    ratio.add(events);
    take_until(events.back().t);
  });
  std::vector<double> ratios;
  for (const std::optional<double>& value : best) {
    if (value && std::isfinite(*value)) ratios.push_back(*value);
  }
  return ratios;
}

}  // namespace tactile::model
