#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/simulation/event_camera.hpp"
#include "tactile/simulation/skin_motion.hpp"

namespace tactile {

/// What the event camera saw of a run.
struct FilmedSkin {
  std::uint64_t events = 0;
  std::uint64_t caused = 0;  ///< by moving markers; the others are noise
  /// The first event that each of the skin's motions caused, in their order; nothing if it caused none so far. Where an
  /// unlabelled motion goes on beside a labelled one, the labelled one's events begin with its start.
  std::vector<std::optional<CameraTime>> first_events;
  CameraTime last_readout{};
};

/// The camera looking at the skin, one read-out after the other.
class SkinFilm {
 public:
  /// @param motion, pixels  must outlive the film
  SkinFilm(const SkinMotion& motion, const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start,
           std::uint64_t seed);

  bool ended() const { return next_ == motion_->poses.size(); }
  double share_done() const { return static_cast<double>(next_) / static_cast<double>(motion_->poses.size()); }
  /// The next read-out's events, valid until the one after it; not to be called once it has ended.
  std::span<const Event> next();
  const FilmedSkin& filmed() const { return filmed_; }  ///< up to the last read-out

 private:
  const SkinMotion* motion_;
  EventCamera camera_;
  microseconds readout_;
  CameraTime start_;
  std::size_t next_ = 0;
  FilmedSkin filmed_;
};

/// Runs the film to its end and hands on the events in batches, ascending in time.
/// @param tell_share  told how much of the run is done, 0 to 1; may throw to end it
void film_whole(SkinFilm& film, const std::function<void(std::span<const Event>)>& use,
                const std::function<void(double)>& tell_share = {});

}  // namespace tactile
