#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/touch.hpp"

namespace tactile {

/// A moment to classify: what happens in a run at the tick `t`.
struct Sample {
  std::uint32_t run_index = 0;
  CameraTime t{};
  Touch touch = Touch::none;

  friend bool operator==(const Sample&, const Sample&) = default;
};

struct SamplingOptions {
  microseconds tick{2'000};      ///< between two ticks, > 0
  microseconds window{500'000};  ///< kept of each press and slip, >= tick
  microseconds guard{100'000};   ///< none keeps so far from every interval, >= 0
  microseconds history{50'000};  ///< none samples have so much recording before them; a whole number of ticks
  std::uint64_t seed = 1;
};

void to_json(nlohmann::json& json, const SamplingOptions& options);
void from_json(const nlohmann::json& json, SamplingOptions& options);  ///< @throws Error

/// @throws Error  if an option is out of its range
void check(const SamplingOptions& options);

/// An interval and whether its labels may be used; one that may not still keeps `none` away.
struct SampledInterval {
  TouchInterval interval;
  bool used = true;
};

/// The balanced samples of one run, ascending in time.
///
/// Only full ticks count: whole multiples of `tick` with t - history >= first_event and t <= last_event, as `full_ticks` has
/// them. Press and slip: those with start < t <= min(end, start + window) of each used interval. None: drawn at random from those
/// with t <= start - guard or t > end + guard for every interval. Every class is then cut at random to the size of the smallest.
///
/// @param intervals  by start, not overlapping
/// @return  none at all if a class has no tick
/// @throws Error  if an option is out of its range, the intervals overlap or are not by start, or there are over `most_ticks`
/// Source: Faris et al., arXiv:2403.10120, section IV.
std::vector<Sample> balanced_samples(std::uint32_t run_index, std::span<const SampledInterval> intervals, CameraTime first_event,
                                     CameraTime last_event, std::uint64_t run_seed, const SamplingOptions& options);

/// How many ticks of each class a run offers before they are balanced, by the value of Touch.
std::array<std::uint64_t, touch_count> ticks_on_offer(std::span<const SampledInterval> intervals, CameraTime first_event,
                                                      CameraTime last_event, const SamplingOptions& options);

/// The smallest tick >= t, and the largest <= t; ticks are whole multiples of `tick` of camera time, negative ones too. The end
/// of the clock, which need be no tick, where none lies before it.
CameraTime first_tick_from(CameraTime t, microseconds tick);
CameraTime last_tick_until(CameraTime t, microseconds tick);

/// How many ticks of a run are full: those with t - history >= first_event and t <= last_event.
struct TickRange {
  CameraTime first{};
  std::int64_t count = 0;
  microseconds tick{2'000};

  CameraTime at(std::int64_t index) const;  ///< of an index in [0, count]; held at the end of the clock
};
TickRange full_ticks(CameraTime first_event, CameraTime last_event, microseconds history, microseconds tick);

/// The most ticks that a recording is looked at as a whole, 55 hours of 2 ms: something is kept of each, and a recording that
/// seems to last longer most likely has a time that is none.
inline constexpr std::int64_t most_ticks = 100'000'000;

/// Why there are too many: "15768000000 ticks of 2000 us from its first event to its last; expected ..."; empty if there are not.
std::string why_too_many(const TickRange& ticks);

}  // namespace tactile
