// Which samples of the signals to ask for: as many as the screen shows, a little further than it shows.

import { shortNumber } from "./format.js";

/// What to load next, or null if `loaded` is good enough for `view`.
///
/// A request covers the view and half its length at each side, so that a short pan needs no new one. Loaded samples are good enough if they
/// cover the view and are at most twice as coarse as the screen; a fetch of a window that is far longer than the view would be.
///
/// Rates are means over a hundredth of the view, so that noise of counts does not hide where they rise.
///
/// @param loaded  {from_us, to_us, points, smooth_us} of the last answer, or null
/// @param pixels  width of the axis: two samples per pixel are wasted, one is needed
export function neededSamples(view, length_us, loaded, pixels) {
  const span = view.to_us - view.from_us;
  if (loaded && loaded.from_us <= view.from_us && loaded.to_us >= view.to_us) {
    const wanted = span / Math.max(pixels, 1);
    const have = (loaded.to_us - loaded.from_us) / loaded.points;
    if (have <= 2 * wanted && 2 * loaded.smooth_us >= smoothFor(span)) return null;
  }
  const from_us = Math.max(0, Math.round(view.from_us - span / 2));
  const to_us = Math.min(Math.max(length_us, view.to_us), Math.round(view.to_us + span / 2));
  const points = Math.min(4000, Math.max(200, Math.round((pixels * (to_us - from_us)) / span)));
  return { from_us, to_us, points, smooth_us: smoothFor(span) };
}

const smoothFor = (span) => Math.round(span / 100);

export const MOST_EVENT_TIMES_US = 100_000; // the server lists single events of at most this window, and at most 20 000 of them

/// The window whose single events to load for snapping at `at_us`, or null: the view is too long, or they are there.
///
/// @param most_us  the longest window that the server lists here: dense events need a shorter one
export function neededEventTimes(view, at_us, length_us, loaded, most_us = MOST_EVENT_TIMES_US) {
  const span = view.to_us - view.from_us;
  if (span > MOST_EVENT_TIMES_US) return null;
  const near = Math.min(span, most_us / 4);
  const from = Math.max(view.from_us, Math.min(at_us, view.to_us) - near);
  const to = Math.min(view.to_us, Math.max(at_us, view.from_us) + near);
  if (loaded && loaded.from_us <= from && loaded.to_us >= to) return null;
  const middle = span <= most_us / 2 ? (view.from_us + view.to_us) / 2 : (from + to) / 2;
  const from_us = Math.max(0, Math.round(middle - most_us / 2));
  return { from_us, to_us: Math.min(Math.max(length_us, view.to_us), from_us + Math.floor(most_us)) };
}

/// The rows of a chart: [seconds, [min, mean, max]], each as `shown` gives it. A gap in the samples stays a gap.
export function rowsOf(series, shown = (value) => value) {
  const rows = [];
  for (let i = 0; i < series.t_us.length; ++i) {
    const mean = series.mean[i];
    const bar = mean === null ? [null, null, null] : [series.min[i], mean, series.max[i]].map(shown);
    rows.push([series.t_us[i] / 1e6, bar]);
  }
  return rows;
}

/// The labels of an axis of square roots up to `most`: round numbers, at least `apart` from each other on it.
export function rootTicks(most, apart) {
  const ticks = [{ v: 0, label: "0" }];
  for (let power = -3; 10 ** power <= most ** 2; ++power) {
    for (const digit of [1, 2, 5]) {
      const value = digit * 10 ** power;
      const v = Math.sqrt(value);
      if (v <= most && v - ticks.at(-1).v >= apart) ticks.push({ v, label: shortNumber(value).replace(/\.0+$/, "") });
    }
  }
  return ticks;
}
