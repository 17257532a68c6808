// Who changed what and when, the newest first; and the edits that were not made.

import { button, el, refill } from "./dom.js";
import { counted, whenText } from "./format.js";
import { wordsOf } from "./label_edits.js";

const SHOWN = 50;

export class HistoryList {
  constructor(state, actions) {
    this.state = state;
    this.actions = actions;
    this.all = false;
    this.aside = el("div", { class: "aside" });
    this.list = el("ol", { class: "history", reversed: true, tabindex: 0, "aria-labelledby": "history-title" });
    this.more = el("div", {});
    this.element = el(
      "section",
      { "aria-labelledby": "history-title" },
      el("h2", { id: "history-title" }, "History"),
      this.aside,
      this.list,
      this.more,
    );
    state.addEventListener("labels", () => this.draw());
  }

  draw() {
    const { queue } = this.state;
    const entries = [...(queue.labels.history ?? [])].reverse();
    const shown = this.all ? entries : entries.slice(0, SHOWN);
    this.list.setAttribute("start", String(entries.length));
    refill(this.aside, queue.setAside.length ? this.#setAside(queue) : null);
    refill(
      this.list,
      queue.waiting
        .toReversed()
        .map((operation) => el("li", { class: "waiting", value: 0 }, wordsOf(operation), el("span", { class: "when" }, "not saved yet"))),
      shown.map((entry, index) => this.#entry(entry, entries.length - index)),
    );
    const rest = entries.length - shown.length;
    refill(
      this.more,
      rest > 0
        ? button(`Show ${rest} more`, () => {
            this.all = true;
            this.draw();
          })
        : null,
      entries.length + queue.waiting.length === 0 ? el("p", { class: "empty" }, "No person has edited these labels.") : null,
    );
  }

  #entry(entry, number) {
    return el(
      "li",
      { class: entry.undone ? "undone" : "", value: number },
      el("span", { class: "what" }, entry.what),
      entry.undone ? " (undone)" : null,
      entry.why ? el("span", { class: "why" }, entry.why) : null,
      el("span", { class: "when" }, `${entry.who}, ${whenText(entry.when)}`),
    );
  }

  #setAside(queue) {
    return [
      el("p", {}, `${counted(queue.setAside.length, "edit")} not made:`),
      el(
        "ul",
        {},
        queue.setAside.map((operation, index) =>
          el(
            "li",
            {},
            el("span", {}, `${wordsOf(operation)} (${operation.reason}) `),
            button("Make it", () => queue.makeAfterAll(index), {
              "data-key": `make ${index}`,
              "aria-label": `Make it: ${wordsOf(operation)}`,
            }),
            button("Forget", () => queue.forget(index), { "data-key": `forget ${index}`, "aria-label": `Forget: ${wordsOf(operation)}` }),
          ),
        ),
      ),
    ];
  }
}
