#pragma once

#include <vector>

#include "tactile/labels/posterior/run_states.hpp"

namespace tactile::test {

/// p(to | from), [from][to].
inline std::vector<std::vector<double>> dense_transitions(const labels::RunStates& states, std::uint8_t arm) {
  std::vector<std::vector<double>> all(states.count(), std::vector<double>(states.count(), 0.0));
  const labels::StateTransitions& moves = states.transitions(arm);
  for (std::size_t from = 0; from < states.count(); ++from) {
    for (const auto& step : moves.within.of(from)) all[from][step.to] += step.probability;
    for (const auto& leaves : moves.leaving.of(from)) {
      for (const auto& enters : moves.entering.of(leaves.to)) all[from][enters.to] += leaves.probability * enters.probability;
    }
  }
  return all;
}

}  // namespace tactile::test
