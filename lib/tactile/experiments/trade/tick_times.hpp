#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/experiments/trade/trade_setting.hpp"
#include "tactile/model/inference/classifier.hpp"

namespace tactile::trade {

inline float us_between(std::chrono::steady_clock::time_point begin, std::chrono::steady_clock::time_point end) {
  return std::chrono::duration<float, std::micro>(end - begin).count();
}

/// Duration of one tick on one thread [us].
struct TickTime {
  float counting = 0;               ///< of moving the window: adding new events, removing old ones
  float rendering = 0;              ///< of the model's input, such as a heatmap
  float network = 0;                ///< of the logits, of any kind of model
  std::uint32_t events = 0;         ///< in [t_c - t_h, t_c)
  std::uint32_t interruptions = 0;  ///< how often another program took the processor from this thread

  double total() const { return static_cast<double>(counting) + rendering + network; }
};

/// The part of a setting that costs time.
struct TimedSetting {
  heatmaps::HeatmapOptions rendering;
  model::EngineKind engine = model::EngineKind::fast;
  model::Precision precision = model::Precision::fp32;
  std::filesystem::path model;  ///< the bundle

  friend bool operator==(const TimedSetting&, const TimedSetting&) = default;
};

struct TickTimesOptions {
  std::uint64_t ticks = 20'000;  ///< of each setting at least, over all recordings and turns, > 0
  unsigned pieces = 20;          ///< of each recording, spread evenly over it, the same for every setting, > 0
  unsigned turns = 3;            ///< of each setting in each piece; more where the piece has too few ticks, > 0
};

/// The times of one setting, by recording.
using TimesOfRuns = std::vector<std::vector<TickTime>>;

/// A model on the events of a sensor, on one thread.
using TimedModel =
    std::function<std::unique_ptr<model::EventClassifier>(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering)>;
using OpenTimedModel = std::function<TimedModel(const TimedSetting&)>;

/// Opens the model of a setting. @throws Error  if it cannot be read
TimedModel open_timed_model(const TimedSetting& setting);

/// Times all settings in this process on this thread. In each piece of a recording, every setting takes one turn before any takes
/// the next, in another order each time: other load on the machine affects all settings alike. A turn begins with a full history
/// and a tick to warm up. Every tick of every turn is in the result, however long it took; a recording in which no history fits
/// has none.
/// @param open  called once for each setting with another model
/// @throws Error  if a recording or a model cannot be read, or does not fit the other
std::vector<TimesOfRuns> time_ticks(std::span<const TimedSetting> settings, std::span<const std::filesystem::path> recordings,
                                    const TickTimesOptions& options = {}, const ProgressCallback& progress = {},
                                    const OpenTimedModel& open = open_timed_model);

/// Keeps times: a line of JSON with the number of ticks of each setting and recording, then 20 bytes for each tick (three float32
/// and two uint32 as in `TickTime`, little-endian).
void write_times(const std::filesystem::path& file, std::span<const TimesOfRuns> times);
std::vector<TimesOfRuns> read_times(const std::filesystem::path& file);  ///< @throws Error  if it has another form

}  // namespace tactile::trade
