#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/measured.hpp"
#include "tactile/events/event.hpp"

namespace tactile::characterise {

// Meters that follow each pixel through time. Pixels are y * width + x; times are us since a recording's first event. Their
// tables are larger than a cache: `prefetch` loads what `add` will need.

/// How much neighbouring pixels fire together: the correlation of their counts per tick, pooled over all pairs,
///
///   r = sum of cov(n_a, n_b) / pairs / (sum of var(n_a) / pixels),   0 if each pixel fires by itself
struct Neighbours {
  Measured horizontal, vertical;
};

/// Only ordinary pixels and pairs of them count.
class NeighbourMeter {
 public:
  NeighbourMeter(events::SensorSize size, std::vector<bool> ordinary);

  void begin_part() { parts_.emplace_back(); }  ///< of time; the uncertainty is the scatter of the parts
  /// One event of an ordinary pixel. @param tick  ascending; an earlier one counts as the last
  void add(std::size_t pixel, std::int64_t tick) {
    if (tick > tick_) end_tick(tick);
    if (counts_[pixel]++ == 0) fired_.push_back(pixel);
    ++totals_[pixel];
  }
  void end_recording(std::int64_t ticks);  ///< @param ticks  in the recording
  void prefetch(std::size_t pixel) const {
    __builtin_prefetch(&counts_[pixel], 1);
    __builtin_prefetch(&totals_[pixel], 1);
  }
  Neighbours neighbours() const;

 private:
  struct Part {
    double horizontal = 0, vertical = 0, squares = 0, ticks = 0;
  };
  void end_tick(std::int64_t next);

  std::size_t width_, height_;
  std::vector<bool> ordinary_;
  std::vector<std::uint16_t> counts_;
  std::vector<std::uint32_t> totals_;
  std::vector<std::size_t> fired_;
  std::vector<Part> parts_;
  std::int64_t tick_ = 0;
  double ticks_ = 0;
};

/// Times from one event of a pixel to its next.
class IntervalMeter {
 public:
  static constexpr std::size_t longest_us = 20'000;  ///< longer ones are not counted

  explicit IntervalMeter(std::size_t pixels) : latest_(pixels, none), counts_(longest_us + 1) {}

  void begin_recording() { std::fill(latest_.begin(), latest_.end(), none); }
  /// One event. @return  the time since the pixel's last one; nothing for its first, or a step back
  std::optional<std::int64_t> add(std::size_t pixel, std::int64_t t_us) {
    const std::int64_t latest = latest_[pixel];
    if (latest != none && t_us < latest) return std::nullopt;
    latest_[pixel] = t_us;
    if (latest == none) return std::nullopt;
    const std::int64_t interval = t_us - latest;
    if (interval <= static_cast<std::int64_t>(longest_us)) ++counts_[static_cast<std::size_t>(interval)];
    return interval;
  }
  /// The shortest interval, except for the shortest 1 in 10'000, which are taken for damage. Its uncertainty is the distance to
  /// ten times this rank, over 3, and at least the rounding. Nothing with fewer than 100 intervals.
  std::optional<Measured> shortest_us() const;
  std::span<const std::uint64_t> counts() const { return counts_; }  ///< by interval [us]
  void prefetch(std::size_t pixel) const { __builtin_prefetch(&latest_[pixel], 1); }

 private:
  static constexpr std::int64_t none = -1;
  std::vector<std::int64_t> latest_;
  std::vector<std::uint64_t> counts_;
};

/// The largest counts of a pixel in a tick and in a history.
struct LargestCounts {
  Measured tick, history;  ///< over all parts of time; the uncertainty is the standard deviation of the largest ones of the parts
};

/// Counts per pixel in ticks and in histories of `ticks_per_history` ticks that end with a tick, as heatmaps have them.
class LargestCountMeter {
 public:
  static constexpr std::size_t ticks_per_history = 20;

  explicit LargestCountMeter(std::size_t pixels) : tick_counts_(pixels), history_counts_(pixels) {}

  void begin_recording();
  void begin_part() { parts_.emplace_back(); }  ///< of time
  /// One event. @param tick  ascending; an earlier one counts as the last
  void add(std::size_t pixel, std::int64_t tick, bool ordinary) {
    if (tick > tick_) advance(tick);
    recent_[static_cast<std::size_t>(tick_) % ticks_per_history].push_back(static_cast<std::uint32_t>(pixel));
    const std::uint32_t in_tick = ++tick_counts_[pixel], in_history = ++history_counts_[pixel];
    Part& part = parts_.back();
    part.all.take(in_tick, in_history);
    if (ordinary) part.ordinary.take(in_tick, in_history);
  }
  void prefetch(std::size_t pixel) const {
    __builtin_prefetch(&tick_counts_[pixel], 1);
    __builtin_prefetch(&history_counts_[pixel], 1);
  }
  LargestCounts all() const { return over_parts(&Part::all); }
  LargestCounts ordinary() const { return over_parts(&Part::ordinary); }

 private:
  struct Largest {
    std::uint32_t tick = 0, history = 0;

    void take(std::uint32_t in_tick, std::uint32_t in_history) {
      tick = std::max(tick, in_tick);
      history = std::max(history, in_history);
    }
  };
  struct Part {
    Largest all, ordinary;
  };
  LargestCounts over_parts(Largest Part::*pixels) const;
  void advance(std::int64_t tick);

  std::vector<std::uint32_t> tick_counts_, history_counts_;
  std::array<std::vector<std::uint32_t>, ticks_per_history> recent_;
  std::int64_t tick_ = 0;
  std::vector<Part> parts_ = {{}};
};

}  // namespace tactile::characterise
