// The head of a run's page and its tools: state of the run, play, snap, model, undo; and what is begun and not saved.

import { button, el, refill } from "./dom.js";
import { counted, secondsText } from "./format.js";
import { SPEEDS } from "./player.js";
import { splitAddress } from "./router.js";
import { showRunHelp } from "./keys.js";
import { keptPlace } from "./kept.js";

const SNAPS = { automatic: "event, else tick", events: "event", ticks: "tick", nothing: "nothing" };
const SAVED = { saved: "All saved", saving: "Saving …", lost: "Not saved: no answer", conflict: "Not saved: changed meanwhile" };

/// A list to choose from; `options` are [value, words].
function choice(id, options, chosen, onchange) {
  return el("select", { id, onchange: (event) => onchange(event.target.value) },
    options.map(([value, words]) => el("option", { value, selected: value === chosen }, words)));
}

export class RunBar {
  constructor({ state, page, who, player }) {
    Object.assign(this, { state, page, who, player });
    this.head = el("div", { class: "run-head" });
    this.tools = el("div", { class: "tools", role: "toolbar", "aria-label": "Play and edit" });
    this.choices = el("div", { class: "choices" });
    this.draft = el("div", { class: "draft", role: "status", hidden: true });
    this.time = el("output", { class: "time-now", "aria-label": "Cursor" });
    this.why = el("input", {
      type: "text",
      id: "why",
      placeholder: "reason of the next edit (optional)",
      "aria-label": "Reason of the next edit",
      maxlength: 500,
    });
    const kept = keptPlace(`why:${state.run.name}`);
    this.why.value = kept.load() ?? "";
    this.why.addEventListener("input", () => kept.save(this.why.value || null));
    this.keptWhy = kept;
  }

  /// The reason that was typed for the next edit; it is used once.
  take() {
    const reason = this.why.value.trim();
    this.why.value = "";
    this.keptWhy.save(null);
    return reason;
  }

  start(actions) {
    this.actions = actions;
    const { state } = this;
    this.#buildHead();
    this.#buildTools();
    for (const name of ["labels", "draft", "mark", "playing", "at"]) state.addEventListener(name, () => this.#update(name));
    for (const name of ["labels", "draft", "playing", "at"]) this.#update(name);
  }

  #buildHead() {
    const { page } = this;
    this.badge = el("span", { class: "state" });
    this.saved = button("", () => page.decide(), { class: "saved" });
    this.confirm = button("Confirm the run", () => this.actions.confirmRun(), { class: "primary", title: "Shift C" });
    refill(
      this.head,
      el("h1", {}, page.name),
      this.badge,
      el("a", { href: splitAddress(page.name) }, "Cut into runs"),
      el("span", { class: "spacer" }),
      this.saved,
      this.who ? el("span", { class: "who" }, `as ${this.who}`) : null,
      this.confirm,
      button("Next to review ›", () => page.goToNext(1), { title: "F" }),
      button("?", () => showRunHelp(page.keys), { "aria-label": "Keys", title: "Keys (?)" }),
    );
  }

  #buildTools() {
    const { state, page } = this;
    const group = (...parts) => el("span", { class: "group" }, parts);
    const models = state.run.models ?? [];
    const model = choice("model", [["", "none"], ...models.map((name) => [name, name])], page.chosenModel ?? "", (name) => page.chooseModel(name || null));
    const snap = choice("snap", Object.entries(SNAPS), page.snap.load(), (mode) => page.snap.save(mode));
    refill(this.tools, group(this.#playTools()), group(this.#stepTools()), group(this.#viewTools()), group(this.#editTools()), group(this.#undoTools()),
      group(el("label", { for: "snap" }, "Snap to"), snap));
    const hint = el("p", { class: "hint" }, `${state.labels.version ? "Drag a start or end to move it. N: the next one. " : ""}Space: play. ?: all keys.`);
    refill(this.choices, this.draft, hint, models.length ? group(el("label", { for: "model" }, "Model"), model) : null);
    this.showFrames();
  }

  #playTools() {
    const { page, player } = this;
    this.play = button("▶ Play", () => player.toggle(), { class: "play", title: "Space" });
    this.speed = choice("speed", SPEEDS.map((speed) => [String(speed), `× ${speed}`]), String(player.speed), (speed) => {
      player.speed = Number(speed);
      page.speed.save(player.speed);
    });
    this.speed.setAttribute("aria-label", "Speed");
    this.speed.title = "< and >";
    return [this.play, this.speed, this.time];
  }

  #stepTools() {
    const { actions } = this;
    this.frames = el("span", { class: "group" },
      button("‹ frame", () => actions.stepFrame(-1), { "aria-label": "One film frame back", title: "," }),
      button("frame ›", () => actions.stepFrame(1), { "aria-label": "One film frame forward", title: "." }));
    return [
      button("‹ tick", () => actions.stepTick(-1), { "aria-label": "One tick back", title: "←" }),
      button("tick ›", () => actions.stepTick(1), { "aria-label": "One tick forward", title: "→" }),
      this.frames,
    ];
  }

  #viewTools() {
    const { actions, page } = this;
    return [
      button("−", () => page.timeline.zoom(2), { "aria-label": "Zoom out", title: "↓" }),
      button("+", () => page.timeline.zoom(0.5), { "aria-label": "Zoom in", title: "↑" }),
      button("Whole run", () => page.timeline.zoom(Infinity), { title: "0" }),
      button("‹ end", () => actions.goToEnd(-1), { "aria-label": "The start or end before", title: "Shift N" }),
      button("end ›", () => actions.goToEnd(1), { "aria-label": "The next start or end", title: "N" }),
    ];
  }

  #editTools() {
    const { actions } = this;
    return [
      button("Press here", () => actions.mark("press"), { class: "press", title: "P: begin, and again: end" }),
      button("Slip here", () => actions.mark("slip"), { class: "slip", title: "S: begin, and again: end" }),
      button("Start here", () => actions.setEnd("start"), { title: "I: the selected interval starts at the cursor" }),
      button("End here", () => actions.setEnd("end"), { title: "O: the selected interval ends at the cursor" }),
    ];
  }

  #undoTools() {
    this.undo = button("Undo", () => this.actions.undo(), { title: "U or Ctrl Z" });
    this.redo = button("Redo", () => this.actions.redo(), { title: "R or Ctrl Y" });
    return [this.undo, this.redo];
  }

  showFrames() {
    this.frames.hidden = this.state.frames.length === 0;
  }

  showSpeed() {
    this.speed.value = String(this.player.speed);
  }

  #update(name) {
    const { state, page } = this;
    if (name === "at") {
      this.time.textContent = secondsText(state.at_us);
      if (state.mark) this.#begun();
    } else if (name === "playing") {
      this.play.textContent = state.playing ? "❚❚ Pause" : "▶ Play";
    } else if (name === "draft" || name === "mark") {
      this.#begun();
    } else {
      this.#labels(state.queue, page);
    }
  }

  #labels(queue) {
    const { intervals, flags } = queue.shown;
    const open = flags.filter((flag) => !flag.confirmed).length;
    const unconfirmed = intervals.filter((interval) => !interval.confirmed).length;
    const done = open === 0 && unconfirmed === 0;
    this.badge.className = `state ${open ? "flagged" : done && intervals.length ? "confirmed" : ""}`;
    this.badge.textContent =
      intervals.length + flags.length === 0
        ? queue.labels.version ? "no intervals" : "no labels"
        : open
          ? `⚑ ${counted(open, "open flag")}`
          : done
            ? "✓ confirmed"
            : `${counted(unconfirmed, "interval")} not confirmed`;
    this.confirm.disabled = done;
    this.saved.textContent = SAVED[queue.state] + (queue.waiting.length ? ` (${counted(queue.waiting.length, "edit")})` : "");
    this.saved.className = `saved ${queue.state}`;
    this.saved.disabled = queue.state !== "conflict";
    this.undo.disabled = !queue.labels.can_undo && queue.waiting.length === 0;
    this.redo.disabled = !queue.labels.can_redo && queue.waiting.length === 0;
    this.#begun();
  }

  /// What is begun and not saved, with the buttons that finish it.
  #begun() {
    const { page, state } = this;
    const [draft, mark] = [page.draftText(), page.markText()];
    const kind = draft ? "draft" : mark ? `mark ${state.mark.touch}` : "";
    this.draft.hidden = !kind;
    if (kind !== this.begun) {
      this.begun = kind;
      refill(this.draft, kind ? [el("span", {}), ...(draft ? this.#draftButtons() : this.#markButtons(state.mark.touch))] : null);
    }
    if (kind) this.draft.firstChild.textContent = draft ?? mark;
  }

  #draftButtons() {
    const { drag } = this.page;
    return [
      button("Save", () => drag.commit(), { class: "primary", "data-key": "save", title: "Enter" }),
      button("Discard", () => drag.discard(), { "data-key": "discard", title: "Escape" }),
    ];
  }

  #markButtons(touch) {
    const { actions } = this.page;
    return [
      button(`End the ${touch} here`, () => actions.mark(touch), { class: "primary", "data-key": "end" }),
      button("Discard", () => actions.escape(), { "data-key": "discard", title: "Escape" }),
    ];
  }
}
