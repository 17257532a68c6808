// The last minute of the live page, as charts on one time axis. dygraphs draws them.

import { chart, onScheme } from "./chart.js";
import { colour, el } from "./dom.js";

const MINUTE_S = 60;

const CHARTS = [
  { title: "Probabilities", names: ["p_press", "p_slip"], labels: ["press", "slip"], colours: ["press", "slip"], range: [0, 1.02] },
  { title: "Event rate [1/s]", names: ["events_per_s"], labels: ["events/s"], colours: ["series-1"] },
  { title: "Lateness [ms]", names: ["lateness_ms"], labels: ["ms"], colours: ["series-4"] },
  { title: "Acceleration of the camera [m/s²]", names: ["imu_m_per_s2"], labels: ["m/s²"], colours: ["series-1"], range: null },
  { title: "Robot speed [mm/s]", names: ["robot_mm_per_s"], labels: ["mm/s"], colours: ["series-2"] },
  { title: "Robot height [mm]", names: ["robot_height_mm"], labels: ["mm"], colours: ["series-3"], range: null },
];

export class LiveCharts {
  constructor() {
    this.element = el("div", { class: "live-charts" });
    this.drawn = null;
    onScheme(() => this.#begin());
  }

  show(steps, columns) {
    this.steps = steps;
    this.columns = columns;
    if (!this.drawn) return void this.#begin();
    for (const { names, graph } of this.drawn) graph.updateOptions({ file: this.#rows(names) });
  }

  #rows(names) {
    const rows = this.steps.of(names, this.columns);
    return rows.length ? rows : [[0, ...names.map(() => null)]];
  }

  #begin() {
    if (!this.columns) return;
    for (const { graph } of this.drawn ?? []) graph.destroy();
    const wanted = CHARTS.filter(({ names }) => names.every((name) => this.columns.includes(name)));
    const places = wanted.map(() => el("div", { class: "live-chart" }));
    this.element.replaceChildren(
      ...wanted.map(({ title, labels, colours }, i) =>
        el(
          "figure",
          {},
          el(
            "figcaption",
            {},
            title,
            labels.length > 1 &&
              el("span", {}, labels.map((label, k) => el("span", { class: "legend" }, el("span", { class: `swatch swatch-${colours[k]}` }), label))),
          ),
          places[i],
        ),
      ),
    );
    this.drawn = wanted.map(({ names, labels, colours, range }, i) => ({
      names,
      graph: chart(places[i], {
        labels: ["s", ...labels],
        rows: this.#rows(names),
        colours: colours.map(colour),
        dateWindow: [-MINUTE_S, 0],
        valueRange: range === undefined ? [0, null] : range,
        axes: { x: { axisLabelFormatter: (s) => `${s.toFixed(0)} s` } },
      }),
    }));
  }
}
