#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile::events {

/// How often each difference of successive, distinct time stamps occurs. The stamps belong to lines, such as the columns of a
/// sensor; only stamps of the same line are compared.
class StampDifferences {
 public:
  static constexpr std::size_t longest_us = 20'000;  ///< longer ones are not counted

  explicit StampDifferences(std::size_t lines) : latest_(lines, none), counts_(longest_us + 1) {}

  /// A stamp that is not later than all before it in its line is passed over. @param line  below the number of lines
  void add(std::size_t line, std::int64_t t_us) {
    std::int64_t& latest = latest_[line];
    if (t_us <= latest) return;
    const std::int64_t difference = latest == none ? 0 : saturating_subtract(t_us, latest);
    latest = t_us;
    if (difference > 0 && difference <= static_cast<std::int64_t>(longest_us)) ++counts_[static_cast<std::size_t>(difference)];
  }

  std::span<const std::uint64_t> counts() const { return counts_; }  ///< the index is the difference [us]

 private:
  static constexpr std::int64_t none = std::numeric_limits<std::int64_t>::min();
  std::vector<std::int64_t> latest_;
  std::vector<std::uint64_t> counts_;
};

/// The time P of which all differences d are whole multiples, up to some jitter. Of all periods from 20 us to 15 ms it is the
/// longest at which the coherence has a maximum of at least 0.9, and at least 0.95 of the greatest:
///
///   coherence(P) = mean of cos(2 pi d / P)
///
/// then refined by least squares, P = sum k d / sum k^2 with k = round(d / P). Differences from 0.1 P to 0.6 P show that there is
/// no such period, unless they are at most 2 %. Shorter ones are of stamps of the same read-out, at most half.
/// Nothing with fewer than 50 differences.
std::optional<double> common_period(std::span<const std::uint64_t> differences);

/// The shortest difference with at least 5 % of all differences within +-5 %, and then the median of those: the period of
/// read-outs that a busy scene stretches. Nothing with fewer than 50 differences, or if the result is at most 10 us: then the
/// events have times of their own.
std::optional<double> shortest_period(std::span<const std::uint64_t> differences);

}  // namespace tactile::events
