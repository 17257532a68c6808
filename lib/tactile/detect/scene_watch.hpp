#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "tactile/characterise/scene.hpp"

namespace tactile::detect {

struct SceneWatchOptions {
  events::SensorSize sensor;
  events::MaskPixels mask{};  ///< pixels whose events do not count
  characterise::SceneRanges training{};
  /// Measure each window as soon as it is full, on the thread that adds events: in a replay, so that the same events give the
  /// same lines at any speed.
  bool at_once = false;
  /// From the end of a window that agrees with the state to the start of the next one. After one that disagrees, the next one
  /// begins at once.
  microseconds pause{4'000'000};
};

struct SceneSummary {
  characterise::SceneRanges training;
  std::uint64_t windows = 0;             ///< measured
  std::uint64_t skipped = 0;             ///< not measured, because they lack events
  std::uint64_t left = 0, returned = 0;  ///< changes
  bool is_outside = false;               ///< at the end
  std::optional<characterise::Scene> last{};
};

/// Watches whether the scene is one that the model knows from its training runs (`characterise::SceneState`).
///
/// The thread that adds events only copies them to a window, a second of each five. It allocates no memory and never waits.
/// Another thread measures full windows.
class SceneWatch {
 public:
  /// @param report  called with each change, on the thread that measures
  SceneWatch(SceneWatchOptions options, std::function<void(const characterise::SceneChange&)> report);

  /// Events ascending in time, inside the sensor.
  void add(std::span<const events::Event> events);
  /// So many events of the stream are missing at this point. A window that lacks more than 5 % is not measured: it would show a
  /// quieter scene. By the thread that adds.
  void lose(std::uint64_t events);
  /// The next events may have any time. By the thread that adds.
  void restart();

  /// Measures the window if it is full. By one other thread.
  void look();
  /// Measures a last window that is not full, if it covers half a second. When no thread adds any more.
  void finish();

  const SceneSummary& summary() const { return summary_; }

 private:
  void measure();

  SceneWatchOptions options_;
  std::function<void(const characterise::SceneChange&)> report_;
  characterise::SceneState state_;
  SceneSummary summary_;
  characterise::SceneWindow window_;  ///< of the thread that measures while `is_full_`, else of the one that adds
  std::uint64_t lost_ = 0;            ///< events that the window lacks; of the same thread
  std::atomic<bool> is_full_{false};
  bool pauses_ = false;                   ///< so as `window_`
  std::optional<CameraTime> next_begin_;  ///< of the thread that adds: events before it do not count
};

}  // namespace tactile::detect
