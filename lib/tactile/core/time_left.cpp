#include "tactile/core/time_left.hpp"

namespace tactile {

std::optional<std::chrono::duration<double>> TimeLeft::after(const Progress& progress, Clock::time_point now) {
  if (progress.total != total_ || progress.done < done_) {
    measured_from_ = progress.done;
    begun_ = now;
  }
  total_ = progress.total;
  done_ = progress.done;
  if (progress.total <= progress.done || progress.done <= measured_from_) return std::nullopt;
  return std::chrono::duration<double>(now - begun_) *
         (static_cast<double>(progress.total - progress.done) / static_cast<double>(progress.done - measured_from_));
}

}  // namespace tactile
