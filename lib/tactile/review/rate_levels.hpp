#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/review/signal_window.hpp"

namespace tactile::review {

/// The events of a recording per bin of time, with coarser and coarser levels: a level's bin holds the sum, the least and the
/// largest of four bins of the level before it. A part of any length is summed exactly, bin by bin, in a time that grows with the
/// logarithm of its length. A recording of 10 minutes takes 60 MB, whatever its rate.
class RateLevels {
 public:
  static constexpr microseconds finest{100};           ///< [us] the shortest bin
  static constexpr std::size_t most_bins = 1U << 24U;  ///< 28 minutes of the finest; a longer recording has longer bins

  RateLevels(CameraTime first, CameraTime last);

  /// In any order. Events outside [first, last] are left out.
  void add(std::span<const events::Event> events);
  void finish();  ///< after the last event: makes the levels

  microseconds bin() const { return bin_; }
  std::size_t bins() const { return counts_.size(); }

  struct Sum {
    std::uint64_t events = 0;
    std::uint32_t least = 0, most = 0;  ///< of the finest bins
  };

  /// Over the bins [begin, end), which must be `bins()` at most and hold one at least.
  Sum over(std::size_t begin, std::size_t end) const;

  /// The rate in events per ms, in buckets of whole bins that begin at whole multiples of their length from the first event on.
  /// The last bucket's mean is over the bins that there are.
  SignalWindow window(const WindowRequest& request) const;

  /// The largest number of events in `length` of whole bins, and the first of these bins.
  struct Busiest {
    std::uint64_t events = 0;
    std::size_t begin = 0;
  };
  Busiest busiest(microseconds length) const;

 private:
  struct Level {
    std::vector<std::uint64_t> events;
    std::vector<std::uint32_t> least, most;
  };
  static constexpr std::size_t ratio = 4;

  CameraTime first_;
  microseconds bin_;
  std::vector<std::uint32_t> counts_;
  std::vector<Level> levels_;  ///< the first is of four bins
};

/// Exact counts of events, in buckets that begin at whole multiples of their length. The events need be in no order.
/// @param first  the recording's first event
SignalWindow exact_rate(std::span<const CameraTime> events, CameraTime first, const WindowRequest& request);

}  // namespace tactile::review
