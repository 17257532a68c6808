// The whole run as one thin line: where its touches are, and which part of it the axis shows.

import { el } from "./dom.js";
import { around } from "./time_view.js";

export class Overview {
  /// @param axis  {view, length_us, labels, at_us, show(view)}; without at_us there is no cursor
  constructor(axis) {
    this.axis = axis;
    this.window = el("div", { class: "window" });
    this.cursor = el("div", { class: "cursor" });
    this.marks = el("div", { class: "marks" });
    this.element = el(
      "div",
      { class: "overview", "aria-hidden": "true", onpointerdown: (e) => this.#go(e), onpointermove: (e) => e.buttons && this.#go(e) },
      this.marks,
      this.window,
      axis.at_us === undefined ? null : this.cursor,
    );
  }

  #share(us) {
    return `${(100 * us) / this.axis.length_us}%`;
  }

  draw() {
    const { labels, view } = this.axis;
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
    this.cursor.style.left = this.#share(this.axis.at_us);
  }

  #go(event) {
    const box = this.element.getBoundingClientRect();
    const { view, length_us } = this.axis;
    const at = ((event.clientX - box.left) / box.width) * length_us;
    this.axis.show(around(at, view.to_us - view.from_us, length_us));
  }
}
