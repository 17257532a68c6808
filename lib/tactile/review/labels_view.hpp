#pragma once

#include <nlohmann/json.hpp>

#include "tactile/core/time.hpp"
#include "tactile/labels/saved_labels.hpp"

// Labels as the page gets them: times in microseconds after the first event.
namespace tactile::review {

/// {"version", "intervals", "releases", "flags", "rejected", "remarks", "history", "can_undo", "can_redo", "clocks"}
nlohmann::json labels_view(const labels::VersionedLabels& labels, CameraTime first);

/// [{"index", "interval_id", "what", "confirmed", "lifted_why"}]
nlohmann::json flags_view(const labels::Labels& labels);

/// {"robot_interval_ms", "robot_anchors", "robot_pieces", "video_interval_ms", "video_anchors"}; the interval is half of the
/// offset's 95 % interval; of several pieces of a robot's clock the widest. What has no clock is null.
nlohmann::json clocks_view(const labels::Labels& labels);

std::size_t open_flags(const labels::Labels& labels);  ///< those that no person has confirmed

/// Whether a person has looked at all of it: all intervals are confirmed, and no flag is open.
bool is_confirmed(const labels::Labels& labels);

}  // namespace tactile::review
