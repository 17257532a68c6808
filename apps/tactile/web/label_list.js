// The intervals and flags of a run as a list: what the drags do, with words, fields and buttons.

import { announce, button, el, refill } from "./dom.js";
import { secondsFrom, secondsText, withinText } from "./format.js";
import { LEAST_WITHIN_US } from "./snapping.js";

export class LabelList {
  constructor(state, actions) {
    this.state = state;
    this.actions = actions;
    this.rows = el("div", { class: "interval-list" });
    this.flags = el("ul", { class: "flags" });
    this.remarks = el("div", {});
    this.element = el(
      "section",
      { "aria-labelledby": "labels-title" },
      el("h2", { id: "labels-title" }, "Labels"),
      this.rows,
      this.flags,
      this.remarks,
    );
    this.redraw = () => this.draw();
    for (const name of ["labels", "draft", "selection"]) state.addEventListener(name, this.redraw);
  }

  draw() {
    const { labels } = this.state;
    refill(
      this.rows,
      labels.intervals.length
        ? labels.intervals.map((interval) => this.#row(interval))
        : el(
            "p",
            { class: "empty" },
            labels.version ? "No intervals. Press P where a press begins, and P again where it ends; S for a slip." : "None yet.",
          ),
    );
    refill(
      this.flags,
      labels.flags.map((flag) => this.#flag(flag)),
    );
    const remarks = labels.remarks ?? [];
    refill(
      this.remarks,
      remarks.length
        ? el(
            "details",
            {},
            el("summary", {}, `Remarks (${remarks.length})`),
            el(
              "ul",
              {},
              remarks.map((r) => el("li", {}, r)),
            ),
          )
        : null,
    );
  }

  #row(interval) {
    const { id } = interval;
    const { actions, state } = this;
    const selected = state.selected?.id === id;
    const name = button(
      id,
      () => {
        state.select({ id, end: "start" });
        actions.showClosely(interval.start_us);
      },
      { class: "link", "data-key": `go ${id}`, "aria-pressed": String(selected), title: "Show its start closely" },
    );
    const touch = el(
      "select",
      { "aria-label": `Class of ${id}`, "data-key": `class ${id}`, onchange: (e) => actions.changeClass(id, e.target.value) },
      ["press", "slip"].map((t) => el("option", { value: t, selected: t === interval.touch }, t)),
    );
    return el(
      "fieldset",
      { class: `interval ${interval.touch}${selected ? " selected" : ""}` },
      el("legend", { class: "hidden" }, id),
      el("div", { class: "interval-head" }, name, touch, this.#stateOf(interval)),
      this.#time(interval, "start"),
      this.#time(interval, "end"),
      el(
        "div",
        { class: "interval-actions" },
        interval.confirmed
          ? null
          : button("Confirm", () => actions.confirm(id), { "data-key": `confirm ${id}`, "aria-label": `Confirm ${id}` }),
        button("Remove", () => actions.remove(id), { "data-key": `remove ${id}`, "aria-label": `Remove ${id}` }),
      ),
    );
  }

  #stateOf(interval) {
    const flagged = this.state.labels.flags.some((flag) => flag.interval_id === interval.id && !flag.confirmed);
    if (flagged) return el("span", { class: "state flagged" }, "⚑ flagged");
    return interval.confirmed ? el("span", { class: "state confirmed" }, "✓ confirmed") : el("span", { class: "state" }, "not confirmed");
  }

  #time(interval, end) {
    const { id } = interval;
    const [low, at, high] = [`${end}_low_us`, `${end}_us`, `${end}_high_us`].map((name) => interval[name]);
    const field = el("input", {
      type: "text",
      inputmode: "decimal",
      size: 9,
      value: (at / 1e6).toFixed(6),
      "data-key": `${end} ${id}`,
      "aria-label": `${end} of ${id} in seconds`,
      onchange: (event) => this.#typed(interval, end, event.target),
    });
    const go = button(
      "◎",
      () => {
        this.state.select({ id, end });
        this.actions.showClosely(at);
      },
      { class: "icon", "data-key": `show ${end} ${id}`, "aria-label": `Show the ${end} of ${id} closely` },
    );
    return el(
      "div",
      { class: "time" },
      el("span", { class: "time-name" }, end),
      field,
      el("span", { class: "unit" }, "s"),
      el("span", { class: "within", title: "95 % interval" }, withinText(low ?? at, at, high ?? at)),
      go,
    );
  }

  #typed(interval, end, field) {
    const to_us = secondsFrom(field.value);
    const was = interval[`${end}_us`];
    if (to_us === null || to_us < 0 || to_us > this.state.length_us) {
      announce(`"${field.value}" is not a time of this run; expected 0 to ${secondsText(this.state.length_us)}.`, "error");
      field.value = (was / 1e6).toFixed(6);
    } else if (to_us !== was) {
      this.actions.make({
        kind: "move",
        id: interval.id,
        end,
        to_us,
        within_us: LEAST_WITHIN_US,
        ...(end === "start" ? { end_earlier: true } : {}),
      });
    }
  }

  #flag(flag) {
    const about = flag.interval_id ? `${flag.interval_id}: ` : "";
    if (flag.confirmed) {
      return el(
        "li",
        { class: "lifted" },
        el("span", {}, `${about}${flag.what} `),
        el("span", { class: "why" }, flag.lifted_why ? `(lifted: ${flag.lifted_why})` : "(lifted)"),
      );
    }
    return el(
      "li",
      { class: "open" },
      el("span", {}, `⚑ ${about}${flag.what} `),
      button("Lift …", () => this.actions.lift(flag), { "data-key": `lift ${flag.index}`, "aria-label": `Lift the flag: ${flag.what}` }),
    );
  }
}
