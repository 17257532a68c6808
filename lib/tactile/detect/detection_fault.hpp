#pragma once

#include <functional>
#include <string>

#include "tactile/core/time.hpp"

namespace tactile::detect {

/// A fault of the events or of the output, and what the detector did.
struct DetectionFault {
  std::string kind;  ///< "broken", "back", "gave up", "unsound", "jump", "silence", "events again", "stopped", "late",
                     ///< "late events", "behind", "long packets", "lost", "robot", "udp", "recording",
                     ///< "scene", "scene again"
  std::string text;  ///< a sentence; empty if the same fault was reported shortly before
  HostTime at{};
};
using ReportFault = std::function<void(const DetectionFault&)>;

}  // namespace tactile::detect
