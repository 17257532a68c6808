// Which time a person means who points near one: a tick, an event, a frame.

/// The index of the last of `times` (ascending) that is <= `at_us`; -1 if there is none.
export function lastUntil(times, at_us) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= at_us) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/// The tick nearest to `at_us`; of two, the earlier. Ticks are origin_us + n * tick_us.
export function nearestTick(at_us, { tick_us, tick_origin_us = 0 }) {
  const before = tick_origin_us + Math.floor((at_us - tick_origin_us) / tick_us) * tick_us;
  return at_us - before <= before + tick_us - at_us ? before : before + tick_us;
}

/// The tick after `at_us` (count 1), or before it (count -1), and so on: from between two ticks, the next one counts.
export function steppedTick(at_us, count, { tick_us, tick_origin_us = 0 }) {
  const place = (at_us - tick_origin_us) / tick_us;
  const from = count > 0 ? Math.floor(place) : Math.ceil(place);
  return tick_origin_us + (from + count) * tick_us;
}

/// The time in `times` nearest to `at_us`; of two, the earlier. null if there are none.
export function nearestOf(times, at_us) {
  if (times.length === 0) return null;
  const before = lastUntil(times, at_us);
  if (before < 0) return times[0];
  if (before + 1 >= times.length || at_us - times[before] <= times[before + 1] - at_us) return times[before];
  return times[before + 1];
}

/// `count` entries of `times` further from `at_us`, limited to the first and last. null if there are none.
export function steppedOf(times, at_us, count) {
  if (times.length === 0) return null;
  const before = lastUntil(times, at_us);
  const from = count < 0 && before >= 0 && times[before] < at_us ? before + 1 : before;
  return times[Math.min(Math.max(from + count, 0), times.length - 1)];
}

/// Half of the wider gap between an event and its neighbours: no one sees better than this where a touch began.
function halfGap(times, at_us) {
  const here = lastUntil(times, at_us);
  const before = here > 0 ? at_us - times[here - 1] : 0;
  const after = here + 1 < times.length ? times[here + 1] - at_us : 0;
  return Math.ceil(Math.max(before, after) / 2);
}

export const LEAST_WITHIN_US = 1000; // half a tick of 2 ms: as `tactile label --set` has it
export const REACTION_US = 200_000; // from what a person sees to the key; simple reactions take 0.2 s to 0.25 s

/// Where a drag to `at_us` ends, and how exactly: {to_us, within_us, to}.
///
/// @param mode   "events", "ticks", "nothing", or "automatic": events where they are known, else ticks
/// @param times  events around `at_us`, ascending; empty where the view is too long to load them
export function snapped(at_us, mode, ticks, times, us_per_pixel) {
  const seen = Math.max(LEAST_WITHIN_US, Math.round(2 * us_per_pixel));
  const events = (mode === "events" || mode === "automatic") && times.length > 0;
  if (events) {
    const to_us = nearestOf(times, at_us);
    return { to_us, within_us: Math.max(seen, halfGap(times, to_us)), to: "event" };
  }
  if (mode === "nothing") return { to_us: Math.round(at_us), within_us: seen, to: null };
  return { to_us: nearestTick(at_us, ticks), within_us: seen, to: "tick" };
}

/// The 95 % interval of a time that was marked by a key while the recording played at `speed`.
export function withinWhilePlaying(speed) {
  return Math.max(LEAST_WITHIN_US, Math.round(REACTION_US * speed));
}
