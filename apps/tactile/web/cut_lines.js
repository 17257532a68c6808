// Cuts as lines over the event rate of a long recording: dragged, moved by keys, added and removed. The axis zooms like that of a run.

import { AxisGestures } from "./axis_gestures.js";
import { el } from "./dom.js";
import { secondsText } from "./format.js";
import { Overview } from "./overview.js";
import { SignalStrips } from "./signal_strips.js";
import { movedCut, withCut, withoutCut } from "./split_cuts.js";
import { around, fitted, pixelOf, wholeOf } from "./time_view.js";

const STEP_US = 10_000; // of a key
const SHIFT_FACTOR = 10;
const OUTSIDE_PX = 20; // a line outside the view is drawn so far beyond the edge

export class CutLines {
  /// @param rate  the signal of the event rate, as the server lists it
  /// @param load  async ({from_us, to_us, points, names}, {signal}) => answer of /signals
  /// @param changed  (cuts) => …, after each change
  constructor({ rate, load, length_us, touches, changed, failed }) {
    Object.assign(this, { length_us, touches, changed });
    this.cuts = [];
    this.view = wholeOf(length_us);
    this.labels = { intervals: touches.map(({ kind, begin_us, end_us }) => ({ touch: kind, start_us: begin_us, end_us })) };
    this.strips = new SignalStrips({ signals: [rate], load, length_us, failed });
    this.overview = new Overview(this);
    this.over = el("div", { class: "surface cut-lines" });
    this.element = el(
      "div",
      { class: "timeline cut-area", role: "group", "aria-label": "Event rate with cuts" },
      this.overview.element,
      el("div", { class: "stack" }, this.strips.element, this.over),
    );
    const isFree = (target) => !target.closest(".cut");
    this.gestures = new AxisGestures(this.over, this, { isFree });
    this.over.addEventListener("dblclick", (event) => {
      const cuts = isFree(event.target) ? withCut(this.cuts, this.gestures.timeOf(event), this.length_us) : null;
      if (cuts) this.set(cuts);
    });
  }

  /// Draws for the first time; the element must be in the document.
  start(cuts) {
    this.cuts = cuts;
    this.strips.start(this.view);
    this.#lines();
    this.sizes = new ResizeObserver(() => this.#resize());
    this.sizes.observe(this.element);
    this.#resize();
  }

  #resize() {
    this.strips.resize();
    const { left, width } = this.strips.area();
    this.width = width;
    for (const { style } of [this.over, this.overview.element]) Object.assign(style, { marginLeft: `${left}px`, width: `${width}px` });
    this.#lay();
  }

  /// Shows a part of the recording.
  show(view) {
    this.view = fitted(view, this.length_us);
    this.strips.show(this.view);
    this.#lay();
  }

  /// Asks again for what did not come.
  again() {
    this.strips.again();
  }

  set(cuts) {
    this.cuts = cuts;
    this.#lines();
    this.changed(cuts);
  }

  #lines() {
    const focused = this.over.contains(document.activeElement) ? Number(document.activeElement.dataset.index) : -1;
    this.over.replaceChildren(...this.touches.map((touch) => el("span", { class: `cut-touch ${touch.kind}` })), ...this.cuts.map((cut, i) => this.#line(cut, i)));
    this.#lay();
    if (focused >= 0) this.over.querySelector(`[data-index="${Math.min(focused, this.cuts.length - 1)}"]`)?.focus({ preventScroll: true });
  }

  #line(cut, index) {
    const line = el("span", {
      class: "cut",
      role: "slider",
      tabindex: 0,
      "data-index": index,
      "aria-label": `Cut ${index + 1}`,
      "aria-valuemin": 0,
      "aria-valuemax": this.length_us / 1e6,
      onfocus: () => line.matches(":focus-visible") && this.#follow(this.cuts[index]),
      onkeydown: (event) => this.#key(event, index),
      onpointerdown: (event) => this.#drag(event, index, line),
    });
    this.#name(line, cut);
    return line;
  }

  #name(line, cut) {
    line.setAttribute("aria-valuenow", String(cut / 1e6));
    line.setAttribute("aria-valuetext", secondsText(cut, 1e7));
    line.title = secondsText(cut, 1e7);
  }

  #shows(at_us) {
    return at_us >= this.view.from_us && at_us <= this.view.to_us;
  }

  #follow(at_us) {
    if (!this.#shows(at_us)) this.show(around(at_us, this.view.to_us - this.view.from_us, this.length_us));
  }

  #key(event, index) {
    const step = Math.min(STEP_US, (this.view.to_us - this.view.from_us) / 100) * (event.shiftKey ? SHIFT_FACTOR : 1);
    const by = { ArrowLeft: -step, ArrowRight: step }[event.key];
    if (by !== undefined) {
      this.set(movedCut(this.cuts, index, this.cuts[index] + by, this.length_us));
      this.#follow(this.cuts[index]);
    } else if (event.key === "Delete" || event.key === "Backspace") this.set(withoutCut(this.cuts, index));
    else return;
    event.preventDefault();
  }

  #drag(down, index, line) {
    down.preventDefault();
    line.focus({ preventScroll: true });
    line.setPointerCapture(down.pointerId);
    const move = (event) => {
      this.cuts = movedCut(this.cuts, index, this.gestures.timeOf(event), this.length_us);
      this.#name(line, this.cuts[index]);
      this.#place(line, this.cuts[index]);
    };
    const end = () => {
      line.removeEventListener("pointermove", move);
      line.removeEventListener("pointerup", end);
      line.removeEventListener("pointercancel", end);
      this.set(this.cuts);
    };
    line.addEventListener("pointermove", move);
    line.addEventListener("pointerup", end);
    line.addEventListener("pointercancel", end);
  }

  #x(us) {
    return Math.min(Math.max(pixelOf(us, this.view, this.width), -OUTSIDE_PX), this.width + OUTSIDE_PX);
  }

  #place(line, at_us) {
    line.style.left = `${this.#x(at_us)}px`;
    line.classList.toggle("outside", !this.#shows(at_us));
  }

  #lay() {
    if (!this.width) return;
    Object.assign(this.element.dataset, this.view); // the view, for whoever looks at the document
    const x = (us) => this.#x(us);
    for (const [i, band] of [...this.over.querySelectorAll(".cut-touch")].entries()) {
      const { begin_us, end_us } = this.touches[i];
      Object.assign(band.style, { left: `${x(begin_us)}px`, width: `${Math.max(2, x(end_us) - x(begin_us))}px` });
    }
    for (const [i, line] of [...this.over.querySelectorAll(".cut")].entries()) this.#place(line, this.cuts[i]);
    this.overview.draw();
  }

  stop() {
    this.sizes?.disconnect();
    this.strips.stop();
  }
}
