#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/labels/posterior/imu_evidence.hpp"
#include "tactile/labels/posterior/motion_course.hpp"
#include "tactile/labels/posterior/place_counts.hpp"
#include "tactile/labels/posterior/run_states.hpp"
#include "tactile/labels/posterior/state_paths.hpp"

namespace tactile::labels {

/// An offset of a clock (the camera's time less its time) and the logarithm of its weight.
struct WeighedOffset {
  std::int64_t us = 0;
  double log_weight = 0;
};

/// Looks for the offsets of the robot's clock that fit events and IMU; without a log, of the film's clock. The grid becomes
/// finer: 32 ms and 8 ms with bins of 8 ms, then 8 ms, or 1 ms with an IMU, with bins of 1 ms.
class ClockOffsets {
 public:
  /// @param signals, counts, states  of the run; they must live as long
  /// @param piece  of the robot's log; null: by the film
  ClockOffsets(const alignment::RunSignals& signals, const PlaceCounts& counts, const RunStates& states,
               const robot::RobotLog* piece);

  /// Nothing if nothing moves there.
  const std::optional<MotionCourse>& course() const { return course_; }
  const robot::RobotLog* piece() const { return piece_; }
  bool has_imu() const { return imu_.has_value(); }
  /// Of `likely`, by the IMU alone; nothing without it.
  std::optional<std::int64_t> likeliest_by_imu() const;
  const std::vector<WeighedOffset>& likely() const { return likely_; }
  std::vector<std::uint8_t> conditions_at(std::int64_t offset_us) const;

  /// Sets `likely`: by all possible offsets the first time, then near those that were likely.
  /// @param evidence, pattern  as for `BinLikelihoods`  @param is_last  weighs them by bins of 1 ms, not of 8 ms
  void search(std::span<const double> evidence, std::span<const double> pattern, bool is_last);
  /// Adds offsets that other runs make likely, and multiplies all weights by what these runs say.
  /// @param prior  densities of 4 ms standard deviation, normalised
  void consider(std::span<const WeighedOffset> prior, std::span<const double> evidence, std::span<const double> pattern);

 private:
  using Offsets = std::vector<std::int64_t>;
  std::pair<std::int64_t, std::int64_t> possible() const;
  double imu_at(std::int64_t offset_us) const { return imu_ ? imu_->of(offset_us) : 0; }
  Offsets most_promising(Offsets grid, const BinLikelihoods& coarse) const;
  std::vector<WeighedOffset> by_imu(const Offsets& offsets) const;
  std::vector<WeighedOffset> with_imu_between(const std::vector<WeighedOffset>& grid, std::int64_t step) const;
  std::vector<WeighedOffset> weighed(const Offsets& offsets, const BinLikelihoods& likelihoods, const RunStates& states,
                                     microseconds bin) const;

  const alignment::RunSignals& signals_;
  const PlaceCounts& counts_;
  const RunStates& states_;
  std::size_t together_;  ///< bins of the recording in a coarse one
  RunStates coarse_states_;
  const robot::RobotLog* piece_;
  std::optional<MotionCourse> course_;
  std::optional<ImuEvidence> imu_;
  std::vector<WeighedOffset> likely_;
};

/// The logarithm of a density of offsets [1/us]: of normal distributions with a standard deviation of 4 ms each, and with a
/// probability of 5 % of none of them.
double log_density(std::span<const WeighedOffset> offsets, double us);

/// In order, each once.
std::vector<std::int64_t> ascending(std::vector<std::int64_t> values);

/// ln sum exp(x), without overflow. @param logarithms  at least one
double log_sum(std::span<const double> logarithms);

/// The logarithms of weights that sum to 1.
void normalise(std::vector<WeighedOffset>& offsets);

}  // namespace tactile::labels
