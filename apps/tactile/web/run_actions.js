// What a person can do with the labels of a run. Buttons, keys and lists all call these.

import { announce, ask, el } from "./dom.js";
import { secondsText } from "./format.js";
import { around } from "./time_view.js";
import { LEAST_WITHIN_US, steppedOf, steppedTick, withinWhilePlaying } from "./snapping.js";
import { limitsOf } from "./label_edits.js";
import { keptPlace } from "./kept.js";

const CLOSE_US = 60_000; // of the axis when a person goes to an onset: 30 ms before and after

export class RunActions {
  constructor({ state, player, drag, reason }) {
    Object.assign(this, { state, player, drag, reason });
    this.added = 0;
  }

  /// Every edit goes through here: it is shown at once and sent at once.
  make(edit, why = this.reason.take()) {
    this.state.queue.add({ op: "edit", edit, why });
  }

  #selected() {
    const interval = this.state.interval();
    if (!interval) announce("Select an interval first: click it, or press N.");
    return interval;
  }

  undo() {
    if (this.state.draft) return this.drag.discard();
    const { queue } = this.state;
    if (!queue.waiting.length && !queue.labels.can_undo) return announce("There is nothing to undo.");
    return queue.add({ op: "undo" });
  }

  redo() {
    const { queue } = this.state;
    if (!queue.waiting.length && !queue.labels.can_redo) return announce("There is nothing to redo.");
    return queue.add({ op: "redo" });
  }

  /// How exactly a person marks a time with a key right now.
  #within() {
    return this.state.playing ? withinWhilePlaying(this.player.speed) : LEAST_WITHIN_US;
  }

  /// Puts the selected interval's start or end at the cursor.
  setEnd(end) {
    const interval = this.#selected();
    if (!interval) return;
    this.drag.discard();
    const { low, high } = limitsOf(this.state.queue.shown.intervals, interval.id, end, this.state.length_us);
    const to_us = this.state.at_us;
    if (to_us < low || to_us > high) {
      announce(`The ${end} of ${interval.id} can be from ${secondsText(low)} to ${secondsText(high)}.`, "error");
      return;
    }
    const earlier = this.state.queue.shown.intervals.find(
      (other) => other.id !== interval.id && other.start_us < to_us && to_us < other.end_us,
    );
    this.make({
      kind: "move",
      id: interval.id,
      end,
      to_us,
      within_us: this.#within(),
      ...(end === "start" && earlier ? { end_earlier: true } : {}),
    });
    this.state.select({ id: interval.id, end });
  }

  /// Begins a touch at the cursor; the second call ends it there.
  mark(touch) {
    const { state } = this;
    if (!state.labels.version) return announce("Label this run first: the button above does it.");
    if (!state.mark || state.mark.touch !== touch) {
      state.setMark({ touch, start_us: state.at_us, within_us: this.#within() });
      announce(`A ${touch} begins at ${secondsText(state.at_us)}. Press the same key at its end, Escape to discard.`);
      return;
    }
    const { start_us, within_us } = state.mark;
    if (state.at_us <= start_us) return announce("The end must lie after the start: move the cursor on.", "error");
    const later = state.queue.shown.intervals.find((other) => other.start_us >= start_us && other.start_us < state.at_us);
    if (later)
      return announce(`${later.id} begins before that end. End the ${touch} at ${secondsText(later.start_us)} or before.`, "error");
    const earlier = state.queue.shown.intervals.some((other) => other.start_us < start_us && start_us < other.end_us);
    const local_id = `new ${touch} ${++this.added}`;
    state.setMark(null);
    this.make({
      kind: "add",
      touch,
      start_us,
      end_us: state.at_us,
      within_us: Math.max(within_us, this.#within()),
      local_id,
      ...(earlier ? { end_earlier: true } : {}),
    });
    state.select({ id: local_id, end: "start" });
  }

  escape() {
    if (this.state.mark) {
      this.state.setMark(null);
      announce("The begun touch is discarded.");
    } else {
      this.drag.discard();
    }
  }

  remove(id = this.#selected()?.id) {
    if (!id) return;
    this.make({ kind: "reject", id });
    announce(`${id} is removed. U brings it back.`);
  }

  changeClass(id = this.#selected()?.id, touch = null) {
    const interval = id && this.state.interval(id);
    if (interval) this.make({ kind: "class", id, touch: touch ?? (interval.touch === "press" ? "slip" : "press") });
  }

  confirm(id = this.#selected()?.id) {
    if (!id) return;
    this.drag.commit();
    this.make({ kind: "confirm", id });
  }

  confirmRun() {
    this.drag.commit();
    this.make({ kind: "confirm-run" });
    announce("The run is confirmed: its intervals and flags are right. U takes that back.");
  }

  /// Asks for the reason, and lifts the flag. A reload keeps the words that were typed.
  async lift(flag) {
    const kept = keptPlace(`reason:${this.state.run.name}`);
    const left = kept.load();
    const reason = el("input", {
      type: "text",
      id: "reason",
      maxlength: 500,
      required: true,
      autofocus: true,
      value: left?.flag === flag.what ? left.reason : "",
      oninput: () => kept.save({ flag: flag.what, reason: reason.value }),
    });
    const content = el(
      "div",
      {},
      el("p", {}, `The flag says: ${flag.what}.`),
      el("label", { for: "reason" }, "Why is the label right all the same?"),
      reason,
    );
    const answer = await ask("Lift this flag", content, [
      { words: "Lift the flag", value: "lift", kind: "primary" },
      { words: "Cancel", value: null },
    ]);
    kept.save(null);
    if (answer !== "lift") return;
    if (!reason.value.trim()) return announce("A flag is lifted only with a reason.", "error");
    this.make({ kind: "lift", flag: flag.index, flag_what: flag.what, flag_interval: flag.interval_id ?? null }, reason.value.trim());
  }

  /// The first flag that is open, of the selected interval if it has one.
  liftFirst() {
    const open = this.state.labels.flags.filter((flag) => !flag.confirmed);
    const flag = open.find((f) => f.interval_id === this.state.selected?.id) ?? open[0];
    if (flag) this.lift(flag);
    else announce("No flag is open.");
  }

  // Going through the run

  stepTick(count) {
    this.player.pause();
    this.state.setAt(steppedTick(this.state.at_us, count, this.state.ticks));
  }

  stepFrame(count) {
    this.player.pause();
    const to = steppedOf(this.state.frames, this.state.at_us, count);
    if (to === null) announce("This run has no film.");
    else this.state.setAt(to);
  }

  stepEvent(count) {
    this.player.pause();
    const to = steppedOf(this.state.events.t_us, this.state.at_us, count);
    if (to === null) announce("Zoom in to 0.1 s or less to step by event.");
    else this.state.setAt(to);
  }

  /// Goes to the next start or end, and shows it closely.
  goToEnd(direction) {
    const { ends, at_us, selected } = this.state;
    if (!ends.length) return announce("The run has no intervals.");
    const here = ends.findIndex((end) => end.id === selected?.id && end.end === selected.end && end.at_us === at_us);
    let next =
      here >= 0
        ? ends[here + direction]
        : direction > 0
          ? ends.find((end) => end.at_us >= at_us)
          : ends.findLast((end) => end.at_us <= at_us);
    next ??= direction > 0 ? ends[0] : ends.at(-1);
    this.player.pause();
    this.state.select({ id: next.id, end: next.end });
    this.showClosely(next.at_us);
    return announce(`${next.end} of ${next.id}, ${secondsText(next.at_us)}`);
  }

  showClosely(at_us) {
    this.state.setView(around(at_us, CLOSE_US, this.state.length_us));
    this.state.setAt(at_us, true);
  }
}
