// What a person looks at in one run, and what is half done. The parts of the run's page listen to it; none of them knows another.
//
// Events: "view" (the axis), "at" (the cursor), "labels", "selection", "draft" (a moved end that is not saved), "mark" (a touch that was
// begun by key), "playing".

import { around, fitted, following, wholeOf } from "./time_view.js";
import { edited } from "./label_edits.js";

export class RunState extends EventTarget {
  constructor({ run, queue, place, frames, at_us }) {
    super();
    this.run = run;
    this.queue = queue;
    this.frames = frames;
    this.length_us = Math.max(1, Math.round(run.length_s * 1e6));
    this.ticks = { tick_us: run.tick_us || 2000, tick_origin_us: run.tick_origin_us ?? 0 };
    this.place = place;
    const kept = place.load() ?? {};
    this.view = fitted(kept.view ?? wholeOf(this.length_us), this.length_us);
    this.at_us = this.#inside(at_us ?? kept.at_us ?? queue.shown.intervals[0]?.start_us ?? 0);
    if (at_us !== null && (at_us < this.view.from_us || at_us > this.view.to_us)) this.view = around(at_us, 200_000, this.length_us);
    this.draft = kept.draft ?? null; // {id, end, to_us, within_us, to, end_earlier}
    this.mark = kept.mark ?? null; // {touch, start_us, within_us}
    this.selected = kept.selected ?? null; // {id, end}
    this.history_us = run.history_us || 40_000;
    this.playing = false;
    this.events = { from_us: 0, to_us: 0, t_us: [] }; // single events around the view, for snapping
    queue.addEventListener("change", () => this.#labelsChanged());
    queue.addEventListener("named", ({ detail }) => {
      if (this.selected?.id === detail.from) this.select({ ...this.selected, id: detail.to });
    });
  }

  #inside(t) {
    return Math.min(Math.max(Math.round(t), 0), this.length_us);
  }

  #notify(name) {
    this.#keep();
    this.dispatchEvent(new Event(name));
  }

  #keep() {
    const { view, at_us, draft, mark, selected } = this;
    this.place.save({ view, at_us, draft, mark, selected });
  }

  #labelsChanged() {
    const has = (id) => this.queue.shown.intervals.some((interval) => interval.id === id);
    if (this.selected && !has(this.selected.id)) this.selected = null;
    if (this.draft && !has(this.draft.id)) this.draft = null;
    this.#notify("labels");
  }

  /// The labels as they will be, with the end that is being moved.
  get labels() {
    const shown = this.queue.shown;
    if (!this.draft || !shown.intervals.some((interval) => interval.id === this.draft.id)) return shown;
    return edited(shown, { kind: "move", ...this.draft });
  }

  interval(id = this.selected?.id) {
    return this.queue.shown.intervals.find((interval) => interval.id === id) ?? null;
  }

  setView(view) {
    this.view = fitted(view, this.length_us);
    this.#notify("view");
  }

  /// Moves the cursor. The axis follows, unless `still`.
  setAt(at_us, still = false) {
    this.at_us = this.#inside(at_us);
    const view = still ? this.view : following(this.view, this.at_us, this.length_us);
    const moved = view !== this.view;
    this.view = view;
    this.#notify("at");
    if (moved) this.#notify("view");
  }

  select(selected) {
    this.selected = selected;
    this.#notify("selection");
  }

  setDraft(draft) {
    this.draft = draft;
    this.#notify("draft");
  }

  setMark(mark) {
    this.mark = mark;
    this.#notify("mark");
  }

  setPlaying(playing) {
    this.playing = playing;
    this.#notify("playing");
  }

  /// All starts and ends by time, as {id, end, at_us}.
  get ends() {
    return this.labels.intervals
      .flatMap((i) => [
        { id: i.id, end: "start", at_us: i.start_us },
        { id: i.id, end: "end", at_us: i.end_us },
      ])
      .sort((a, b) => a.at_us - b.at_us);
  }
}
