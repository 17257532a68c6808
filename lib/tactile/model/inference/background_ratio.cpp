#include "tactile/model/inference/background_ratio.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "tactile/core/error.hpp"
#include "tactile/core/infinite.hpp"

namespace tactile::model {
namespace {

constexpr int cell_side = 80, longest_side = 1 << 15, most_cells_across = 250;
constexpr double least_background = 0.05, surely_moving = 8, memory_steps = 500;
constexpr double active_share = 0.1;
constexpr std::size_t steps_per_sample = 10, samples = BackgroundRatio::steps_to_know, enough_moving = samples * 9 / 10;
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
  const std::size_t columns = column_.back() + std::size_t{1};
  for (int y = 0; y < sensor.height; ++y)
    first_of_row_.push_back(static_cast<std::uint16_t>(static_cast<std::size_t>(y / side) * columns));
  cells_ = first_of_row_.back() + columns;
  background_.resize(cells_);
  halvings_.resize(cells_);
  rest_.resize(cells_);
  none_.resize(cells_);
  samples_.resize(cells_ * samples);
  moving_.resize(samples);
  const std::int64_t steps = std::max<std::int64_t>(1, (history.count() + step_us - 1) / step_us);
  recent_.assign(static_cast<std::size_t>(steps), infinite);
}

void BackgroundRatio::add(std::span<const events::Event> events) {
  for (std::span<const events::Event> left = mask_.without(events, unmasked_); !left.empty();) {
    if (ahead_.empty() || left.front().t >= end_of_last_) begin_step(left.front().t);
    const auto in_step = [this](const events::Event& event) { return event.t < end_of_last_; };
    // The first belongs to it, even at the end of the clock.
    const auto end = in_step(left.back()) ? left.end() : std::partition_point(left.begin() + 1, left.end(), in_step);
    const auto count = static_cast<std::size_t>(end - left.begin());
    std::uint32_t* const counts = ahead_.back().counts.data();
    const auto take = [counts, rows = first_of_row_.data(), columns = column_.data()](const events::Event& event) {
      ++counts[std::uint32_t{rows[static_cast<std::uint16_t>(event.y)]} + columns[static_cast<std::uint16_t>(event.x)]];
    };
    const events::Event *event = left.data(), *const last = event + count;
    for (; last - event >= 4; event += 4) take(event[0]), take(event[1]), take(event[2]), take(event[3]);
    for (; event != last; ++event) take(*event);
    left = left.subspan(count);
  }
}

/// Begins the step of `t`, with the memory of an earlier one if there is any.
void BackgroundRatio::begin_step(CameraTime t) {
  std::vector<std::uint32_t> counts;
  if (!unused_.empty()) {
    counts.swap(unused_.back());
    unused_.pop_back();
  }
  counts.assign(cells_, 0);
  ahead_.push_back(Step{step_at(t), std::move(counts)});
  const std::int64_t into_step = us_of(t) % step_us;
  end_of_last_ = after(t, microseconds{step_us - (into_step < 0 ? into_step + step_us : into_step)});
}

double BackgroundRatio::at(CameraTime t) {
  const std::int64_t end = step_at(t);
  if (!begun_ && ahead_.empty()) next_ = end;
  if (!begun_ && !ahead_.empty()) {
    next_ = ahead_.front().index + 1;  // the first step is not whole
    unused_.push_back(std::move(ahead_.front().counts));
    ahead_.pop_front();
  }
  begun_ = true;
  while (next_ < end) {
    if (!ahead_.empty() && ahead_.front().index == next_) {
      take(ahead_.front().counts);
      unused_.push_back(std::move(ahead_.front().counts));
      ahead_.pop_front();
      ++next_;
    } else {
      skip_silence(ahead_.empty() ? end : std::min(end, ahead_.front().index));
    }
  }
  return is_known() ? largest() : infinite;
}

double BackgroundRatio::largest() const { return *std::max_element(recent_.begin(), recent_.end()); }

double BackgroundRatio::latest() const { return is_known() ? recent_[(place_ == 0 ? recent_.size() : place_) - 1] : infinite; }

/// Takes the empty steps before `end`. Beyond ten times the background's memory they change nothing any more.
void BackgroundRatio::skip_silence(std::int64_t end) {
  constexpr auto enough = static_cast<std::int64_t>(10 * memory_steps);
  for (std::int64_t i = std::min(end - next_, enough); i > 0; --i) take(none_);
  next_ = end;
}

void BackgroundRatio::take(std::span<const std::uint32_t> counts) {
  if (!is_known()) {
    sample(counts);
    if (++seen_ == steps_to_know) take_median();
    return;
  }
  recent_[place_] = ratio_of(counts);
  place_ = place_ + 1 < recent_.size() ? place_ + 1 : 0;
  if (until_sample_-- > 0) return;
  until_sample_ = steps_per_sample - 1;
  const bool moves = largest() >= surely_moving;
  moving_count_ += moves;
  moving_count_ -= moving_[sample_place_];
  moving_[sample_place_] = moves;
  sample(counts);
  if (!moves) learn(counts);
  if (moving_count_ >= enough_moving) take_median();
}

void BackgroundRatio::sample(std::span<const std::uint32_t> counts) {
  std::copy(counts.begin(), counts.end(), samples_.begin() + static_cast<std::ptrdiff_t>(sample_place_ * cells_));
  sample_place_ = sample_place_ + 1 < samples ? sample_place_ + 1 : 0;
}

/// The background becomes the median of the samples.
void BackgroundRatio::take_median() {
  std::array<std::uint32_t, samples> of_cell{};
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    for (std::size_t i = 0; i < samples; ++i) of_cell[i] = samples_[i * cells_ + cell];
    // As `value_of_rank`, but in place: that copies into new memory, here for every cell in the time between two ticks.
    std::nth_element(of_cell.begin(), of_cell.begin() + samples / 2, of_cell.end());
    set_background(cell, static_cast<double>(of_cell[samples / 2]));
  }
  std::fill(moving_.begin(), moving_.end(), std::uint8_t{0});
  moving_count_ = 0;
}

void BackgroundRatio::learn(std::span<const std::uint32_t> counts) {
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    const double m = background_[cell];
    set_background(cell, m + steps_per_sample * std::min(counts[cell] - m, 2 * std::sqrt(m + 1)) / memory_steps);
  }
}

void BackgroundRatio::set_background(std::size_t cell, double events) {
  background_[cell] = std::max(least_background, events);
  const double bits = background_[cell] / std::numbers::ln2;
  halvings_[cell] = static_cast<std::int64_t>(bits);
  rest_[cell] = std::exp2(static_cast<double>(halvings_[cell]) - bits);
}

double BackgroundRatio::ratio_of(std::span<const std::uint32_t> counts) const {
  constexpr std::size_t together = 48;  // factors of 2^20 fit in a double
  double sum = 0;
  for (std::size_t first = 0; first < cells_; first += together) {
    double product = 1;
    for (std::size_t cell = first; cell < std::min(first + together, cells_); ++cell) {
      const std::int64_t doublings =
          std::clamp<std::int64_t>(counts[cell] - halvings_[cell], least_doublings, most_doublings + 1);
      const double ratio = std::min(rest_[cell] * powers[static_cast<std::size_t>(doublings - least_doublings)], 0x1p20);
      product *= (1 - active_share) + active_share * ratio;
    }
    sum += std::log(product);
  }
  return sum;
}

std::vector<double> opening_ratios(events::RecordingReader& recording, std::span<const TouchInterval> intervals,
                                   const heatmaps::HeatmapOptions& rendering) {
  static constexpr microseconds in_time{10'000};
  const events::Stream& stream = events::event_stream(recording);
  BackgroundRatio ratio(stream.size.value_or(events::SensorSize{}), rendering.history, rendering.mask);
  const auto last_step_of = [](const TouchInterval& interval) {
    return step_at(std::min(interval.end, after(interval.start, in_time)));
  };
  std::map<std::int64_t, double> at_end_of;  // the ratio of the step that ends at this many steps
  for (const TouchInterval& interval : intervals) {
    for (std::int64_t end = step_at(interval.start) + 1; end <= last_step_of(interval); ++end) at_end_of[end] = infinite;
  }
  auto next = at_end_of.begin();
  events::for_all_events(recording, stream.id, [&](std::span<const events::Event> events) {
    if (events.empty()) return;
    ratio.add(events);
    for (; next != at_end_of.end() && camera_time(next->first * BackgroundRatio::step_us) <= events.back().t; ++next) {
      ratio.at(camera_time(next->first * BackgroundRatio::step_us));
      next->second = ratio.latest();
    }
  });
  std::vector<double> ratios;
  for (const TouchInterval& interval : intervals) {
    double best = -infinite;
    for (std::int64_t end = step_at(interval.start) + 1; end <= last_step_of(interval); ++end)
      best = std::max(best, at_end_of[end]);
    if (std::isfinite(best)) ratios.push_back(best);
  }
  return ratios;
}

}  // namespace tactile::model
