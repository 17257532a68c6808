#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>

#include "tactile/core/touch.hpp"

namespace tactile::model {

/// How often labelled runs change between none, press and slip.
struct Transitions {
  std::array<std::array<std::uint64_t, touch_count>, touch_count> counts{};  ///< [from][to]
  std::array<double, touch_count> seconds{};                                 ///< spent in each class

  /// The rate of a change [1/s]: (count + 1/2) / (seconds + 1), so that what was never seen stays possible.
  double rate(Touch from, Touch to) const;

  /// Adds a run.
  /// @param labelled  its intervals, ascending in time and apart
  void add(CameraTime begin, CameraTime end, std::span<const TouchInterval> labelled);

  friend bool operator==(const Transitions&, const Transitions&) = default;
};

/// {"counts": [[0, 9, 8], …], "seconds": [80.5, 2.1, 18.4]}, in the order none, press, slip
void to_json(nlohmann::json& json, const Transitions& transitions);
void from_json(const nlohmann::json& json, Transitions& transitions);  ///< @throws Error

}  // namespace tactile::model
