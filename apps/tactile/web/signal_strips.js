// The signals of a run, one strip each, one under the other on the same time axis.

import { chart, onScheme, themed } from "./chart.js";
import { colour, el } from "./dom.js";
import { lengthText, unitText, valueText } from "./format.js";
import { neededSamples, rootTicks, rowsOf } from "./detail.js";
import { lastUntil } from "./snapping.js";
import { Latest } from "./latest.js";

const RATES = new Set(["event_rate", "touched_rate"]); // of counts: their noise is the same everywhere on an axis of square roots
const FROM_ZERO = new Set([...RATES, "robot_speed", "film_motion"]);
const TICK_PX = 22;
const PROBABILITIES = ["p_none", "p_press", "p_slip"];
export const MODEL_SIGNALS = PROBABILITIES.map((name) => ({ name, label: name, unit: "" }));
const COLOURS = { p_none: "none", p_press: "press", p_slip: "slip" };

/// One strip for each signal; the probabilities of a model share one.
export function stripsOf(signals) {
  const strips = signals.filter((signal) => !PROBABILITIES.includes(signal.name)).map((signal) => ({ ...signal, names: [signal.name] }));
  const given = signals.filter((signal) => PROBABILITIES.includes(signal.name)).map((signal) => signal.name);
  if (given.length) strips.push({ name: "probabilities", label: "Probability of none, press, slip", unit: "", names: given });
  return strips;
}

/// Rows of several series at the same times, each value as `shown` gives it.
export function jointRows(list, shown) {
  const [first, ...others] = list.map((series) => rowsOf(series, shown));
  if (others.length === 0) return first;
  const known = others.map((rows) => new Map(rows));
  return first.map(([t, bar]) => [t, bar, ...known.map((rows) => rows.get(t) ?? [null, null, null])]);
}

/// The sample at a time: the last one until it, else the first one if it is at most one sample away. null if there is none.
export function valueAt({ t_us, mean }, at_us) {
  const index = lastUntil(t_us, at_us);
  if (index >= 0) return mean[index];
  return t_us.length > 1 && t_us[0] - at_us <= t_us[1] - t_us[0] ? mean[0] : null;
}

export class SignalStrips {
  /// @param load  async ({from_us, to_us, points, names}, {signal}) => answer of /signals
  constructor({ signals, load, length_us, failed }) {
    this.strips = stripsOf(signals);
    this.load = load;
    this.length_us = length_us;
    this.loaded = null;
    this.series = {};
    this.latest = new Latest((request, signal) => this.#fetch(request, signal), failed);
    this.element = el(
      "div",
      { class: "strips" },
      this.strips.map((strip, index) => this.#strip(strip, index)),
    );
    this.endTheme = onScheme(() => this.#theme());
  }

  #strip(strip, index) {
    const last = index === this.strips.length - 1;
    strip.value = el("output", { class: "value" });
    strip.place = el("div", { class: "chart" });
    strip.element = el(
      "div",
      { class: last ? "strip last" : "strip", "data-signal": strip.name, role: "group", "aria-label": strip.label + (strip.unit ? ` in ${strip.unit}` : "") },
      el(
        "p",
        { class: "strip-name" },
        el("span", {}, strip.label),
        " ",
        strip.value,
        strip.unit ? el("span", { class: "unit" }, ` ${unitText(strip.unit)}`) : null,
        (strip.over = el("span", { class: "unit" })),
      ),
      strip.place,
    );
    return strip.element;
  }

  /// Draws the charts for the first time; the element must be in the document.
  start(view) {
    this.view = view;
    for (const [index, strip] of this.strips.entries()) {
      const last = index === this.strips.length - 1;
      strip.chart = chart(strip.place, {
        labels: ["s", ...strip.names],
        rows: [],
        colours: this.#colours(strip),
        customBars: true,
        fillAlpha: 0.35,
        connectSeparatedPoints: false,
        includeZero: FROM_ZERO.has(strip.name),
        dateWindow: [view.from_us / 1e6, view.to_us / 1e6],
        ...(strip.name === "probabilities" ? { valueRange: [-0.02, 1.05] } : {}),
        axes: {
          y: this.#valueAxis(strip),
          x: { drawAxis: last, pixelsPerLabel: 80, axisLabelFormatter: (value) => this.#tickText(value) },
        },
      });
    }
    this.show(view);
  }

  #valueAxis({ name }) {
    if (RATES.has(name)) return { ticker: (_, most, pixels) => rootTicks(most, (most * TICK_PX) / Math.max(pixels, 1)) };
    if (name !== "probabilities") return {};
    return { ticker: () => [0, 1].map((v) => ({ v, label: String(v) })) };
  }

  #colours(strip) {
    return strip.names.map((name) => colour(COLOURS[name] ?? "series-1"));
  }

  #tickText(seconds) {
    const span = (this.view.to_us - this.view.from_us) / 1e6;
    return seconds.toFixed(Math.min(6, Math.max(0, Math.ceil(-Math.log10(span / 10)))));
  }

  /// Where the axis lies in the strips: {left, width} in pixels.
  area() {
    const area = this.strips[0]?.chart?.getArea();
    return area ? { left: area.x, width: area.w } : { left: 52, width: this.element.clientWidth - 60 };
  }

  show(view) {
    this.view = view;
    for (const { chart: g } of this.strips) g?.updateOptions({ dateWindow: [view.from_us / 1e6, view.to_us / 1e6] });
    const need = neededSamples(view, this.length_us, this.loaded, this.area().width);
    if (need) this.latest.ask(need);
  }

  /// Asks again for what did not come.
  again() {
    this.loaded = null;
    this.show(this.view);
  }

  async #fetch(need, signal) {
    const names = this.strips.flatMap((strip) => strip.names);
    const answer = await this.load({ ...need, names }, { signal });
    const pending = answer.pending ?? [];
    this.loaded = pending.length ? null : need;
    Object.assign(this.series, answer.series);
    for (const strip of this.strips) {
      const given = strip.names.filter((name) => this.series[name]);
      strip.element.classList.toggle(
        "pending",
        strip.names.some((name) => pending.includes(name)),
      );
      if (given.length !== strip.names.length) continue;
      const list = given.map((name) => this.series[name]);
      strip.chart?.updateOptions({ file: jointRows(list, RATES.has(strip.name) ? Math.sqrt : undefined) });
      strip.over.textContent = list[0].over_us ? `, mean over ${lengthText(list[0].over_us)}` : "";
    }
    this.values(this.at_us);
    if (pending.length)
      setTimeout(() => {
        if (!this.latest.stopped) this.show(this.view);
      }, 500);
  }

  /// Writes the values at the cursor next to the names.
  values(at_us) {
    this.at_us = at_us;
    if (at_us === undefined) return; // no cursor on this page
    for (const strip of this.strips) {
      const texts = strip.names.map((name) => {
        const series = this.series[name];
        return series ? valueText(valueAt(series, at_us)) : "–";
      });
      strip.value.textContent = texts.join(" · ");
    }
  }

  resize() {
    for (const { chart: g } of this.strips) g?.resize();
  }

  #theme() {
    for (const strip of this.strips) strip.chart?.updateOptions({ ...themed(), colors: this.#colours(strip) });
  }

  stop() {
    this.latest.stop();
    this.endTheme();
    for (const strip of this.strips) {
      strip.chart?.destroy();
      strip.chart = null;
    }
  }
}
