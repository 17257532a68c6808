#include "tactile/labels/session_clocks.hpp"

#include <algorithm>

namespace tactile {
namespace {

/// The same line, told from another of the clock's stamps.
FittedClock seen_from(FittedClock clock, std::int64_t reference_us) {
  const CameraTime at = clock.relation.camera_from(reference_us);
  const std::int64_t offset_us = saturating_subtract(us_of(at), reference_us);
  const std::int64_t moved_us = offset_us - clock.relation.offset_us;
  clock.offset_low_us += moved_us;
  clock.offset_high_us += moved_us;
  clock.relation.offset_us = offset_us;
  clock.relation.reference_us = reference_us;
  return clock;
}

}  // namespace
}  // namespace tactile
