// All model bundles: settings that are not the default, figures with intervals, training curves.

import { getModels } from "./api.js";
import { chart, onScheme, seriesColours, themed } from "./chart.js";
import { button, el, figuresTable, refill } from "./dom.js";
import { counted, countText, figureText, whenText } from "./format.js";
import { MODEL_FIGURES, curvesOf, figureOf, settingRows } from "./figures.js";
import { compareAddress } from "./router.js";

export class ModelsPage {
  constructor() {
    this.title = "Models";
    this.element = el("main", { id: "main", tabindex: -1 });
    this.abort = new AbortController();
    this.charts = [];
    this.endTheme = onScheme(() => this.charts.forEach(({ g, count }) => g.updateOptions({ ...themed(), colors: seriesColours(count) })));
  }

  async start() {
    refill(this.element, el("h1", {}, "Models"), el("p", { class: "reading" }, "Looking for models …"));
    const models = await getModels({ signal: this.abort.signal });
    if (models.length === 0) {
      refill(
        this.element,
        el("h1", {}, "Models"),
        el("p", { class: "empty" }, "There are no models yet. Train one: ", el("code", {}, "tactile train --th 40"), "."),
      );
      return;
    }
    refill(
      this.element,
      el("h1", {}, "Models"),
      this.#table(models),
      models.length > 1 ? this.#chooser(models) : null,
      el("h2", {}, "Each model"),
      models.map((model) => this.#details(model)),
    );
  }

  #table(models) {
    const head = ["Model", "Trained", "Kind", "Parameters", ...MODEL_FIGURES.map(([, words]) => words), "Settings off the default"];
    const row = (model) =>
      el(
        "tr",
        {},
        el(
          "th",
          { scope: "row", "data-label": "Model" },
          el("a", { href: "#/models", onclick: (event) => this.#open(event, model.name) }, model.name),
        ),
        el("td", { "data-label": "Trained" }, whenText(model.trained?.when)),
        el("td", { "data-label": "Kind" }, model.kind ?? "–"),
        el("td", { "data-label": "Parameters" }, countText(model.parameters)),
        MODEL_FIGURES.map(([key, words, unit]) =>
          el("td", { "data-label": words, class: "figure" }, figureText(figureOf(model.eval, key), unit)),
        ),
        el(
          "td",
          { "data-label": "Settings" },
          settingRows(model.settings)
            .map(([name, value]) => `${name} ${value}`)
            .join(", ") || "none",
        ),
      );
    return el(
      "div",
      { class: "scroll", role: "region", tabindex: 0, "aria-label": "Table of models" },
      figuresTable(
        `${counted(models.length, "model")}; figures with 95 % intervals, where tactile eval has made them`,
        head,
        models.map(row),
      ),
    );
  }

  #chooser(models) {
    const choice = (id, chosen) =>
      el(
        "select",
        { id },
        models.map((model, i) => el("option", { value: model.name, selected: i === chosen }, model.name)),
      );
    const [first, second] = [choice("first", 0), choice("second", 1)];
    return el(
      "p",
      { class: "chooser" },
      el("label", { for: "first" }, "Compare "),
      first,
      el("label", { for: "second" }, " with "),
      second,
      " ",
      button(
        "Compare",
        () => {
          location.hash = compareAddress(first.value, second.value);
        },
        { class: "primary" },
      ),
    );
  }

  #details(model) {
    const charts = el("div", { class: "curves" });
    const { when, ...facts } = model.trained ?? {};
    const trained = Object.entries({ trained: whenText(when), ...facts }).filter(
      ([, value]) => value !== null && (Array.isArray(value) || typeof value !== "object"),
    );
    const settings = settingRows(model.settings);
    const part = el(
      "details",
      { "data-model": model.name, ontoggle: () => part.open && this.#draw(charts, model) },
      el("summary", {}, model.name),
      model.error ? el("p", { class: "error" }, model.error) : null,
      el(
        "dl",
        {},
        trained.map(([name, value]) => [
          el("dt", {}, name.replaceAll("_", " ")),
          el("dd", {}, Array.isArray(value) ? value.join(", ") : String(value)),
        ]),
        el("dt", {}, "settings off the default"),
        el(
          "dd",
          {},
          settings.length
            ? el(
                "ul",
                {},
                settings.map(([name, value]) => el("li", {}, el("code", {}, name), ` ${value}`)),
              )
            : "none",
        ),
      ),
      charts,
    );
    return part;
  }

  /// The curves are drawn when they are first seen: a chart needs its size.
  #draw(place, model) {
    if (place.childElementCount) return;
    const curves = curvesOf(model.history ?? []);
    if (curves.length === 0) refill(place, el("p", { class: "empty" }, "This bundle has no training history."));
    const drawn = curves.map(({ title, names, rows }) => {
      const box = el("div", { class: "curve" });
      const colours = seriesColours(names.length);
      const legend = names.map((name, i) =>
        el("span", { class: "legend" }, el("span", { class: "swatch", style: { background: colours[i] } }), name.replaceAll("_", " ")),
      );
      const last = rows.at(-1);
      const words = `${title} over ${counted(rows.length, "epoch")}; last: ${names.map((name, i) => `${name.replaceAll("_", " ")} ${Number(last[i + 1]).toFixed(4)}`).join(", ")}`;
      place.append(el("figure", { role: "figure", "aria-label": words }, el("figcaption", {}, `${title} by epoch `, legend), box));
      return () =>
        this.charts.push({
          g: chart(box, {
            labels: ["epoch", ...names],
            rows,
            includeZero: title === "Loss",
            axes: { x: { axisLabelFormatter: (epoch) => (Number.isInteger(epoch) ? String(epoch) : "") } },
          }),
          count: names.length,
        });
    });
    for (const draw of drawn) draw(); // all have their place first: a chart takes the width that it finds
  }

  #open(event, name) {
    event.preventDefault();
    const part = this.element.querySelector(`details[data-model="${CSS.escape(name)}"]`);
    part.open = true;
    part.scrollIntoView({ block: "start" });
    part.querySelector("summary").focus({ preventScroll: true });
  }

  stop() {
    this.abort.abort();
    this.endTheme();
    for (const { g } of this.charts) g.destroy();
  }
}
