#pragma once

#include <chrono>
#include <limits>
#include <optional>

#include "tactile/core/progress.hpp"

namespace tactile::trade {

/// Thrown by a step's progress when the budget is used up. What the step has not kept by then is lost.
struct BudgetEnded {};

/// The time that everything may take together. It starts when this is made.
class Budget {
 public:
  explicit Budget(const std::optional<double>& minutes)
      : seconds_(minutes ? 60 * *minutes : std::numeric_limits<double>::infinity()) {}

  double left_s() const { return seconds_ - std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count(); }

  /// Whether so much time is left. If not, the work counts as ended early.
  bool allows(double seconds) {
    const bool enough = seconds < left_s();
    ended_ = ended_ || !enough;
    return enough;
  }

  bool ended() const { return ended_; }  ///< something was left out

  /// Does `work`. @return  false if the budget ended it
  template <class Work>
  bool finishes(Work work) {
    try {
      work();
      return true;
    } catch (const BudgetEnded&) {
      ended_ = true;
      return false;
    }
  }

  /// The same progress, which ends the step by `BudgetEnded` when no time is left.
  ProgressCallback limited(ProgressCallback progress) const {
    return [this, progress = std::move(progress)](const Progress& now) {
      if (left_s() <= 0) throw BudgetEnded();
      if (progress) progress(now);
    };
  }

 private:
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  double seconds_;
  bool ended_ = false;
};

}  // namespace tactile::trade
