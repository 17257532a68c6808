#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tactile/features/sliding_sums.hpp"
#include "tactile/features/tick_features.hpp"

namespace tactile::features {

/// Steps that a temporal model reads, and numbers of each: the first twelve of `window_features`.
inline constexpr std::size_t steps_of_history = 16, features_of_step = 12;
inline constexpr std::size_t step_values = steps_of_history * features_of_step;

/// How a history is cut into windows that overlap: the window of step k ends 15 - k steps before the tick, and
///
///   window = history - 15 step
///
/// so that the first window begins with the history, and the last one ends with it.
struct StepWindows {
  microseconds history{}, step{}, window{};
  microseconds bin{};  ///< the longest that a tick, a step and the window are whole numbers of
};

/// @param step  the tick of the model's training  @param tick  of the detector
/// @throws Error  if the history is not longer than 15 steps, or has more than `SlidingSums::most_bins` bins
StepWindows step_windows(microseconds history, microseconds step, microseconds tick);

/// The features of all windows of a history that slides along a recording. A window that was read at an earlier tick is not read
/// again, unless events were added to it since. Memory is allocated only if more events wait than ever before.
class StepFeatures {
 public:
  /// @throws Error  as SlidingSums
  StepFeatures(events::SensorSize sensor, const StepWindows& windows, const events::MaskPixels& mask = {});

  void add(std::span<const events::Event> events);  ///< as `SlidingSums::add`
  void move_to(CameraTime tick);                    ///< as `SlidingSums::move_to`
  std::uint64_t events() const { return sums_.events(); }

  /// [steps, features], the oldest step first, of the history that ends at the last tick; of no events before the first tick.
  const std::array<float, step_values>& features();

 private:
  using OfStep = std::array<float, features_of_step>;
  struct Known {
    CameraTime end = CameraTime::min();  ///< of the window; of none at the start of the clock
    OfStep features{};
  };
  OfStep read(CameraTime end) const;
  Known& place_of(CameraTime end);

  events::SensorSize sensor_;
  StepWindows windows_;
  SlidingSums sums_;
  CameraTime tick_ = CameraTime::min();
  CameraTime uncounted_ = CameraTime::max();         ///< the first event that was added since the last `move_to`
  std::array<Known, 4 * steps_of_history> known_{};  ///< of windows read before; ticks may be shorter than steps
  std::array<float, step_values> features_{};
};

}  // namespace tactile::features
