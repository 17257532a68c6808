#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"

namespace tactile::pictures {

/// Events over time in a bounded number of bins: whenever the last is full, neighbours become one and bins twice as long. Hot
/// pixels are counted like others; what labels are taken from is `EventRate`.
class EventCurve {
 public:
  /// @param begin      where bin 0 begins; events before it are passed over
  /// @param bin        > 0
  /// @param most_bins  even, > 0
  explicit EventCurve(CameraTime begin, microseconds bin = microseconds{250}, std::size_t most_bins = 65'536);

  void add(std::span<const events::Event> events);

  CameraTime begin() const { return begin_; }
  microseconds bin() const { return bin_; }
  std::span<const std::uint64_t> counts() const { return counts_; }  ///< up to the last bin with an event

  /// The highest rate of the bins that overlap [from, to), in events per ms; 0 where there are none.
  double most_per_ms(CameraTime from, CameraTime to) const;

 private:
  std::uint64_t& bin_of(CameraTime t);

  CameraTime begin_;
  microseconds bin_;
  std::size_t most_bins_;
  std::vector<std::uint64_t> counts_;
};

}  // namespace tactile::pictures
