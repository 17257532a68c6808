#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace tactile::labels {

/// A stretch of bins of the whole recording, [begin, end).
struct Stretch {
  std::size_t begin = 0, end = 0;
  bool holds(std::size_t bin) const { return bin >= begin && bin < end; }
};

/// Finds quickly which of many stretches may hold a bin: all others lie before it or after it.
class Stretches {
 public:
  /// @param stretches  by time, nearly: an overlap costs time only
  explicit Stretches(const std::vector<Stretch>& stretches) {
    for (const Stretch& stretch : stretches) {
      latest_ends_.push_back(std::max(stretch.end, latest_ends_.empty() ? 0 : latest_ends_.back()));
      earliest_begins_.push_back(stretch.begin);
    }
    for (std::size_t i = earliest_begins_.size(); i-- > 1;)
      earliest_begins_[i - 1] = std::min(earliest_begins_[i - 1], earliest_begins_[i]);
  }

  /// Indices [begin, end) of the candidates; there may be none.
  Stretch around(std::size_t bin) {
    if (bin == bin_) return found_;
    bin_ = bin;
    const auto first = std::upper_bound(latest_ends_.begin(), latest_ends_.end(), bin);
    const auto last = std::upper_bound(earliest_begins_.begin(), earliest_begins_.end(), bin);
    found_ = {static_cast<std::size_t>(first - latest_ends_.begin()), static_cast<std::size_t>(last - earliest_begins_.begin())};
    return found_;
  }

 private:
  std::vector<std::size_t> latest_ends_;      ///< up to each
  std::vector<std::size_t> earliest_begins_;  ///< from each on
  std::size_t bin_ = static_cast<std::size_t>(-1);
  Stretch found_;
};

}  // namespace tactile::labels
