// Two models: their figures, and what both say on one run, on the same time axis.

import * as api from "./api.js";
import { AxisGestures, axisButtons } from "./axis_gestures.js";
import { MODEL_SIGNALS, SignalStrips } from "./signal_strips.js";
import { el, figuresTable, refill } from "./dom.js";
import { figureText } from "./format.js";
import { Refused } from "./edit_queue.js";
import { MODEL_FIGURES, comparison, figureOf } from "./figures.js";
import { compareAddress, runAddress } from "./router.js";
import { pixelOf, wholeOf } from "./time_view.js";

export class ComparePage {
  constructor({ first, second, run }) {
    Object.assign(this, { names: [first, second], run });
    this.title = `${first} and ${second}`;
    this.element = el("main", { id: "main", tabindex: -1 });
    this.abort = new AbortController();
    this.strips = [];
  }

  async start() {
    const options = { signal: this.abort.signal };
    refill(this.element, el("h1", {}, this.title), el("p", { class: "reading" }, "Reading …"));
    const [models, { runs }] = await Promise.all([api.getModels(options), api.getRuns(options)]);
    const both = this.names.map((name) => models.find((model) => model.name === name) ?? null);
    const usable = runs.filter((run) => !run.error);
    const run = usable.find((r) => r.name === this.run) ?? usable[0];
    const chooser = el(
      "select",
      {
        id: "run",
        onchange: (e) => {
          location.hash = compareAddress(...this.names, e.target.value);
        },
      },
      usable.map((r) => el("option", { value: r.name, selected: r === run }, r.name)),
    );
    this.plots = el("section", { class: "timeline compare", "aria-label": "Probabilities of both models" });
    refill(
      this.element,
      el("h1", {}, this.title),
      this.#figures(both),
      run
        ? el("p", {}, el("label", { for: "run" }, "On the run "), chooser, " ", el("a", { href: runAddress(run.name) }, "open the run"))
        : null,
      this.plots,
    );
    if (run) await this.#plot(run.name, options);
  }

  #figures(both) {
    const missing = this.names.filter((_, i) => !both[i]);
    if (missing.length) return el("p", { class: "error" }, `There is no model ${missing.join(", ")} here.`);
    const row = ([key, words, unit]) => {
      const [a, b] = both.map((model) => figureOf(model.eval, key));
      return el(
        "tr",
        {},
        el("th", { scope: "row", "data-label": "Figure" }, words),
        el("td", { "data-label": this.names[0] }, figureText(a, unit)),
        el("td", { "data-label": this.names[1] }, figureText(b, unit)),
        el("td", { "data-label": "Difference" }, comparison(a, b) || "–"),
      );
    };
    return figuresTable("Figures with 95 % intervals", ["Figure", ...this.names, "Difference"], MODEL_FIGURES.map(row));
  }

  async #plot(name, options) {
    refill(this.plots, el("p", { class: "reading" }, "Reading the run …"));
    const [run, labels] = await Promise.all([api.getRun(name, options), this.#labels(name, options)]);
    if (this.abort.signal.aborted) return;
    this.length_us = Math.round(run.length_s * 1e6);
    this.view = wholeOf(this.length_us);
    this.labels = labels;
    this.problem = el("p", { class: "error", role: "alert" });
    const failed = (error) => {
      this.problem.textContent = error.message;
    };
    const strips = (signals, model) =>
      new SignalStrips({ signals, length_us: this.length_us, failed, load: (request, o) => api.getSignals(name, { ...request, model }, o) });
    this.strips = [
      strips(
        run.signals.filter((signal) => signal.name === "event_rate"),
        null,
      ),
      ...this.names.map((model) => strips(MODEL_SIGNALS, model)),
    ];
    this.bands = el("div", { class: "bands" });
    this.surface = el("div", { class: "surface" }, this.bands);
    this.gestures = new AxisGestures(this.surface, this);
    const titled = this.strips.map((part, i) => [i > 0 ? el("h3", {}, this.names[i - 1]) : null, part.element]);
    refill(
      this.plots,
      el("p", { class: "tools" }, axisButtons(this, "Whole run")),
      this.problem,
      el("div", { class: "stack" }, titled, this.surface),
    );
    for (const part of this.strips) part.start(this.view);
    this.sizes = new ResizeObserver(() => this.#resize());
    this.sizes.observe(this.plots);
  }

  /// A run without labels has no bands.
  async #labels(name, options) {
    try {
      return await api.getLabels(name, options);
    } catch (error) {
      if (!(error instanceof Refused && error.status === 404)) throw error;
      return { intervals: [] };
    }
  }

  #resize() {
    for (const part of this.strips) part.resize();
    const { left, width } = this.strips[1].area();
    Object.assign(this.surface.style, { left: `${left}px`, width: `${width}px` });
    this.width = width;
    this.#bands();
  }

  #bands() {
    refill(
      this.bands,
      this.labels.intervals.map((interval) => {
        const [left, right] = [interval.start_us, interval.end_us].map((t) =>
          Math.min(Math.max(pixelOf(t, this.view, this.width), -2), this.width + 2),
        );
        return el(
          "div",
          { class: `band ${interval.touch}`, style: { left: `${left}px`, width: `${Math.max(right - left, 1)}px` } },
          el("span", { class: "band-name" }, interval.id),
        );
      }),
    );
  }

  /// Shows a part of the run.
  show(view) {
    this.view = view;
    for (const part of this.strips) part.show(view);
    this.#bands();
  }

  stop() {
    this.abort.abort();
    this.sizes?.disconnect();
    for (const part of this.strips) part.stop();
  }
}
