#include "tactile/features/step_features.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <numeric>

#include "tactile/core/error.hpp"

namespace tactile::features {

StepWindows step_windows(microseconds history, microseconds step, microseconds tick) {
  constexpr std::int64_t steps = steps_of_history - 1;
  if (step <= microseconds{0} || tick <= microseconds{0} || history / steps < step || history == step * steps) {
    throw Error(fmt::format("a history of {} us in steps of {} us and ticks of {} us; expected one longer than {} steps",
                            history.count(), step.count(), tick.count(), steps));
  }
  StepWindows windows{.history = history, .step = step, .window = history - step * steps};
  windows.bin = microseconds{std::gcd(std::gcd(tick.count(), step.count()), windows.window.count())};
  if (history / windows.bin > SlidingSums::most_bins) {
    throw Error(fmt::format("a history of {} us in steps of {} us and ticks of {} us has {} bins; expected {} at most",
                            history.count(), step.count(), tick.count(), history / windows.bin, SlidingSums::most_bins));
  }
  return windows;
}

StepFeatures::StepFeatures(events::SensorSize sensor, const StepWindows& windows, const events::MaskPixels& mask)
    : sensor_(sensor), windows_(windows), sums_(sensor, windows.history, windows.bin, mask) {}

void StepFeatures::add(std::span<const events::Event> events) {
  sums_.add(events);
  if (!events.empty()) uncounted_ = std::min(uncounted_, events.front().t);
}

void StepFeatures::move_to(CameraTime tick) {
  sums_.move_to(tick);
  for (Known& known : known_) {
    if (known.end > uncounted_) known.end = CameraTime::min();
  }
  uncounted_ = CameraTime::max();  // what waits lies after every window that is known
  tick_ = tick;
}

StepFeatures::Known& StepFeatures::place_of(CameraTime end) {
  const std::int64_t index = us_of(end) / windows_.bin.count();
  const auto places = static_cast<std::int64_t>(known_.size());
  return known_[static_cast<std::size_t>((index % places + places) % places)];
}

StepFeatures::OfStep StepFeatures::read(CameraTime end) const {
  const microseconds since = between(before(tick_, windows_.history), end) - windows_.window;
  const auto first = static_cast<std::size_t>(since / windows_.bin),
             count = static_cast<std::size_t>(windows_.window / windows_.bin);
  std::array<float, features_of_window> all{};
  window_features(sums_.sum(first, count), sensor_, all);
  OfStep features{};
  std::copy_n(all.begin(), features.size(), features.begin());
  return features;
}

const std::array<float, step_values>& StepFeatures::features() {
  for (std::size_t k = 0; k < steps_of_history; ++k) {
    const auto until_tick = static_cast<std::int64_t>(steps_of_history - 1 - k);
    OfStep of_step{};
    if (tick_ == CameraTime::min()) {
      std::array<float, features_of_window> none{};
      window_features({}, sensor_, none);
      std::copy_n(none.begin(), of_step.size(), of_step.begin());
    } else {
      const CameraTime end = before(tick_, windows_.step * until_tick);
      Known& known = place_of(end);
      if (known.end != end) known = {end, read(end)};
      of_step = known.features;
    }
    std::copy(of_step.begin(), of_step.end(), features_.begin() + static_cast<std::ptrdiff_t>(k * features_of_step));
  }
  return features_;
}

}  // namespace tactile::features
