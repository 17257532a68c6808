#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "tactile/core/fields.hpp"
#include "tactile/core/touch.hpp"

namespace tactile::windows {

/// A tick of a run, with its class.
struct Sample {
  std::uint32_t run_index = 0;
  CameraTime t{};
  Touch touch = Touch::none;

  friend bool operator==(const Sample&, const Sample&) = default;
};

struct SamplingOptions {
  microseconds tick{2'000};      ///< between two ticks, > 0
  microseconds window{500'000};  ///< the first part of each press and slip that is used, >= tick
  microseconds guard{100'000};   ///< distance of `none` from every interval, >= 0
  microseconds history{50'000};  ///< recording before every sample; a whole number of ticks
  std::uint64_t seed = 1;
};

template <class Fields>
void list_fields(Fields& fields, SamplingOptions& o) {
  fields("window_us", o.window, 1, 1'000'000'000,
         {.name = "window-ms", .meaning = "Part of each press and slip to use, from its onset [ms]", .us = 1000});
  fields("guard_us", o.guard, 0, 1'000'000'000,
         {.name = "guard-ms", .meaning = "Distance of none samples from every press and slip [ms]", .us = 1000});
  fields("history_us", o.history, 1, 100'000'000,
         {.name = "history-ms",
          .meaning = "Time before each sample whose events are stored [ms]. No t_h can be longer",
          .us = 1000});
  fields("tick_us", o.tick, 1, 1'000'000, {"tick-us", "Time between two ticks [us]"});
  fields("seed", o.seed, {"seed", "Seed of the random draw"});
}

/// @throws Error  if an option is out of its range
void check(const SamplingOptions& options);

/// An interval, and whether its labels may be used. An unused interval still keeps `none` away.
struct SampledInterval {
  TouchInterval interval;
  bool used = true;
};

/// The balanced samples of one run, ascending in time.
///
/// Only full ticks count (`full_ticks`): whole multiples of `tick` with t - history >= first_event and t <= last_event. Press and
/// slip: ticks with start < t <= min(end, start + window) of each used interval. None: ticks with t <= start - guard or t > end +
/// guard for every interval and every release. Every class is then reduced at random to the size of the smallest.
///
/// @param intervals  by start, not overlapping
/// @param releases   motion without a class: no `none` near it; any order
/// @return  empty if a class has no tick
/// @throws Error  if an option is out of its range, the intervals overlap or are not sorted by start, or there are over
/// `most_ticks` Source: Faris et al., arXiv:2403.10120, section IV.
std::vector<Sample> balanced_samples(std::uint32_t run_index, std::span<const SampledInterval> intervals, CameraTime first_event,
                                     CameraTime last_event, std::uint64_t run_seed, const SamplingOptions& options,
                                     std::span<const TouchInterval> releases = {});

/// The number of ticks of each class before balancing, by the value of Touch.
std::array<std::uint64_t, touch_count> ticks_on_offer(std::span<const SampledInterval> intervals, CameraTime first_event,
                                                      CameraTime last_event, const SamplingOptions& options,
                                                      std::span<const TouchInterval> releases = {});

}  // namespace tactile::windows
