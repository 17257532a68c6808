#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "tactile/core/time.hpp"

namespace tactile::events {

struct TimeExtent {
  CameraTime first{}, last{};
};

/// The earliest and the latest time of the elements. @param elements  not empty
template <class Element>
TimeExtent time_extent_of(std::span<const Element> elements) {
  const auto by_time = [](const Element& a, const Element& b) { return a.t < b.t; };
  const auto [first, last] = std::minmax_element(elements.begin(), elements.end(), by_time);
  return {first->t, last->t};
}

/// Follows the times of one stream and corrects overflows.
///
/// A step back by more than 2^31 us and at most 2^32 us is an overflow: the writer cut its times to 32 bits, and adding 2^32 us
/// makes a shorter step forward of it. A single damaged time also makes such a step, before it or after it. Therefore the time
/// before the leap is kept. If the stream soon returns to it, there was no overflow.
class StreamTime {
 public:
  enum class Step : std::uint8_t { normal, overflow, back };

  /// Advances to a time as it is stored. `back` undoes all shifts since the leap.
  Step advance_to(CameraTime stored) {
    Step result = Step::normal;
    const std::int64_t step = begun_ ? step_between(last_, after(stored, microseconds{shift_})) : 0;
    const bool leaps = step > leap || step < -leap;
    const std::int64_t step_from_leap = step_between(leap_from_, after(stored, microseconds{shift_at_leap_}));
    // A leap of at most 2^31 us may be a pause. Then an overflow after the pause explains a step back as well as a return does.
    const std::int64_t step_onwards = strayed_far_ || is_near(step) || step > 0 ? step : saturating_add(step, wrap);
    if (strayed_ && is_near(step_from_leap) && size_of(step_from_leap) < size_of(step_onwards)) {
      result = Step::back;
      shift_ = shift_at_leap_;
      strayed_ = false;
    } else if (leaps) {
      if (!strayed_ || !strayed_far_) {
        strayed_ = leapt_ = true;
        strayed_far_ = !is_near(step);
        leap_from_ = last_;
        shift_at_leap_ = shift_;
      }
      const std::int64_t shift_before = shift_;
      if (!is_near(step) && step < 0 && step >= -wrap) shift_ += wrap;
      if (!is_near(step) && step > 0 && step <= wrap && shift_ > 0) shift_ -= wrap;
      if (shift_ != shift_before) result = Step::overflow;
    }
    begun_ = true;
    last_ = after(stored, microseconds{shift_});
    return result;
  }

  /// Whether ascending times from `first` to `last` contain no leap and need no shift.
  bool is_steady(CameraTime first, CameraTime last) const {
    return shift_ == 0 && !strayed_ && step_between(first, last) <= leap;
  }

  /// A stream that stays after a leap for a whole packet does not return.
  void end_packet() {
    strayed_ = strayed_ && leapt_;
    leapt_ = false;
  }

  std::int64_t shift() const { return shift_; }  ///< to be added to stored times [us]

 private:
  static constexpr std::int64_t wrap = std::int64_t{1} << 32;
  static constexpr std::int64_t leap = wrap / 64;  ///< a minute: a camera pauses this long only if nothing moves

  static std::int64_t step_between(CameraTime a, CameraTime b) { return saturating_subtract(us_of(b), us_of(a)); }
  static double size_of(std::int64_t step) { return std::abs(static_cast<double>(step)); }
  static bool is_near(std::int64_t step) { return step >= -wrap / 2 && step <= wrap / 2; }

  CameraTime last_{};
  std::int64_t shift_ = 0;
  CameraTime leap_from_{};  ///< the last time before the leap
  std::int64_t shift_at_leap_ = 0;
  bool begun_ = false;
  bool strayed_ = false;
  bool strayed_far_ = false;  ///< by more than 2^31 us
  bool leapt_ = false;        ///< in this packet
};

}  // namespace tactile::events
