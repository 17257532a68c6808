#include "tactile/core/time_left.hpp"

namespace tactile {

std::optional<std::chrono::duration<double>> TimeLeft::after(const Progress& progress, Clock::time_point now) {
  const bool begins_again = !last_ || progress.total != last_->total || progress.done < last_->done;
  if (begins_again) {
    measured_from_ = progress.done;
    begun_ = now;
  }
  last_ = progress;
  if (progress.total <= progress.done || progress.done <= measured_from_) return std::nullopt;
  return std::chrono::duration<double>(now - begun_) *
         (static_cast<double>(progress.total - progress.done) / static_cast<double>(progress.done - measured_from_));
}

}  // namespace tactile
