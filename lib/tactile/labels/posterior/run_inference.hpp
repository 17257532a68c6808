#pragma once

#include <memory>
#include <span>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/labels/posterior/clock_offsets.hpp"
#include "tactile/labels/posterior/drawn_paths.hpp"
#include "tactile/labels/posterior/motion_evidence.hpp"
#include "tactile/labels/posterior/place_counts.hpp"
#include "tactile/labels/posterior/run_posterior.hpp"
#include "tactile/labels/posterior/session_offsets.hpp"

namespace tactile::labels {

/// The inference in one run. It keeps references to itself, and to the signals: it is neither copied nor moved.
class RunInference {
 public:
  /// Learns the rates of noise and motion, the pattern of the press, and the likely offsets of the clock of robot or film, by
  /// this run's signals alone. @param counts  of the same recording; or of a part of it, then
  /// `signals.imu` has the samples of this part, and all else is of the whole recording
  RunInference(const alignment::RunSignals& signals, PlaceCounts counts);
  RunInference(const RunInference&) = delete;
  RunInference& operator=(const RunInference&) = delete;
  RunInference(RunInference&&) = delete;
  RunInference& operator=(RunInference&&) = delete;
  ~RunInference() = default;

  /// Of the robot's clock, by this run alone.
  OffsetsOfRun robot_offsets() const;

  /// @param prior  of the robot's offset, by other runs; empty: none
  RunPosterior posterior(std::span<const WeighedOffset> prior);
  /// By the paths of `posterior`, which goes before.
  std::vector<LikelyRest> rests() const { return likely_rests(sample_); }

 private:
  bool longest_piece_moves() const;  ///< then it has the first clock
  void search(bool is_last);
  std::vector<std::uint8_t> conditions_at(std::int64_t offset_us) const;
  void draw(std::size_t count);
  void learn();
  void consider_noise_alone();

  const alignment::RunSignals& signals_;
  PlaceCounts counts_;
  RunStates states_;
  std::vector<const robot::RobotLog*> pieces_;         ///< of the log, the longest first
  std::vector<std::unique_ptr<ClockOffsets>> clocks_;  ///< of those in which the arm moves; without any, of the film
  std::vector<std::uint8_t> felt_;                     ///< conditions by the IMU, without a log; empty: it felt nothing
  PlaceRates rates_;
  std::vector<double> evidence_, pattern_;
  PathSample sample_;
};

}  // namespace tactile::labels
