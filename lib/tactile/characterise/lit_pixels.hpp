#pragma once

#include <vector>

#include "tactile/characterise/first_reading.hpp"

namespace tactile::characterise {

/// Flicker, and the unusual pixels that it makes fire.
struct LightReading {
  Flicker flicker;
  std::vector<bool> lit;  ///< by pixel
};

/// Looks for flicker in the events of the ordinary pixels, and of the unusual ones: a lamp or a strobe in the picture reaches few
/// pixels, which then fire more than all others. With n events of one polarity at times t in a second, an unusual pixel is lit if
///
///   R = sqrt((sum of |sum of exp(2 pi i hz t)|^2 - n) / sum of n (n - 1)) >= 0.5,   sums over seconds and polarities
///
/// at one of the lines, and chance does not explain it. A hot pixel may have a rhythm of its own. Light reaches several pixels:
/// a line of unusual pixels alone is flicker if at least three of them are lit.
/// Reads every recording once, and again if there are lines.
LightReading read_light(const FirstReading& first, const UnusualPixels& unusual, const CharacteriseOptions& options,
                        const ProgressCallback& progress);

}  // namespace tactile::characterise
