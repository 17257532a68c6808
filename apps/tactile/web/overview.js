// The whole run as one thin line: where its labels are, and which part of it the axis shows.

import { el } from "./dom.js";
import { fitted } from "./time_view.js";

export class Overview {
  constructor(state) {
    this.state = state;
    this.window = el("div", { class: "window" });
    this.cursor = el("div", { class: "cursor" });
    this.marks = el("div", { class: "marks" });
    this.element = el(
      "div",
      { class: "overview", "aria-hidden": "true", onpointerdown: (e) => this.#go(e), onpointermove: (e) => e.buttons && this.#go(e) },
      this.marks,
      this.window,
      this.cursor,
    );
  }

  #share(us) {
    return `${(100 * us) / this.state.length_us}%`;
  }

  draw() {
    const { labels, view } = this.state;
    this.marks.replaceChildren(
      ...labels.intervals.map((i) =>
        el("div", { class: i.touch, style: { left: this.#share(i.start_us), width: this.#share(i.end_us - i.start_us) } }),
      ),
    );
    this.window.style.left = this.#share(view.from_us);
    this.window.style.width = this.#share(view.to_us - view.from_us);
    this.drawCursor();
  }

  drawCursor() {
    this.cursor.style.left = this.#share(this.state.at_us);
  }

  #go(event) {
    const box = this.element.getBoundingClientRect();
    const at = ((event.clientX - box.left) / box.width) * this.state.length_us;
    const span = this.state.view.to_us - this.state.view.from_us;
    this.state.setView(fitted({ from_us: at - span / 2, to_us: at + span / 2 }, this.state.length_us));
  }
}
