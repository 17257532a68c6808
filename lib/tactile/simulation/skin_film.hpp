#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/simulation/event_camera.hpp"
#include "tactile/simulation/skin_motion.hpp"

namespace tactile::simulation {

/// Statistics of the events that the camera recorded of a run.
struct FilmedSkin {
  std::uint64_t events = 0;
  std::uint64_t caused = 0;  ///< events due to moving markers; the others are noise
  /// The time of the first event of each motion of the skin, in their order; nothing if it has caused none yet. If an unlabelled
  /// motion overlaps a labelled one, the events of the labelled one count from its start.
  std::vector<std::optional<CameraTime>> first_events;
  CameraTime last_readout{};  ///< its start
};

/// The camera in front of the skin, read-out by read-out. Between two poses the skin moves evenly.
class SkinFilm {
 public:
  /// @param motion, pixels  must outlive the film
  SkinFilm(const SkinMotion& motion, const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start,
           std::uint64_t seed);

  bool ended() const { return camera_.next_us() > last_us_; }
  double share_done() const { return last_us_ > 0 ? std::min(1.0, camera_.next_us() / last_us_) : 1.0; }
  /// The events of the next read-out, valid until the next call. Must not be called after the end.
  std::span<const events::Event> next();
  const FilmedSkin& filmed() const { return filmed_; }  ///< up to the last read-out

 private:
  const SkinMotion* motion_;
  SkinPose pose_at(double us) const;

  EventCamera camera_;
  CameraTime start_;
  double last_us_;  ///< of the last pose
  FilmedSkin filmed_;
};

/// Runs the film to its end and passes the events on in batches, ascending in time.
/// @param report_share  receives the finished share of the run, 0 to 1; may throw to stop
void film_whole(SkinFilm& film, const std::function<void(std::span<const events::Event>)>& use,
                const std::function<void(double)>& report_share = {});

}  // namespace tactile::simulation
