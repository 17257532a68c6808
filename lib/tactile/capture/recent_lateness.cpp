#include "tactile/capture/recent_lateness.hpp"

#include <algorithm>

namespace tactile::capture {
namespace {

constexpr microseconds window{100'000};

}  // namespace

microseconds RecentLateness::most(HostTime now) const {
  return now - begin_ < 2 * window ? std::max(before_, now_) : microseconds{0};
}

void RecentLateness::add(HostTime arrived, microseconds lateness) {
  if (arrived - begin_ >= window) {
    before_ = arrived - begin_ < 2 * window ? now_ : microseconds{0};
    now_ = microseconds{0};
    begin_ = arrived;
  }
  now_ = std::max(now_, lateness);
}

}  // namespace tactile::capture
