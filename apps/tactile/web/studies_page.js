// Results of studies, trades, stresses and evaluations; two of them side by side.

import { getStudies } from "./api.js";
import { el, figuresTable, refill } from "./dom.js";
import { figureText, whenText } from "./format.js";
import { comparison, sideBySide } from "./figures.js";

export class StudiesPage {
  constructor({ first, second }) {
    this.title = "Studies";
    this.wanted = [first ?? null, second ?? null];
    this.element = el("main", { id: "main", tabindex: -1 });
    this.abort = new AbortController();
  }

  async start() {
    refill(this.element, el("h1", {}, "Studies"), el("p", { class: "reading" }, "Looking for results …"));
    this.studies = await getStudies({ signal: this.abort.signal });
    if (this.studies.length === 0) {
      refill(
        this.element,
        el("h1", {}, "Studies"),
        el(
          "p",
          { class: "empty" },
          "There are no results yet. ",
          el("code", {}, "tactile reproduce"),
          " makes a study, ",
          el("code", {}, "tactile eval"),
          " an evaluation.",
        ),
      );
      return;
    }
    const [first, second] = this.wanted;
    const names = this.studies.map((study) => study.name);
    this.chosen = [names.includes(first) ? first : names[0], names.includes(second) ? second : second === "" ? "" : (names[1] ?? "")];
    this.body = el("div", {});
    const choice = (id, place, empty) =>
      el(
        "select",
        { id, onchange: (event) => this.#choose(place, event.target.value) },
        empty ? el("option", { value: "" }, "nothing") : null,
        this.studies.map((study) =>
          el("option", { value: study.name, selected: study.name === this.chosen[place] }, `${study.name} (${study.kind})`),
        ),
      );
    refill(
      this.element,
      el("h1", {}, "Studies"),
      el(
        "p",
        { class: "chooser" },
        el("label", { for: "first" }, "Show "),
        choice("first", 0, false),
        el("label", { for: "second" }, " side by side with "),
        choice("second", 1, true),
      ),
      this.body,
    );
    this.#draw();
  }

  #choose(place, name) {
    this.chosen[place] = name;
    const [first, second] = this.chosen.map(encodeURIComponent);
    history.replaceState(null, "", `#/studies?first=${first}&second=${second}`);
    this.#draw();
  }

  #draw() {
    const [first, second] = this.chosen.map((name) => this.studies.find((study) => study.name === name) ?? null);
    const both = second !== null;
    const rows = sideBySide(first.figures ?? [], second?.figures ?? []);
    const row = ({ label, unit, first: a, second: b }) =>
      el(
        "tr",
        {},
        el("th", { scope: "row", "data-label": "Figure" }, label),
        el("td", { "data-label": first.name }, figureText(a, unit)),
        both
          ? [
              el("td", { "data-label": second.name }, figureText(b, unit)),
              el("td", { "data-label": "Difference" }, comparison(a, b) || "–"),
            ]
          : null,
      );
    const heads = ["Figure", first.name, ...(both ? [second.name, "Difference"] : [])];
    refill(
      this.body,
      el(
        "p",
        { class: "notes" },
        [first, second].filter(Boolean).map((study) =>
          el(
            "span",
            { class: "notes" },
            `${study.name}: ${study.title ?? study.kind}, ${whenText(study.when)}`,
            study.simulated ? ", simulated runs" : "",
            (study.remarks ?? []).map((words) => ` ${words}`),
            study.error ? el("span", { class: "error" }, ` ${study.error}`) : null,
          ),
        ),
      ),
      el(
        "div",
        { class: "scroll", role: "region", tabindex: 0, "aria-label": "Figures" },
        figuresTable("Figures with 95 % intervals", heads, rows.map(row)),
      ),
      this.#claims(first, second),
    );
  }

  #claims(first, second) {
    const key = (claim) => claim.id ?? claim.claim;
    const claims = new Map([second, first].flatMap((study) => (study?.claims ?? []).map((c) => [key(c), c.claim])));
    if (claims.size === 0) return null;
    const cell = (study, id) => {
      const found = study.claims?.find((c) => key(c) === id);
      return el(
        "td",
        { "data-label": study.name },
        found?.outcome ?? "–",
        found?.in_words ? el("span", { class: "notes" }, found.in_words) : null,
      );
    };
    return figuresTable(
      "Claims",
      ["Claim", first.name, ...(second ? [second.name] : [])],
      [...claims].map(([id, words]) =>
        el("tr", {}, el("th", { scope: "row", "data-label": "Claim" }, words), cell(first, id), second ? cell(second, id) : null),
      ),
    );
  }

  stop() {
    this.abort.abort();
  }
}
