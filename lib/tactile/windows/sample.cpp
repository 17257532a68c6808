#include "tactile/windows/sample.hpp"

#include <algorithm>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/ticks.hpp"

namespace tactile::windows {
namespace {

using TicksByTouch = std::array<std::vector<CameraTime>, touch_count>;

TicksByTouch ticks_of(std::span<const SampledInterval> intervals, CameraTime first_event, CameraTime last_event,
                      const SamplingOptions& options, std::span<const TouchInterval> releases) {
  check(options);
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const TouchInterval& interval = intervals[i].interval;
    const bool in_order = i == 0 || intervals[i - 1].interval.end <= interval.start;
    if (interval.end < interval.start || interval.touch == Touch::none || !in_order) {
      throw Error("interval from " + std::to_string(us_of(interval.start)) + " to " + std::to_string(us_of(interval.end)) +
                  " us; expected presses and slips sorted by start, without overlap");
    }
  }
  TicksByTouch ticks;
  const TickRange range = full_ticks(first_event, last_event, options.history, options.tick);
  if (const std::string why = why_too_many(range); !why.empty()) throw Error("samples: " + why);
  std::size_t current = 0;  // the first interval that ends, guard included, at or after the tick
  for (std::int64_t index = 0; index < range.count; ++index) {
    const CameraTime t = range.at(index);
    while (current < intervals.size() && after(intervals[current].interval.end, options.guard) < t) ++current;
    bool guarded = false;
    // Guards of close intervals overlap, so a later interval may contain this tick too.
    for (std::size_t i = current; i < intervals.size() && before(intervals[i].interval.start, options.guard) < t; ++i) {
      const TouchInterval& interval = intervals[i].interval;
      guarded = guarded || t <= after(interval.end, options.guard);
      if (intervals[i].used && interval.contains(t) && t <= after(interval.start, options.window)) {
        ticks[static_cast<std::size_t>(interval.touch)].push_back(t);
      }
    }
    const auto is_near = [&](const TouchInterval& release) {
      return before(release.start, options.guard) < t && t <= after(release.end, options.guard);
    };
    if (!guarded && std::none_of(releases.begin(), releases.end(), is_near))
      ticks[static_cast<std::size_t>(Touch::none)].push_back(t);
  }
  return ticks;
}

}  // namespace

void check(const SamplingOptions& options) {
  check_fields(options, "sampling");
  const auto text_of = [](microseconds d) { return std::to_string(d.count()) + " us"; };
  if (options.window < options.tick)
    throw Error("window of " + text_of(options.window) + "; expected at least a tick, " + text_of(options.tick));
  if (options.history % options.tick != microseconds{0}) {
    throw Error("history of " + text_of(options.history) + "; expected a whole number of ticks of " + text_of(options.tick));
  }
}

std::vector<Sample> balanced_samples(std::uint32_t run_index, std::span<const SampledInterval> intervals, CameraTime first_event,
                                     CameraTime last_event, std::uint64_t run_seed, const SamplingOptions& options,
                                     std::span<const TouchInterval> releases) {
  TicksByTouch ticks = ticks_of(intervals, first_event, last_event, options, releases);
  std::size_t smallest = ticks[0].size();
  for (const auto& of_touch : ticks) smallest = std::min(smallest, of_touch.size());
  std::vector<Sample> samples;
  for (const Touch touch : all_touches) {
    auto& of_touch = ticks[static_cast<std::size_t>(touch)];
    Random random(seed_for(run_seed, {name_of(touch)}));
    random.shuffle(of_touch);
    for (std::size_t i = 0; i < smallest; ++i) samples.push_back({run_index, of_touch[i], touch});
  }
  std::sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) { return a.t < b.t; });
  return samples;
}

std::array<std::uint64_t, touch_count> ticks_on_offer(std::span<const SampledInterval> intervals, CameraTime first_event,
                                                      CameraTime last_event, const SamplingOptions& options,
                                                      std::span<const TouchInterval> releases) {
  const TicksByTouch ticks = ticks_of(intervals, first_event, last_event, options, releases);
  std::array<std::uint64_t, touch_count> counts{};
  std::transform(ticks.begin(), ticks.end(), counts.begin(), [](const auto& of_touch) { return of_touch.size(); });
  return counts;
}

}  // namespace tactile::windows
