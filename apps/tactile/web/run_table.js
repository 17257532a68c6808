// The list of all runs: what needs a person comes first.

import { getLabels, getRuns, sendOperation } from "./api.js";
import { announce, button, dialogIsOpen, el, refill } from "./dom.js";
import { clockTexts, countText, counted, lengthText, secondsText } from "./format.js";
import { keptChoice } from "./kept.js";
import { filtered, nextToReview, sorted, stateOf, stillComputing } from "./run_order.js";
import { askWhatToConfirm, confirmMany, confirmable } from "./confirm_many.js";
import { runAddress } from "./router.js";
import { showListHelp } from "./keys.js";
import { Thumbnails } from "./thumbnails.js";

const COMPUTING_EVERY_MS = 2000;
const QUIET_EVERY_MS = 10_000;

const COLUMNS = [
  ["name", "Run"],
  ["state", "State"],
  ["length", "Length"],
  ["rate", "Events/s"],
  ["press", "Press at"],
  ["slip", "Slip at"],
  ["clock", "Clocks"],
  ["flags", "Flags"],
];
const STATES = [
  ["all", "all runs"],
  ["flagged", "flagged"],
  ["unconfirmed", "not confirmed"],
  ["confirmed", "confirmed"],
  ["unreadable", "unreadable"],
  ["simulated", "simulated"],
];
const STATE_WORDS = { unreadable: "✕ unreadable", flagged: "⚑ flagged", unconfirmed: "not confirmed", confirmed: "✓ confirmed" };

export class RunTable {
  constructor() {
    this.title = "Runs";
    this.element = el("main", { id: "main", tabindex: -1 });
    this.abort = new AbortController();
    this.thumbnails = new Thumbnails();
    this.order = keptChoice("order", { column: "state", downward: false });
    this.filter = keptChoice("filter", { search: "", state: "all" });
  }

  async start() {
    refill(this.element, el("h1", {}, "Runs"), el("p", { class: "reading" }, "Looking for runs …"));
    const answer = await getRuns({ signal: this.abort.signal });
    this.#build(answer);
    this.#take(answer);
    this.#again();
  }

  #build(answer) {
    document.body.dataset.data = answer.data;
    const filter = this.filter.load();
    this.search = el("input", {
      type: "search",
      id: "search",
      value: filter.search,
      placeholder: "object, run or flag",
      oninput: () => this.#draw(),
    });
    this.state = el(
      "select",
      { id: "state", onchange: () => this.#draw() },
      STATES.map(([value, words]) => el("option", { value, selected: value === filter.state }, words)),
    );
    this.bar = el("progress", { max: 1, value: 0, "aria-labelledby": "progress-words" });
    this.progress = el("span", { id: "progress-words" });
    this.confirm = button("", () => this.#confirm());
    this.leftOut = el("ul", { class: "left-out error", "aria-label": "Left out" });
    this.count = el("p", { class: "count", role: "status" });
    this.heads = el(
      "tr",
      {},
      el("th", { scope: "col", class: "thumb" }, el("span", { class: "hidden" }, "Picture")),
      COLUMNS.map(([column, words]) => this.#head(column, words)),
    );
    this.rows = el("tbody", {});
    refill(
      this.element,
      el("div", { class: "list-head" }, el("h1", {}, answer.data), el("span", { class: "progress" }, this.bar, this.progress)),
      el(
        "div",
        { class: "filters", role: "search" },
        el("span", {}, el("label", { for: "search" }, "Search "), this.search),
        el("span", {}, el("label", { for: "state" }, "Show "), this.state),
        this.confirm,
        button("Next to review ›", () => this.#goToNext(), { class: "primary", title: "F" }),
        button("?", () => showListHelp(), { "aria-label": "Keys", title: "Keys (?)" }),
      ),
      this.count,
      this.leftOut,
      el(
        "div",
        { class: "scroll" },
        el(
          "table",
          { class: "runs" },
          el("caption", { class: "hidden" }, "Runs: what needs a person comes first"),
          el("thead", {}, this.heads),
          this.rows,
        ),
      ),
    );
  }

  #head(column, words) {
    return el(
      "th",
      { scope: "col", "data-column": column },
      button(words, () => this.#sortBy(column), { class: "sort" }),
    );
  }

  #sortBy(column) {
    const now = this.order.load();
    this.order.save({ column, downward: now.column === column ? !now.downward : false });
    this.#draw();
  }

  #take(answer) {
    this.answer = answer;
    const { runs, confirmed, flagged } = answer.progress;
    this.bar.value = runs ? confirmed / runs : 0;
    this.progress.textContent = `${confirmed} of ${counted(runs, "run")} confirmed` + (flagged ? `, ${flagged} flagged` : "");
    refill(
      this.leftOut,
      (answer.left_out ?? []).map((words) => el("li", {}, words)),
    );
    this.#draw();
  }

  /// Looks again now and then: often while something is being computed, seldom otherwise, never in a hidden tab.
  #again() {
    const wait = stillComputing(this.answer.runs) ? COMPUTING_EVERY_MS : QUIET_EVERY_MS;
    this.timer = setTimeout(async () => {
      if (!document.hidden) {
        const answer = await getRuns({ signal: this.abort.signal }).catch(() => null);
        if (answer && answer.revision !== this.answer.revision) this.#take(answer);
      }
      if (!this.abort.signal.aborted) this.#again();
    }, wait);
  }

  #draw() {
    const filter = { search: this.search.value, state: this.state.value };
    this.filter.save(filter);
    const { column, downward } = this.order.load();
    for (const head of this.heads.querySelectorAll("[data-column]")) {
      const here = head.dataset.column === column;
      head.setAttribute("aria-sort", here ? (downward ? "descending" : "ascending") : "none");
    }
    const { runs } = this.answer;
    const shown = sorted(filtered(runs, filter.search, filter.state), column, downward);
    this.count.textContent =
      shown.length === runs.length ? counted(runs.length, "run") : `${shown.length} of ${counted(runs.length, "run")}`;
    this.shown = shown;
    const open = confirmable(shown).length;
    this.confirm.textContent = `Confirm ${counted(open, "run")} …`;
    this.confirm.hidden = open === 0;
    refill(
      this.rows,
      shown.map((run) => this.#row(run)),
    );
    if (runs.length === 0) this.count.textContent = "There are no runs here. Make some with tactile record or tactile simulate.";
  }

  #row(run) {
    const state = stateOf(run);
    const cell = (label, ...content) => el("td", { "data-label": label }, ...content);
    const onset = (touch) => {
      const found = (run.intervals ?? []).filter((i) => i.touch === touch);
      return found.length ? found.map((i) => secondsText(i.start_us, 5e6)).join(", ") : "–";
    };
    const link = el("a", { href: runAddress(run.name), "data-key": run.name }, run.name);
    const notes = [
      run.simulated ? "simulated" : null,
      run.has?.video ? null : "no film",
      run.has?.robot ? null : "no robot log",
      run.has?.labels ? null : "no labels",
    ].filter(Boolean);
    const name = el("th", { scope: "row" }, link, run.error ? null : el("span", { class: "notes" }, notes.join(", ")));
    if (run.error) {
      return el(
        "tr",
        { class: state },
        el("td", { class: "thumb" }),
        name,
        cell("State", el("span", { class: "state unreadable" }, STATE_WORDS[state])),
        el("td", { colspan: 6, class: "error", "data-label": "Error" }, run.error),
      );
    }
    const open = (run.flags ?? []).filter((flag) => !flag.confirmed);
    return el(
      "tr",
      { class: state },
      el("td", { class: "thumb" }, this.thumbnails.of(run.name)),
      name,
      cell("State", el("span", { class: `state ${state}` }, STATE_WORDS[state])),
      cell("Length", run.length_s === null ? "…" : lengthText(Math.round(run.length_s * 1e6))),
      cell(
        "Events/s",
        run.rate_mean_per_s === null ? "…" : countText(run.rate_mean_per_s),
        run.rate_peak_per_s ? el("span", { class: "notes" }, `peak ${countText(run.rate_peak_per_s)}`) : null,
      ),
      cell("Press at", onset("press")),
      cell("Slip at", onset("slip")),
      cell("Clocks", clockTexts(run.clocks).map((words) => el("div", {}, words))),
      cell(
        "Flags",
        open.length
          ? el(
              "ul",
              { class: "flag-words" },
              open.map((flag) => el("li", {}, flag.what)),
            )
          : "–",
      ),
    );
  }

  /// Of the runs that are shown, those that are open.
  async #confirm() {
    const wanted = await askWhatToConfirm(confirmable(this.shown));
    if (!wanted) return;
    const { done, problems } = await confirmMany(wanted.names, wanted.kind, wanted.why, { getLabels, sendOperation });
    if (problems.length) announce(`${counted(done.length, "run")} saved. ${problems.join("; ")}`, "error", { news: true });
    else announce(`${counted(done.length, "run")} saved. Undo is on the page of each run.`, "note", { news: true });
    this.#take(await getRuns({ signal: this.abort.signal }));
  }

  #goToNext() {
    const next = nextToReview(this.answer.runs, "");
    if (next) location.hash = runAddress(next);
    else announce("Every run is confirmed and without an open flag.");
  }

  key(event) {
    if (dialogIsOpen() || event.altKey || event.ctrlKey || event.metaKey || event.target.matches("input, select, textarea")) return;
    const links = [...(this.rows?.querySelectorAll("a") ?? [])];
    const here = links.indexOf(document.activeElement);
    const action = {
      "/": () => this.search.focus(),
      "?": () => showListHelp(),
      f: () => this.#goToNext(),
      j: () => links[Math.min(here + 1, links.length - 1)]?.focus(),
      k: () => links[Math.max(here - 1, 0)]?.focus(),
    }[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  stop() {
    this.abort.abort();
    clearTimeout(this.timer);
    this.thumbnails.stop();
  }
}
