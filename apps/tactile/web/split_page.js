// A long recording is cut into runs: the proposal over the event rate, to be moved, added to and taken from, then written.

import { axisButtons } from "./axis_gestures.js";
import { getSignals, getRun, getSplit, onConnection, sendSplit } from "./api.js";
import { CutLines } from "./cut_lines.js";
import { announce, button, el, refill } from "./dom.js";
import { counted, secondsFrom, secondsText } from "./format.js";
import { press, showSplitHelp, splitKeys } from "./keys.js";
import { runAddress } from "./router.js";
import { incompleteRuns, objectsFrom, runsBetween, withCut, withoutCut } from "./split_cuts.js";

const ASK_AGAIN_MS = 300;

const pause = (ms) =>
  new Promise((resolve) => {
    setTimeout(resolve, ms);
  });

export class SplitPage {
  constructor({ name }) {
    this.name = name;
    this.title = `Cut ${name}`;
    this.element = el("main", { id: "main", tabindex: -1, class: "split" });
    this.abort = new AbortController();
    this.quiet_s = 2;
  }

  async start() {
    refill(this.element, el("h1", {}, this.title), el("p", { class: "reading" }, "Reading the recording …"));
    const { signals } = await getRun(this.name, { signal: this.abort.signal });
    this.rate = signals.find(({ name }) => name === "event_rate");
    this.endWatch = onConnection((reachable) => {
      if (reachable) this.lines?.again();
    });
    await this.#propose();
  }

  /// Asks until the server has done its work.
  async #settled(words) {
    for (;;) {
      const desk = await getSplit(this.name, Math.round(1000 * this.quiet_s), { signal: this.abort.signal });
      if (desk.state !== "proposing" && desk.state !== "cutting") return desk;
      const line = this.element.querySelector(".reading");
      if (line) line.textContent = `${words} ${Math.round(100 * desk.share)} %`;
      await pause(ASK_AGAIN_MS);
      this.abort.signal.throwIfAborted();
    }
  }

  async #propose() {
    this.lines?.stop();
    this.lines = this.keys = null;
    refill(this.element, el("h1", {}, this.title), el("p", { class: "reading", role: "status" }, "Looking for quiet stretches …"));
    const desk = await this.#settled("Looking for quiet stretches …");
    if (!desk.length_us) throw new Error(desk.error ?? "there is no proposal");
    this.desk = desk;
    this.cuts = desk.cuts_us;
    this.#draw();
    this.#showResult(desk);
  }

  #draw() {
    this.problem = el("p", { class: "error", role: "alert" });
    this.lines = new CutLines({
      rate: this.rate,
      load: async (request, options) => {
        const answer = await getSignals(this.name, request, options);
        this.problem.textContent = "";
        return answer;
      },
      failed: (error) => {
        this.problem.textContent = `The event rate cannot be shown: ${error.message}.`;
      },
      length_us: this.desk.length_us,
      touches: this.desk.touches,
      changed: (cuts) => {
        this.cuts = cuts;
        this.#fill();
      },
    });
    this.runs = el("tbody");
    this.objects = el("input", { id: "objects", value: this.desk.object, size: 24 });
    this.quiet = el("input", { id: "quiet", value: String(this.quiet_s), size: 6, inputmode: "decimal" });
    this.at = el("input", { id: "cut-at", size: 10, inputmode: "decimal", placeholder: "seconds" });
    this.result = el("div", { class: "split-result", role: "status" });
    this.write = button("Write runs", () => this.#write(), { class: "primary", "data-key": "write" });
    refill(
      this.element,
      el("h1", {}, this.title, " into runs"),
      el("p", {}, el("a", { href: runAddress(this.name) }, "The recording"), ". Each line is a cut. Drag it, or move it by ← and → (10 ms, with Shift 0.1 s; less if you zoom in). Delete removes it, a double click adds one. The wheel zooms."),
      el("div", { class: "tools" }, el("span", { class: "group" }, axisButtons(this.lines, "Whole recording"), button("?", () => showSplitHelp(this.keys), { "aria-label": "Keys", title: "Keys (?)" }))),
      this.problem,
      this.lines.element,
      el(
        "div",
        { class: "tools" },
        el("span", { class: "group" }, el("label", { for: "cut-at" }, "Cut at"), this.at, button("Add", () => this.#add())),
        el("span", { class: "group" }, el("label", { for: "quiet" }, "A run ends after [s]"), this.quiet, button("Propose again", () => this.#again())),
      ),
      el(
        "div",
        { class: "scroll", role: "region", tabindex: 0, "aria-label": "Table of runs" },
        el(
          "table",
          { class: "figures split-runs" },
          el("caption", {}, "The runs between the cuts"),
          el("thead", {}, el("tr", {}, ["Run", "Start", "End", "Length", "Press", "Slip", "Release", "Cut before it"].map((words) => el("th", { scope: "col" }, words)))),
          this.runs,
        ),
      ),
      el("div", { class: "tools" }, el("span", { class: "group" }, el("label", { for: "objects" }, "Object of all runs, or of each one"), this.objects), this.write),
      this.result,
    );
    this.keys = splitKeys({ lines: this.lines, page: this });
    this.lines.start(this.cuts);
    this.#fill();
  }

  #fill() {
    const runs = runsBetween(this.cuts, this.desk.touches, this.desk.length_us);
    const cell = (label, words) => el("td", { "data-label": label }, words);
    refill(
      this.runs,
      runs.map((run, i) =>
        el(
          "tr",
          { class: run.presses > 0 && run.slips > 0 ? "" : "incomplete" },
          el("th", { scope: "row", "data-label": "Run" }, String(i + 1)),
          cell("Start", secondsText(run.begin_us, 1e7)),
          cell("End", secondsText(run.end_us, 1e7)),
          cell("Length", secondsText(run.end_us - run.begin_us, 1e7)),
          cell("Press", String(run.presses)),
          cell("Slip", String(run.slips)),
          cell("Release", String(run.releases)),
          el(
            "td",
            {},
            i > 0 &&
              button("Remove", () => this.lines.set(withoutCut(this.cuts, i - 1)), { "aria-label": `Remove the cut before run ${i + 1}`, "data-key": `remove-${i}` }),
          ),
        ),
      ),
    );
    this.write.textContent = `Write ${counted(runs.length, "run")}`;
  }

  #add() {
    const at_us = secondsFrom(this.at.value);
    const cuts = at_us === null ? null : withCut(this.cuts, at_us, this.desk.length_us);
    if (cuts) this.lines.set(cuts);
    else announce(`There can be no cut at '${this.at.value}': give seconds inside the recording, away from other cuts.`, "error");
  }

  async #again() {
    const seconds = secondsFrom(this.quiet.value);
    if (seconds === null || seconds < 50_000 || seconds > 3600e6) {
      announce("A run ends after 0.05 to 3600 s without a touch.", "error");
      return;
    }
    this.quiet_s = seconds / 1e6;
    await this.#propose().catch((error) => this.#failed(error));
  }

  async #write() {
    const runs = runsBetween(this.cuts, this.desk.touches, this.desk.length_us);
    const { names, problem } = objectsFrom(this.objects.value, runs.length);
    if (problem) {
      announce(problem, "error");
      this.objects.focus();
      return;
    }
    this.write.disabled = true;
    try {
      refill(this.result, el("p", { class: "reading" }, "Writing runs …"));
      await sendSplit(this.name, { cuts_us: this.cuts, objects: names });
      this.#showResult(await this.#settled("Writing runs …"));
    } catch (error) {
      this.#failed(error);
    } finally {
      this.write.disabled = false;
    }
  }

  #failed(error) {
    if (error.name === "AbortError") return;
    const words = el("p", { class: "error", role: "alert" }, `This was not possible: ${error.message}.`);
    if (this.lines) refill(this.result, words);
    else refill(this.element, el("h1", {}, this.title), words, el("p", {}, button("Try again", () => this.#again())));
  }

  #showResult({ result, error, out }) {
    const open = incompleteRuns(runsBetween(this.cuts, this.desk.touches, this.desk.length_us));
    const parts = [];
    if (error) parts.push(el("p", { class: "error", role: "alert" }, `The runs were not written: ${error}.`));
    if (result) {
      const kept = result.runs.filter((run) => run.kept).length;
      parts.push(el("p", { class: "written" }, `${counted(result.runs.length, "run")} in ${out}${kept ? `, ${kept} of them were there already` : ""}: `, result.runs.map((run) => run.run).join(", "), "."));
      if (result.warning) parts.push(el("p", { class: "error", role: "alert" }, `${result.warning}.`));
      parts.push(el("p", {}, "Label them next: ", el("code", {}, `tactile label ${out}`), "."));
    } else if (open.length) {
      parts.push(el("p", { class: "empty" }, `Without a press or without a slip: run ${open.join(", ")}. Look at ${open.length === 1 ? "it" : "them"} before you write.`));
    }
    refill(this.result, parts);
  }

  key(event) {
    if (event.key === "Escape") document.activeElement?.blur();
    else if (this.keys) press(event, this.keys);
  }

  stop() {
    this.abort.abort();
    this.endWatch?.();
    this.lines?.stop();
  }
}
