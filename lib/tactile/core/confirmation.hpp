#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/touch.hpp"

namespace tactile {

/// How often a class must be predicted before it is reported: in at least `needed` of the last `of` ticks, which is more than
/// half of them, so that no two classes can be confirmed at once. 1 of 1 reports each tick by itself.
struct Confirmation {
  unsigned needed = 1;
  unsigned of = 1;

  friend bool operator==(const Confirmation&, const Confirmation&) = default;
};

inline constexpr unsigned longest_confirmation = 1000;  ///< ticks

/// "2/3" as {2, 3}. @throws Error  unless both are whole numbers with of / 2 < needed <= of <= longest_confirmation
Confirmation confirmation_in(std::string_view text);

std::string text_of(const Confirmation& confirmation);  ///< "2/3"

/// The verdict at each tick: the class other than none that was predicted in at least `needed` of the last `of` ticks, this one
/// included; none where there is no such class. Ticks before the first count as none.
///
/// @param predicted  one class for each tick
std::vector<Touch> confirmed(std::span<const Touch> predicted, const Confirmation& confirmation);

/// The same, tick by tick. Allocates memory only in its constructor.
class RunningConfirmation {
 public:
  explicit RunningConfirmation(const Confirmation& confirmation) : confirmation_(confirmation), last_(confirmation.of) {
    restart();
  }

  Touch next(Touch predicted);  ///< the verdict at the next tick
  void restart();               ///< ticks before the next one count as none

 private:
  Confirmation confirmation_;
  std::vector<Touch> last_;  ///< the last `of` ticks, the oldest at `oldest_`
  std::size_t oldest_ = 0;
  std::array<unsigned, touch_count> counts_{};
};

}  // namespace tactile
