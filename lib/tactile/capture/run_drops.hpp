#pragma once

#include <nlohmann/json.hpp>

#include "tactile/capture/camera_source.hpp"

namespace tactile {

/// What a run's recording lacks of what its sources sent, and why.
struct RunDrops {
  LostElements queue_full;    ///< the disk, or the compression, was too slow
  LostElements back_in_time;  ///< earlier than what their stream had brought before, the sources' own finds included
  LostElements outside;       ///< outside the sensor, of an impossible polarity, of no declared stream; frames of no sound shape
  LostElements unwritten;     ///< not in the file, which could no longer be written; `packets`: of them the whole ones
  LostElements source;        ///< told by the sources, but for those back in time

  LostElements total() const;
};

/// As run.json's `dropped` has it, without the robot's and the film's.
nlohmann::json json_of(const RunDrops& drops);

}  // namespace tactile
