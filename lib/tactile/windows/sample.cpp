#include "tactile/windows/sample.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/random.hpp"

namespace tactile {
namespace {

using TicksByTouch = std::array<std::vector<CameraTime>, touch_count>;

/// How far `us` lies above the multiple of `tick` at or below it.
std::int64_t remainder_of(std::int64_t us, microseconds tick) {
  const std::int64_t remainder = us % tick.count();
  return remainder < 0 ? remainder + tick.count() : remainder;
}

TicksByTouch ticks_of(std::span<const SampledInterval> intervals, CameraTime first_event, CameraTime last_event,
                      const SamplingOptions& options) {
  check(options);
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const TouchInterval& interval = intervals[i].interval;
    const bool in_order = i == 0 || intervals[i - 1].interval.end <= interval.start;
    if (interval.end < interval.start || interval.touch == Touch::none || !in_order) {
      throw Error("interval from " + std::to_string(us_of(interval.start)) + " to " + std::to_string(us_of(interval.end)) +
                  " us; expected presses and slips by start, none overlapping another");
    }
  }
  TicksByTouch ticks;
  const TickRange range = full_ticks(first_event, last_event, options.history, options.tick);
  if (const std::string why = why_too_many(range); !why.empty()) throw Error("samples: " + why);
  std::size_t current = 0;  // the first interval that ends, guard included, at or behind the tick
  for (std::int64_t index = 0; index < range.count; ++index) {
    const CameraTime t = range.at(index);
    while (current < intervals.size() && after(intervals[current].interval.end, options.guard) < t) ++current;
    bool guarded = false;
    // Guards overlap where intervals lie close; a later one may hold this tick too.
    for (std::size_t i = current; i < intervals.size() && before(intervals[i].interval.start, options.guard) < t; ++i) {
      const TouchInterval& interval = intervals[i].interval;
      guarded = guarded || t <= after(interval.end, options.guard);
      if (intervals[i].used && interval.contains(t) && t <= after(interval.start, options.window)) {
        ticks[static_cast<std::size_t>(interval.touch)].push_back(t);
      }
    }
    if (!guarded) ticks[static_cast<std::size_t>(Touch::none)].push_back(t);
  }
  return ticks;
}

}  // namespace

void to_json(nlohmann::json& json, const SamplingOptions& options) {
  json = {{"tick_us", options.tick.count()},
          {"window_us", options.window.count()},
          {"guard_us", options.guard.count()},
          {"history_us", options.history.count()},
          {"seed", options.seed}};
}

void from_json(const nlohmann::json& json, SamplingOptions& options) {
  const std::string where = "sampling settings";
  options.tick = microseconds{member<std::int64_t>(json, "tick_us", where)};
  options.window = microseconds{member<std::int64_t>(json, "window_us", where)};
  options.guard = microseconds{member<std::int64_t>(json, "guard_us", where)};
  options.history = microseconds{member<std::int64_t>(json, "history_us", where)};
  options.seed = member<std::uint64_t>(json, "seed", where);
}

void check(const SamplingOptions& options) {
  const auto text_of = [](microseconds d) { return std::to_string(d.count()) + " us"; };
  if (options.tick <= microseconds{0}) throw Error("tick of " + text_of(options.tick) + "; expected more than 0");
  if (options.window < options.tick)
    throw Error("window of " + text_of(options.window) + "; expected at least a tick, " + text_of(options.tick));
  if (options.guard < microseconds{0}) throw Error("guard of " + text_of(options.guard) + "; expected 0 or more");
  if (options.history <= microseconds{0} || options.history % options.tick != microseconds{0}) {
    throw Error("history of " + text_of(options.history) + "; expected a whole number of ticks of " + text_of(options.tick) +
                ", at least one");
  }
}

std::vector<Sample> balanced_samples(std::uint32_t run_index, std::span<const SampledInterval> intervals, CameraTime first_event,
                                     CameraTime last_event, std::uint64_t run_seed, const SamplingOptions& options) {
  TicksByTouch ticks = ticks_of(intervals, first_event, last_event, options);
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
                                                      CameraTime last_event, const SamplingOptions& options) {
  const TicksByTouch ticks = ticks_of(intervals, first_event, last_event, options);
  std::array<std::uint64_t, touch_count> counts{};
  std::transform(ticks.begin(), ticks.end(), counts.begin(), [](const auto& of_touch) { return of_touch.size(); });
  return counts;
}

CameraTime first_tick_from(CameraTime t, microseconds tick) {
  const std::int64_t above = remainder_of(us_of(t), tick);
  return above == 0 ? t : after(t, microseconds{tick.count() - above});
}

CameraTime last_tick_until(CameraTime t, microseconds tick) { return before(t, microseconds{remainder_of(us_of(t), tick)}); }

CameraTime TickRange::at(std::int64_t index) const {
  // From one end of the clock to the other is more than an int64 holds.
  const std::uint64_t on = static_cast<std::uint64_t>(tick.count()) * static_cast<std::uint64_t>(index);
  const std::uint64_t room = static_cast<std::uint64_t>(us_of(CameraTime::max())) - static_cast<std::uint64_t>(us_of(first));
  if (on > room) return CameraTime::max();
  return camera_time(static_cast<std::int64_t>(static_cast<std::uint64_t>(us_of(first)) + on));
}

std::string why_too_many(const TickRange& ticks) {
  if (ticks.count <= most_ticks) return "";
  return std::to_string(ticks.count) + " ticks of " + std::to_string(ticks.tick.count()) +
         " us from the first event to the last; expected at most " + std::to_string(most_ticks) +
         ": a piece of the recording ('tactile convert --from-us --to-us'), or times that are not damaged";
}

TickRange full_ticks(CameraTime first_event, CameraTime last_event, microseconds history, microseconds tick) {
  if (tick <= microseconds{0} || history < microseconds{0})
    throw Error("ticks of " + std::to_string(tick.count()) + " us; expected more than 0");
  TickRange range{.first = {}, .count = 0, .tick = tick};
  const CameraTime begin = after(first_event, history);
  const CameraTime first = first_tick_from(begin, tick), last = last_tick_until(last_event, tick);
  // Held at an end of the clock, a time is no tick any more: then no full tick is left there.
  const bool beyond =
      between(first_event, begin) != history || remainder_of(us_of(first), tick) != 0 || remainder_of(us_of(last), tick) != 0;
  if (beyond || first > last) return range;
  range.first = first;
  const std::uint64_t span = static_cast<std::uint64_t>(us_of(last)) - static_cast<std::uint64_t>(us_of(first));
  const std::uint64_t steps = span / static_cast<std::uint64_t>(tick.count());
  range.count = static_cast<std::int64_t>(std::min<std::uint64_t>(steps, std::numeric_limits<std::int64_t>::max() - 1) + 1);
  return range;
}

}  // namespace tactile
