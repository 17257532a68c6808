#pragma once

#include <span>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/labels/posterior/clock_offsets.hpp"
#include "tactile/labels/posterior/drawn_paths.hpp"
#include "tactile/labels/posterior/motion_evidence.hpp"
#include "tactile/labels/posterior/place_counts.hpp"
#include "tactile/labels/posterior/run_posterior.hpp"

namespace tactile::labels {

/// The inference in one run. It keeps references to itself, and to the signals: it is neither copied nor moved.
class RunInference {
 public:
  /// Learns the rates of noise and motion, the pattern of the press, and the likely offsets of the clock of robot or film, by
  /// this run's signals alone. @throws Error  if the recording cannot be read
  explicit RunInference(const alignment::RunSignals& signals);
  RunInference(const RunInference&) = delete;
  RunInference& operator=(const RunInference&) = delete;
  RunInference(RunInference&&) = delete;
  RunInference& operator=(RunInference&&) = delete;
  ~RunInference() = default;

  const ClockOffsets& clock() const { return clock_; }

  /// @param prior  of the robot's offset, by other runs; empty: none
  RunPosterior posterior(std::span<const WeighedOffset> prior);

 private:
  void draw(std::size_t count);
  void learn();
  void consider_noise_alone();
  LikelyOffset offset() const;

  PlaceCounts counts_;
  RunStates states_;
  ClockOffsets clock_;
  PlaceRates rates_;
  std::vector<double> evidence_, pattern_;
  PathSample sample_;
};

}  // namespace tactile::labels
