#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tactile/characterise/sensor.hpp"
#include "tactile/core/progress.hpp"

namespace tactile::characterise {

struct CharacteriseOptions {
  std::string stream{};  ///< the event stream, by id or source; the only one if empty
  unsigned threads = 1;  ///< that decode, > 0
};

/// Finds the times in which nothing moves, and only these count. Reads every recording four or five times (touched ones once):
/// for these times, for the read-out and the counts of the pixels, for flicker, and for what depends on which pixels are
/// ordinary. Memory follows the sensor (about 80 bytes per pixel) and 40 ms of events.
/// @param quiet    recordings of one sensor, at least one, with times in which nothing touches it
/// @param touched  recordings in which markers move
/// @throws Error   if a recording cannot be read, has no event, no duration, is nowhere quiet for half a second, no sensor size
/// or one above 2^22 pixels, or another
///                 size than the first
Sensor characterise(const std::vector<std::filesystem::path>& quiet, const std::vector<std::filesystem::path>& touched,
                    const CharacteriseOptions& options = {}, const ProgressCallback& progress = {});

}  // namespace tactile::characterise
