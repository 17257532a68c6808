// Cuts as lines over the event rate of a whole recording: dragged, moved by keys, added and removed.

import { chart, onScheme } from "./chart.js";
import { colour, el } from "./dom.js";
import { secondsText } from "./format.js";
import { movedCut, withCut, withoutCut } from "./split_cuts.js";

const STEP_US = 10_000;
const FAR_US = 100_000;

export class CutLines {
  /// @param changed  (cuts) => …, after each change
  constructor({ rate, length_us, touches, changed }) {
    Object.assign(this, { rate, length_us, touches, changed });
    this.cuts = [];
    this.place = el("div", { class: "cut-chart" });
    this.over = el("div", { class: "cut-lines" });
    this.element = el("div", { class: "cut-area", role: "group", "aria-label": "Event rate with cuts" }, this.place, this.over);
    this.over.addEventListener("dblclick", (event) => {
      if (event.target !== this.over) return;
      const cuts = withCut(this.cuts, this.#time(event.clientX), this.length_us);
      if (cuts) this.set(cuts);
    });
    this.resized = () => this.#lay();
    addEventListener("resize", this.resized);
  }

  /// Draws for the first time; the element must be in the document.
  start(cuts) {
    this.cuts = cuts;
    this.#chart();
    this.endTheme = onScheme(() => {
      this.graph.destroy();
      this.#chart();
    });
    this.#lines();
  }

  #chart() {
    this.graph = chart(this.place, {
      labels: ["s", "events/ms"],
      rows: this.rate.t_us.map((t, i) => [t / 1e6, this.rate.max[i]]),
      colours: [colour("series-1")],
      includeZero: true,
      dateWindow: [0, this.length_us / 1e6],
      drawCallback: () => this.#lay(),
    });
  }

  set(cuts) {
    this.cuts = cuts;
    this.#lines();
    this.changed(cuts);
  }

  #area() {
    const { x, w } = this.graph.getArea();
    return { left: x, width: Math.max(1, w) };
  }
  #x(us) {
    const { left, width } = this.#area();
    return left + (width * us) / this.length_us;
  }
  #time(clientX) {
    const { left, width } = this.#area();
    return ((clientX - this.over.getBoundingClientRect().left - left) / width) * this.length_us;
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

  #key(event, index) {
    const step = event.shiftKey ? FAR_US : STEP_US;
    const by = { ArrowLeft: -step, ArrowRight: step }[event.key];
    if (by !== undefined) this.set(movedCut(this.cuts, index, this.cuts[index] + by, this.length_us));
    else if (event.key === "Delete" || event.key === "Backspace") this.set(withoutCut(this.cuts, index));
    else return;
    event.preventDefault();
  }

  #drag(down, index, line) {
    down.preventDefault();
    line.focus({ preventScroll: true });
    line.setPointerCapture(down.pointerId);
    const move = ({ clientX }) => {
      this.cuts = movedCut(this.cuts, index, this.#time(clientX), this.length_us);
      this.#name(line, this.cuts[index]);
      line.style.left = `${this.#x(this.cuts[index])}px`;
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

  #lay() {
    if (!this.graph) return;
    for (const [i, band] of [...this.over.querySelectorAll(".cut-touch")].entries()) {
      const { begin_us, end_us } = this.touches[i];
      Object.assign(band.style, { left: `${this.#x(begin_us)}px`, width: `${Math.max(2, this.#x(end_us) - this.#x(begin_us))}px` });
    }
    for (const [i, line] of [...this.over.querySelectorAll(".cut")].entries()) line.style.left = `${this.#x(this.cuts[i])}px`;
  }

  stop() {
    removeEventListener("resize", this.resized);
    this.endTheme?.();
    this.graph?.destroy();
    this.graph = null;
  }
}
