#pragma once

#include <string>

#include "tactile/events/readout.hpp"

namespace tactile::cli {

/// "every 195.16323 ± 0.00006 us, columns from right to left, 0.300005 ± 0.000003 us each"
std::string readout_text(const events::Readout& readout);

/// What the last digits of a stamp are worth: "up to 195 us after the change; ..."
std::string precision_text(const events::Readout& readout);

}  // namespace tactile::cli
