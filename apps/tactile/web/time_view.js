// The part of a run that the time axis shows: {from_us, to_us}, inside {0, length_us}. Plain functions from one view to the next.

export const LEAST_SPAN_US = 1000; // a millisecond fills the screen at most

/// The view moved and cut so that it lies in the run and is at least a millisecond long.
export function fitted(view, length_us) {
  const whole = Math.max(length_us, LEAST_SPAN_US);
  const span = Math.min(Math.max(Math.round(view.to_us - view.from_us), LEAST_SPAN_US), whole);
  const from_us = Math.min(Math.max(Math.round(view.from_us), 0), whole - span);
  return { from_us, to_us: from_us + span };
}

export function wholeOf(length_us) {
  return fitted({ from_us: 0, to_us: length_us }, length_us);
}

/// `factor` 0.5 shows half as much. The time `at_us` stays where it is on the screen.
export function zoomed(view, at_us, factor, length_us) {
  const span = view.to_us - view.from_us;
  const wanted = Math.min(Math.max(span * factor, LEAST_SPAN_US), Math.max(length_us, LEAST_SPAN_US));
  const share = (at_us - view.from_us) / span;
  const from_us = at_us - share * wanted;
  return fitted({ from_us, to_us: from_us + wanted }, length_us);
}

/// Zoomed around `at_us` if the view has it, else around its middle; null is nowhere. Infinity shows the whole run.
export function zoomedAround(view, at_us, factor, length_us) {
  if (factor === Infinity) return wholeOf(length_us);
  const inside = at_us !== null && at_us >= view.from_us && at_us <= view.to_us;
  return zoomed(view, inside ? at_us : (view.from_us + view.to_us) / 2, factor, length_us);
}

export function panned(view, by_us, length_us) {
  return fitted({ from_us: view.from_us + by_us, to_us: view.to_us + by_us }, length_us);
}

export function around(at_us, span_us, length_us) {
  return fitted({ from_us: at_us - span_us / 2, to_us: at_us + span_us / 2 }, length_us);
}

/// The view itself if it shows `at_us` with a tenth to spare at the side it moves to, else moved on by most of its length.
export function following(view, at_us, length_us) {
  const span = view.to_us - view.from_us;
  if (at_us >= view.from_us && at_us <= view.to_us - 0.02 * span) return view;
  return fitted({ from_us: at_us - 0.1 * span, to_us: at_us + 0.9 * span }, length_us);
}

/// Where a time lies on the screen, in pixels from the left edge of the axis, and back.
export function pixelOf(us, view, width) {
  return ((us - view.from_us) / (view.to_us - view.from_us)) * width;
}

export function timeAt(pixel, view, width) {
  return Math.round(view.from_us + (pixel / width) * (view.to_us - view.from_us));
}
