#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/pixel_mask.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/bundle/gate.hpp"

namespace tactile::model {

/// How much likelier the recent events are if something moves than if all of them are background. The sensor is divided into
/// cells of 80 x 80 px, camera time into steps of 2 ms. With n the events of a cell in a step and m its background, the
/// hypothesis is that each cell by itself has twice its background with a probability of 1 in 10:
///
///   ratio = sum over cells of ln(0.9 + 0.1 min(2^n exp(-m), 2^20))
///
/// The value at t is the largest ratio of the steps that ended in (t - t_h, t]: events of a touch stay seen while they are in
/// the history. It is infinite until the background is known, after 250 steps, and for t_h more.
///
/// The background of a cell is the median of its first 250 steps, at least 0.05. Then it follows the counts at each 10th step
/// whose value is below 8,
///
///   m += 10 (min(n, m + 2 sqrt(m + 1)) - m) / 500.
///
/// Motion does not raise it, and slow changes of the light move it. If the noise rises at once, the value stays above 8 and the
/// background stands still. A touch pauses, noise does not: where 90 % of the last 5 s (250 samples, one each 10 steps) have
/// values of at least 8, the background becomes the median of these samples, in every cell. Motion of 5 s without a pause becomes
/// background too.
///
/// Steps count from the first event, or from the first `at` if that is earlier. Then a value depends only on the events and t,
/// not on which ticks were asked for. A step of 48 cells costs some 1900 instructions, an event 8. Memory is allocated only for
/// more steps ahead of t than ever before.
class BackgroundRatio {
 public:
  /// @param mask  pixels whose events do not count
  /// @throws Error  if the sensor has no area or more than 2^15 pixels in a direction
  BackgroundRatio(events::SensorSize sensor, microseconds history, const events::MaskPixels& mask = {});

  /// Events ascending in time, inside the sensor, not before the last `at`.
  void add(std::span<const events::Event> events);

  /// The value at `t`, from the events added so far. Ascending.
  double at(CameraTime t);

  /// The ratio of the last step that ended at the last `at` or before; infinite until the background is known.
  double latest() const;

  double background(std::size_t cell) const { return background_[cell]; }  ///< events per step; of known cells
  bool is_known() const { return seen_ >= steps_to_know; }

  static constexpr std::int64_t step_us = model::gate_step.count();
  static constexpr std::size_t steps_to_know = 250;

 private:
  struct Step {
    std::int64_t index = 0;
    std::vector<std::uint32_t> counts;
  };
  void begin_step(CameraTime t);
  void take(std::span<const std::uint32_t> counts);
  void sample(std::span<const std::uint32_t> counts);
  void learn(std::span<const std::uint32_t> counts);
  void take_median();
  double largest() const;
  void set_background(std::size_t cell, double events);
  void skip_silence(std::int64_t end);
  double ratio_of(std::span<const std::uint32_t> counts) const;

  events::PixelMask mask_;
  std::vector<events::Event> unmasked_;
  std::vector<std::uint8_t> column_;         ///< of a pixel's cell, by x
  std::vector<std::uint16_t> first_of_row_;  ///< the first cell of the pixel's row of cells, by y
  std::size_t cells_ = 0;
  std::deque<Step> ahead_;                          ///< steps with events that `at` has not reached
  CameraTime end_of_last_{};                        ///< of `ahead_`
  std::vector<std::vector<std::uint32_t>> unused_;  ///< their memory
  std::int64_t next_ = 0;                           ///< the step to take next, once `begun_`
  bool begun_ = false;
  std::size_t seen_ = 0;                ///< steps taken, until the background is known
  std::size_t until_sample_ = 0;        ///< steps
  std::vector<std::uint32_t> samples_;  ///< ring of the counts by cell: of the first steps, then of each 10th
  std::vector<std::uint8_t> moving_;    ///< of a sample: whether its value was at least 8
  std::size_t sample_place_ = 0, moving_count_ = 0;
  std::vector<double> background_;      ///< m
  std::vector<std::int64_t> halvings_;  ///< whole h and rest f of exp(-m) = f 2^-h, 1/2 < f <= 1: both are in range for
  std::vector<double> rest_;            ///< any m
  std::vector<double> recent_;          ///< ring of the ratios of the last t_h
  std::size_t place_ = 0;
  std::vector<std::uint32_t> none_;  ///< counts of an empty step
};

/// For each interval, the largest ratio of the steps that end in the first 10 ms after its start, and not after its end: it
/// decides whether a gate opens in time. Intervals without such a step, or from before the background is known, have none.
/// @param intervals  in any order
/// @throws Error  as RecordingReader, or if the stream declares no size
std::vector<double> opening_ratios(events::RecordingReader& recording, std::span<const TouchInterval> intervals,
                                   const heatmaps::HeatmapOptions& rendering);

}  // namespace tactile::model
