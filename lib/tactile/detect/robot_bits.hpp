#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "tactile/core/touch.hpp"

namespace tactile::detect {

/// When one bit of the robot is high.
struct RobotBitRule {
  bool at_press = true, at_slip = true, at_confirmed_slip = false;
};

/// When a bit that is high falls again.
struct BitClearing {
  bool never = false;    ///< only at the end
  microseconds hold{0};  ///< camera time after the last tick that raised it, >= 0
};

/// Bits for a robot from verdicts, tick by tick. A bit rises at the first tick with one of its verdicts.
class RobotBits {
 public:
  RobotBits(std::vector<RobotBitRule> rules, const BitClearing& clearing)
      : rules_(std::move(rules)), clearing_(clearing), raised_(rules_.size()) {}

  /// The bits at the next tick; the first rule has the lowest bit.
  std::uint64_t next(CameraTime tick, Touch verdict, bool slip_is_confirmed) {
    for (std::size_t i = 0; i < rules_.size(); ++i) {
      if ((verdict == Touch::press && rules_[i].at_press) || (verdict == Touch::slip && rules_[i].at_slip) ||
          (slip_is_confirmed && rules_[i].at_confirmed_slip))
        raised_[i] = tick;
      const bool falls = raised_[i] && !clearing_.never && verdict_is_over(*raised_[i], tick);
      if (falls) raised_[i].reset();
    }
    return high();
  }

  /// No verdict is known any more: all bits fall, unless they never do.
  std::uint64_t forget() {
    if (!clearing_.never) raised_.assign(rules_.size(), std::nullopt);
    return high();
  }

 private:
  bool verdict_is_over(CameraTime raised, CameraTime tick) const {
    return tick != raised && between(raised, tick) > clearing_.hold;
  }
  std::uint64_t high() const {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < raised_.size(); ++i) bits |= std::uint64_t{raised_[i] ? 1U : 0U} << i;
    return bits;
  }

  std::vector<RobotBitRule> rules_;
  BitClearing clearing_;
  std::vector<std::optional<CameraTime>> raised_;  ///< the last tick that raised it
};

}  // namespace tactile::detect
