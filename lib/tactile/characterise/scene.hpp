#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/pixel_mask.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::characterise {

/// What a second of events shows of sensor and light, whatever touches the skin.
struct Scene {
  /// Events per second where nothing moves. With q the count that a tenth of the bins of 20 ms do not exceed, it is
  /// (q + 1.28 sqrt(q)) / 20 ms: the mean rate of Poisson noise. A touch raises it only if it leaves less than a tenth of the
  /// bins quiet.
  double background_hz = 0;
  double hot_pixels = 0;  ///< by `events::find_hot_pixels`
  /// The strongest line of `FlickerMeter`, 50 Hz or more, in those eighths of the window whose rate is at most 1.25 times the
  /// background: a touch shakes the skin. 0: none.
  double flicker_hz = 0;
  double flicker_depth = 0;            ///< of the event rate
  std::optional<double> readout_us{};  ///< period of steady read-outs, 0: none; nothing of others, or below 2000 events
};

nlohmann::json json_of(const Scene& scene);

/// Measures a scene by the parts of `characterise`.
/// @param events   ascending in time, inside the sensor
/// @param seconds  that they cover, > 0
/// @param mask     pixels whose events do not count
Scene scene_of(std::span<const events::Event> events, double seconds, events::SensorSize size,
               const events::MaskPixels& mask = {});

/// Collects the events of one second, or of less: at most 2^19, so that memory and work stay bounded. Its memory is allocated by
/// the constructor alone.
class SceneWindow {
 public:
  static constexpr microseconds length{1'000'000};
  static constexpr std::size_t most_events = std::size_t{1} << 19;

  SceneWindow();

  /// Copies events until the window is full. @param events  ascending in time, after those before
  /// @return  how many belong to it; the rest belongs to a later window
  std::size_t add(std::span<const events::Event> events);

  bool is_full() const { return is_full_; }
  /// Whether the events so far cover at least half of a window's length.
  bool is_half_full() const;
  double seconds() const;  ///< 1; up to the last event, if there are too many or it is not full
  std::span<const events::Event> events() const { return events_; }
  void clear();

 private:
  std::vector<events::Event> events_;
  bool is_full_ = false;
};

/// The scenes of a recording, window by window from its first event. A last window of less than half a second is left out.
/// @throws Error  as RecordingReader, or if the stream declares no size
std::vector<Scene> scenes_of(events::RecordingReader& recording, const events::MaskPixels& mask = {});

/// The lowest and the highest value of each figure in several runs. Background and hot pixels of a run are the medians over its
/// windows, because a touch can cover one.
struct SceneRanges {
  struct Range {
    double low = 0, high = 0;
    friend bool operator==(const Range&, const Range&) = default;
  };
  std::uint64_t runs = 0;
  Range background_hz, hot_pixels, flicker_depth;
  std::optional<Range> readout_us{};

  void add_run(std::span<const Scene> windows);  ///< nothing changes without windows
  friend bool operator==(const SceneRanges&, const SceneRanges&) = default;
};

/// {"runs": 10, "background_hz": [29100, 37200], "hot_pixels": [2, 9], "flicker_depth": [0, 0.06], "readout_us": [196.1, 201.2]}
void to_json(nlohmann::json& json, const SceneRanges& ranges);
void from_json(const nlohmann::json& json, SceneRanges& ranges);  ///< @throws Error

/// By which figures a scene leaves the ranges of the training runs, as a text: "background 167 kev/s, training 29 to 37; 130 hot
/// pixels, training 2 to 9". Empty if it does not. The range of n runs does not contain that of the next one, so a figure leaves
/// it only beyond a margin, which is ours:
///
///   background    above 1.5 times the highest, or below the lowest / 1.5
///   hot pixels    more than twice the highest number and 10
///   flicker       a depth above 1.5 times the deepest and 0.1
///   read-outs     a period 10 % beyond the range; none where all training runs have them, or the reverse
std::string departures(const Scene& scene, const SceneRanges& training);

/// The same of a run: those of the first window that makes `SceneState` leave, or of the only window. Empty if none does.
std::string departures(std::span<const Scene> windows, const SceneRanges& training);

/// What a scene changed to.
struct SceneChange {
  bool leaves = false;  ///< else it returns
  std::string text;     ///< "background 167 kev/s, training 29 to 37"
};

/// Follows a scene from window to window. It leaves the training runs, or returns to them, when `to_change` windows in a row
/// agree: one window may be covered by a touch.
class SceneState {
 public:
  static constexpr unsigned to_change = 2;

  explicit SceneState(const SceneRanges& training) : training_(training) {}

  /// The scene of the next window. @return  a change, if it makes one
  std::optional<SceneChange> next(const Scene& scene);

  bool is_outside() const { return outside_; }
  bool is_undecided() const { return disagreeing_ > 0; }  ///< the last window disagrees with the state

 private:
  SceneRanges training_;
  bool outside_ = false;
  unsigned disagreeing_ = 0;  ///< windows in a row
};

}  // namespace tactile::characterise
