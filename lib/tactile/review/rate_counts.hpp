#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/review/signal_window.hpp"

namespace tactile::review {

/// The events of a recording per bin of time. A part of any length is summed exactly, bin by bin, in the same short time. A
/// recording of 10 minutes takes 27 MB, whatever its rate.
class RateCounts {
 public:
  static constexpr microseconds finest{100};           ///< [us] the shortest bin of a whole recording
  static constexpr std::size_t most_bins = 1U << 24U;  ///< 28 minutes of the finest; a longer recording has longer bins

  /// @param bin  of a part of a recording: 1 us and up
  RateCounts(CameraTime first, CameraTime last, microseconds bin = finest);

  /// In any order. Events outside [first, last] are left out.
  void add(std::span<const events::Event> events);
  void finish();  ///< after the last event

  microseconds bin() const { return bin_; }
  std::size_t bins() const { return counts_.size(); }

  /// In the bins [begin, end), which must be `bins()` at most.
  std::uint64_t events_in(std::size_t begin, std::size_t end) const { return events_before(end) - events_before(begin); }

  /// The rate in events per ms at the middle of buckets of whole bins, which begin at whole multiples of their length from the
  /// first event on: the mean over `smooth_us` around it, or over the bucket where that is longer, as far as there are bins.
  SignalWindow window(const WindowRequest& request) const;

  /// The largest number of events in `length` of whole bins, and the first of these bins.
  struct Busiest {
    std::uint64_t events = 0;
    std::size_t begin = 0;
  };
  Busiest busiest(microseconds length) const;

 private:
  static constexpr std::size_t stride = 16;  ///< bins from one of `before_` to the next

  std::uint64_t events_before(std::size_t bin_index) const;

  CameraTime first_;
  microseconds bin_;
  std::vector<std::uint32_t> counts_;
  std::vector<std::uint64_t> before_;  ///< events before each `stride`-th bin
};

}  // namespace tactile::review
