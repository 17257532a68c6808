#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/random.hpp"
#include "tactile/labels/posterior/run_states.hpp"

namespace tactile::labels {

/// A state in each bin.
using Path = std::vector<std::uint16_t>;

/// What the events say in each bin. All states with the same level and pattern say the same.
class BinLikelihoods {
 public:
  /// @param of_level    ln p(counts | level) less that of level 0, [bin, level]
  /// @param of_pattern  ln p(pattern | happening) less that of others, [bin, happening], of states that move; empty: none
  BinLikelihoods(std::span<const double> of_level, std::span<const double> of_pattern);

  std::size_t bins() const { return log_largest_.size(); }
  double log_largest(std::size_t bin) const { return log_largest_[bin]; }
  /// Relative to the largest, by `class_of`.
  const double* at(std::size_t bin) const { return &relative_[bin * classes]; }
  static std::size_t class_of(Happening happening, std::size_t level);

 private:
  static constexpr std::size_t classes = 3 * motion_levels.size();
  std::vector<double> relative_, log_largest_;
};

/// The filtered probabilities of a hidden Markov chain: of each state in each bin, given the events until then.
struct Filtered {
  double log_evidence = 0;    ///< ln p(events | conditions of the arm), less that of a quiet recording
  std::vector<float> states;  ///< [bin, state]; empty unless kept
};

/// The forward pass (Rabiner 1989).
Filtered filtered(const RunStates& states, const BinLikelihoods& likelihoods, std::span<const std::uint8_t> arm_conditions_of,
                  bool keep);

/// `Filtered::log_evidence` for several sequences of conditions, in their order. Where all are alike, at the beginning and the
/// end of the recording, the passes are made once.
std::vector<double> log_evidences(const RunStates& states, const BinLikelihoods& likelihoods,
                                  const std::vector<std::vector<std::uint8_t>>& conditions_of);

/// Paths drawn from their posterior, by the backward pass over what `filtered` kept (Fruehwirth-Schnatter 1994).
std::vector<Path> drawn_paths(const RunStates& states, const Filtered& filtered, std::span<const std::uint8_t> arm_conditions_of,
                              std::size_t paths, Random& random);

}  // namespace tactile::labels
