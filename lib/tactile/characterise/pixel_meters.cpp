#include "tactile/characterise/pixel_meters.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tactile::characterise {

NeighbourMeter::NeighbourMeter(events::SensorSize size, std::vector<bool> ordinary)
    : width_(static_cast<std::size_t>(size.width)),
      height_(static_cast<std::size_t>(size.height)),
      ordinary_(std::move(ordinary)) {
  counts_.resize(width_ * height_);
  totals_.resize(counts_.size());
}

void NeighbourMeter::end_tick(std::int64_t next) {
  if (parts_.empty()) parts_.emplace_back();
  Part& part = parts_.back();
  for (const std::size_t pixel : fired_) {
    const double n = counts_[pixel];
    part.squares += n * n;
    if ((pixel + 1) % width_ != 0) part.horizontal += n * counts_[pixel + 1];  // an unusual pixel has no counts here
    if (pixel + width_ < counts_.size()) part.vertical += n * counts_[pixel + width_];
  }
  for (const std::size_t pixel : fired_) counts_[pixel] = 0;
  fired_.clear();
  part.ticks += static_cast<double>(next - tick_);
  tick_ = next;
}

void NeighbourMeter::end_recording(std::int64_t ticks) {
  end_tick(std::max(ticks, tick_ + 1));
  ticks_ += static_cast<double>(tick_);
  tick_ = 0;
}

Neighbours NeighbourMeter::neighbours() const {
  double squares = 0, horizontal = 0, vertical = 0, pixels = 0, horizontal_pairs = 0, vertical_pairs = 0;
  const auto mean = [&](std::size_t pixel) { return static_cast<double>(totals_[pixel]) / std::max(1.0, ticks_); };
  for (std::size_t pixel = 0; pixel < totals_.size(); ++pixel) {
    if (!ordinary_[pixel]) continue;
    pixels += 1;
    squares += mean(pixel) * mean(pixel);
    if ((pixel + 1) % width_ != 0 && ordinary_[pixel + 1]) {
      horizontal += mean(pixel) * mean(pixel + 1);
      horizontal_pairs += 1;
    }
    if (pixel + width_ < totals_.size() && ordinary_[pixel + width_]) {
      vertical += mean(pixel) * mean(pixel + width_);
      vertical_pairs += 1;
    }
  }
  std::vector<CountPart> across, down;
  for (const Part& part : parts_) {
    const double variance = (part.squares - part.ticks * squares) / std::max(1.0, pixels);
    if (!(variance > 0)) continue;
    across.push_back({(part.horizontal - part.ticks * horizontal) / std::max(1.0, horizontal_pairs), variance});
    down.push_back({(part.vertical - part.ticks * vertical) / std::max(1.0, vertical_pairs), variance});
  }
  return {ratio_of(across), ratio_of(down)};
}

std::optional<Measured> IntervalMeter::shortest_us() const {
  const std::uint64_t total = std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0});
  if (total < 100) return std::nullopt;
  const auto at_rank = [&](std::uint64_t rank) {
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      below += counts_[i];
      if (below >= rank) return static_cast<double>(i);
    }
    return static_cast<double>(longest_us);
  };
  const std::uint64_t rank = 1 + total / 10'000;
  const double shortest = at_rank(rank);
  return Measured{shortest, std::max(std::sqrt(1.0 / 12), (at_rank(std::min(total, 10 * rank)) - shortest) / 3)};
}

void LargestCountMeter::begin_recording() {
  std::fill(tick_counts_.begin(), tick_counts_.end(), 0);
  std::fill(history_counts_.begin(), history_counts_.end(), 0);
  for (auto& pixels : recent_) pixels.clear();
  tick_ = 0;
}

LargestCounts LargestCountMeter::over_parts(Largest Part::*pixels) const {
  std::vector<double> ticks, histories;
  LargestCounts largest;
  for (const Part& part : parts_) {
    const Largest& found = part.*pixels;
    if (found.tick == 0) continue;
    ticks.push_back(found.tick);
    histories.push_back(found.history);
    largest.tick.value = std::max(largest.tick.value, ticks.back());
    largest.history.value = std::max(largest.history.value, histories.back());
  }
  if (ticks.size() < 2) return largest;
  const double root = std::sqrt(static_cast<double>(ticks.size()));
  largest.tick.uncertainty = root * mean_of(ticks).uncertainty;
  largest.history.uncertainty = root * mean_of(histories).uncertainty;
  return largest;
}

void LargestCountMeter::advance(std::int64_t tick) {
  for (const std::uint32_t pixel : recent_[static_cast<std::size_t>(tick_) % ticks_per_history]) tick_counts_[pixel] = 0;
  const std::int64_t steps = std::min<std::int64_t>(tick - tick_, ticks_per_history);
  for (std::int64_t i = 1; i <= steps; ++i) {
    auto& oldest = recent_[static_cast<std::size_t>(tick_ + i) % ticks_per_history];
    for (const std::uint32_t pixel : oldest) --history_counts_[pixel];
    oldest.clear();
  }
  if (tick - tick_ > steps) {  // a silence of a history: nothing is left
    for (auto& pixels : recent_) pixels.clear();
  }
  tick_ = tick;
}

}  // namespace tactile::characterise
