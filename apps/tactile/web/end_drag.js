// Moving a start or an end, by pointer or by key. While it moves it is a draft; it is saved when the pointer lets go, or by Enter.

import { announce } from "./dom.js";
import { secondsText, withinText } from "./format.js";
import { MOST_EVENT_TIMES_US } from "./detail.js";
import { limitsOf } from "./label_edits.js";
import { around } from "./time_view.js";
import { snapped, steppedOf, steppedTick } from "./snapping.js";

const SHOWN_AROUND_US = 200_000; // of the axis when a handle outside it gets the focus

export class EndDrag {
  /// @param save  (edit) => anything: sends a move
  constructor(state, snapMode, save) {
    this.state = state;
    this.snapMode = snapMode;
    this.save = save;
    this.held = null;
  }

  timeOf(id, end) {
    return this.state.labels.intervals.find((interval) => interval.id === id)?.[`${end}_us`] ?? 0;
  }

  begin(id, end) {
    const { draft } = this.state;
    if (draft && (draft.id !== id || draft.end !== end)) this.commit();
    this.held = { id, end };
    this.state.select({ id, end });
  }

  /// @param free  do not snap
  to(at_us, free, us_per_pixel) {
    const { id, end } = this.held;
    const mode = free ? "nothing" : this.snapMode();
    this.#draft(id, end, snapped(at_us, mode, this.state.ticks, this.#events(at_us), us_per_pixel));
  }

  /// The single events around a time, where they are loaded.
  #events(at_us) {
    const { from_us, to_us, t_us } = this.state.events;
    const view = this.state.view;
    return at_us >= from_us && at_us <= to_us && view.to_us - view.from_us <= MOST_EVENT_TIMES_US ? t_us : [];
  }

  #draft(id, end, { to_us, within_us, to }) {
    const intervals = this.state.queue.shown.intervals;
    const { low, high } = limitsOf(intervals, id, end, this.state.length_us);
    const place = Math.min(Math.max(to_us, low), high);
    const before = intervals[intervals.findIndex((interval) => interval.id === id) - 1];
    const end_earlier = end === "start" && before !== undefined && place < before.end_us;
    this.state.setDraft({ id, end, to_us: place, within_us, to: place === to_us ? to : null, ...(end_earlier ? { end_earlier } : {}) });
    this.state.setAt(place, true);
  }

  drop(cancelled) {
    this.held = null;
    if (cancelled) this.discard();
    else this.commit();
  }

  /// Saves the draft, if there is one and it moved.
  commit() {
    const { draft } = this.state;
    if (!draft) return;
    this.state.setDraft(null);
    const { to, ...move } = draft;
    if (this.timeOf(draft.id, draft.end) === draft.to_us) return;
    this.save({ kind: "move", ...move });
  }

  discard() {
    if (!this.state.draft) return;
    this.state.setDraft(null);
    announce("The end is back where it was.");
  }

  /// The handle has the focus: the axis shows it.
  focused(id, end) {
    const at_us = this.timeOf(id, end);
    this.state.select({ id, end });
    const { view, length_us } = this.state;
    if (at_us < view.from_us || at_us > view.to_us)
      this.state.setView(around(at_us, Math.min(SHOWN_AROUND_US, view.to_us - view.from_us), length_us));
  }

  /// Keys of a handle that has the focus: arrows move by a tick, with Shift by an event, with Alt by 100 µs.
  key(event, id, end) {
    const direction = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 }[event.key];
    if (direction && !event.ctrlKey && !event.metaKey) this.nudge(id, end, direction, event);
    else if (event.key === "Enter") this.commit();
    else if (event.key === "Escape" && this.state.draft) this.discard();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /// Moves an end by `count` ticks, events or tenths of a millisecond.
  nudge(id, end, count, { shiftKey = false, altKey = false } = {}) {
    this.begin(id, end);
    const at = this.timeOf(id, end);
    const events = this.#events(at);
    const us_per_pixel = 0; // a key is exact; what the person can see is taken from the least interval
    if (shiftKey && events.length)
      this.#draft(id, end, snapped(steppedOf(events, at, count), "events", this.state.ticks, events, us_per_pixel));
    else if (altKey) this.#draft(id, end, snapped(at + 100 * count, "nothing", this.state.ticks, [], us_per_pixel));
    else this.#draft(id, end, snapped(steppedTick(at, count, this.state.ticks), "nothing", this.state.ticks, [], us_per_pixel));
    this.held = null;
  }
}

/// The draft in words, with its 95 % interval.
export function draftWords(draft, was_us) {
  const within = withinText(draft.to_us - draft.within_us, draft.to_us, draft.to_us + draft.within_us);
  const place = draft.to ? ` (nearest ${draft.to})` : "";
  return `${draft.end} of ${draft.id}: ${secondsText(was_us)} → ${secondsText(draft.to_us)}${place}, ${within}`;
}
