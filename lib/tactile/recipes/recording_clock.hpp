#pragma once

#include "tactile/core/time.hpp"
#include "tactile/recipes/recipe_stream.hpp"

namespace tactile::recipes {

/// The time since the first event. It stands still in pauses longer than `longest_pause`.
class RecordingClock {
 public:
  /// Moves to the next event. @param t  not before the last one @return  the time since the first event
  microseconds advance(CameraTime t) {
    const microseconds gap = between(last_, t);
    if (has_begun_ && gap <= longest_pause) elapsed_ += gap;
    has_begun_ = true;
    last_ = t;
    return elapsed_;
  }
  microseconds elapsed() const { return elapsed_; }

 private:
  bool has_begun_ = false;
  CameraTime last_{};
  microseconds elapsed_{0};
};

}  // namespace tactile::recipes
