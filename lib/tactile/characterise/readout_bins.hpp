#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tactile/events/readout.hpp"

namespace tactile::characterise {

/// Places events in the bins that `FlickerMeter` takes: read-outs of a steady sensor, else 125 us.
///
///   index = (t - begin - step * line) / length, rounded down;   line = y (a scan of rows) or x
struct ReadoutBins {
  static constexpr double unsteady_us = 125;
  double length_us = unsteady_us, per_us = 1 / unsteady_us, begin_us = 0, step_us = 0;
  bool by_row = false;

  explicit ReadoutBins(const events::Readout& readout) {
    if (readout.kind != events::Readout::Kind::steady) return;
    length_us = readout.period_us.value;
    per_us = 1 / length_us;
    step_us = readout.scan == events::Scan::none ? 0 : readout.step_us.value;
    by_row = readout.scan == events::Scan::rows;
    begin_us = readout.begin_us -
               (std::floor((readout.begin_us + std::max(0.0, step_us * static_cast<double>(readout.lines))) / length_us) + 1.5) *
                   length_us;
  }
  /// @param t_us  since the first event that the read-out was measured on
  std::int64_t index_of(std::int64_t t_us, const events::Event& event) const {
    return static_cast<std::int64_t>((static_cast<double>(t_us) - begin_us - step_us * (by_row ? event.y : event.x)) * per_us);
  }
};

}  // namespace tactile::characterise
