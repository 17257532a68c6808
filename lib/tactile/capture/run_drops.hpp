#pragma once

#include <nlohmann/json.hpp>

#include "tactile/capture/camera_source.hpp"

namespace tactile::capture {

/// Elements that the sources sent and the run's recording lacks, by reason.
struct RunDrops {
  LostElements queue_full;    ///< the disk or the compression was too slow
  LostElements back_in_time;  ///< earlier than previous elements of their stream, also as reported by the sources
  LostElements
      outside;  ///< outside the sensor, with an impossible polarity, of an undeclared stream; frames of an impossible shape
  LostElements unwritten;  ///< the file could no longer be written; `packets`: only whole ones
  LostElements source;     ///< reported by the sources, without those back in time

  LostElements total() const;
};

/// As `dropped` in run.json, without robot and film.
nlohmann::json json_of(const RunDrops& drops);

}  // namespace tactile::capture
