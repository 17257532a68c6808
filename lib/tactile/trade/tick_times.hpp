#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/trade/trade_setting.hpp"

namespace tactile {

/// What one tick took on one thread [us].
struct TickTime {
  float counting = 0;        ///< the window moved on: events that come, and events that go
  float rendering = 0;       ///< its heatmap
  float network = 0;         ///< logits
  std::uint64_t events = 0;  ///< in [t_c - t_h, t_c)

  /// All of it, or the counting alone where the gate closes.
  double total(std::optional<std::uint64_t> gate) const {
    return gate && events < *gate ? counting : static_cast<double>(counting) + rendering + network;
  }
};

/// Something to be timed: gate and confirmation aside, which cost next to nothing themselves.
struct TimedWay {
  HeatmapOptions rendering;
  EngineKind engine = EngineKind::fast;
  Precision precision = Precision::fp32;
  bool sparse = true;
  std::filesystem::path model;  ///< the bundle

  friend bool operator==(const TimedWay&, const TimedWay&) = default;
};

struct TickTimesOptions {
  unsigned pieces = 60;  ///< of each run, spread evenly over it, the same for every way, > 0
  unsigned ticks = 1;    ///< of each piece, behind a full history and a tick that warms up, > 0
  unsigned turns = 3;    ///< the median counts, > 0
};

/// The times of one way: those of each recording in their order.
using TimesOfRuns = std::vector<std::vector<TickTime>>;

/// Times all ways in this process on this thread: piece by piece of each recording, every way takes its turn before any
/// takes its next, in another order each time, so that what else the machine does falls on all alike. Of each tick the turn of
/// median length counts: not the shortest, which nobody can count on.
/// @throws Error  if a recording or a model cannot be read, or does not fit the other
std::vector<TimesOfRuns> time_ticks(std::span<const TimedWay> ways, std::span<const std::filesystem::path> recordings,
                                    const TickTimesOptions& options = {}, const ProgressCallback& progress = {});

void write_times(const std::filesystem::path& file, std::span<const TimesOfRuns> ways);
std::vector<TimesOfRuns> read_times(const std::filesystem::path& file);  ///< @throws Error  if it is no such file

}  // namespace tactile
