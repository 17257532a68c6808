#pragma once

#include <chrono>
#include <optional>

#include "tactile/core/progress.hpp"

namespace tactile {

/// How long a step still takes, by its rate so far. Where the progress begins again, so does the measurement: parts of a step,
/// such as rendering and training, have rates of their own.
class TimeLeft {
 public:
  using Clock = std::chrono::steady_clock;

  /// To be called with every progress. @return  nothing until there is a rate
  std::optional<std::chrono::duration<double>> after(const Progress& progress, Clock::time_point now);

 private:
  std::uint64_t total_ = 0, done_ = 0;  ///< of the last progress
  std::uint64_t measured_from_ = 0;     ///< what was done at `begun_`
  Clock::time_point begun_{};
};

}  // namespace tactile
