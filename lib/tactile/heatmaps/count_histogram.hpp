#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace tactile::heatmaps {

/// The number of pixels with each count. It gives the counts that occur without access to the pixels: with N events there are at
/// most sqrt(2 N) different counts.
class CountHistogram {
 public:
  /// @param pixels  in the image, all without events
  explicit CountHistogram(std::uint32_t pixels) : pixels_(pixels), pixels_with_(64), occurs_(1) { add(0, pixels_); }

  /// Adds pixels to a count, or removes them: numbers wrap. Intermediate numbers may be negative. Call `settle` after all
  /// changes.
  void add(std::uint32_t count, std::uint32_t pixels) {
    if (count >= pixels_with_.size()) grow(count);
    const std::uint32_t had = pixels_with_[count], has = had + pixels;
    pixels_with_[count] = has;
    // Without branches, because appearing and disappearing counts are hard to predict.
    occurs_[count / 64] ^= static_cast<std::uint64_t>((had == 0) != (has == 0)) << count % 64;
    largest_ = std::max(largest_, has != 0 ? count : 0);
  }
  void move_one(std::uint32_t from, std::uint32_t to) { add(from, ~0U), add(to, 1); }
  void settle() {
    while (largest_ > 0 && pixels_with_[largest_] == 0) {
      const std::uint64_t up_to_largest = occurs_[largest_ / 64] << (63 - largest_ % 64);
      largest_ -= up_to_largest != 0 ? static_cast<std::uint32_t>(std::countl_zero(up_to_largest))
                                     : std::min(largest_, largest_ % 64 + 1);
    }
  }

  std::uint32_t active_pixels() const { return pixels_ - pixels_with_[0]; }  ///< with a count > 0
  std::uint32_t largest() const { return largest_; }                         ///< count

  /// Calls `use(count)` for each count > 0 that occurs, once, in ascending order.
  template <class Use>
  void for_each_count(Use use) const {
    for (std::uint32_t word = 0; word <= largest_ / 64; ++word) {
      std::uint64_t left = word == 0 ? occurs_[0] & ~std::uint64_t{1} : occurs_[word];
      for (; left != 0; left &= left - 1) use(word * 64 + static_cast<std::uint32_t>(std::countr_zero(left)));
    }
  }

 private:
  void grow(std::uint32_t count) {
    pixels_with_.resize(std::bit_ceil(std::size_t{count} + 1));
    occurs_.resize(pixels_with_.size() / 64);
  }

  std::uint32_t pixels_;
  std::vector<std::uint32_t> pixels_with_;  // by count; its length is at most twice the number of events
  std::vector<std::uint64_t> occurs_;       // a bit for each count
  std::uint32_t largest_ = 0;               // count that occurs
};

}  // namespace tactile::heatmaps
