// The labels over the signals: a band for each interval, its 95 % intervals, and a handle at each start and end.

import { el } from "./dom.js";
import { secondsText, withinText } from "./format.js";
import { pixelOf } from "./time_view.js";

const END_WORDS = { start: "start", end: "end" };

export class BandLayer {
  /// @param handles  {pointerdown(event, id, end), keydown(event, id, end), focus(id, end), blur(id, end)}
  constructor(state, handles) {
    this.state = state;
    this.handles = handles;
    this.element = el("div", { class: "bands" });
    this.cursor = el("div", { class: "cursor" });
    this.parts = new Map(); // kept between redraws: a handle that is dragged must stay the same element
  }

  draw(width) {
    const { state } = this;
    this.width = width;
    const used = new Set();
    const part = (key, make) => {
      used.add(key);
      if (!this.parts.has(key)) {
        this.parts.set(key, make());
        this.element.append(this.parts.get(key));
      }
      return this.parts.get(key);
    };
    const { labels, view } = state;
    for (const [index, release] of (labels.releases ?? []).entries()) this.#band(part, `release ${index}`, release, "release", "release");
    for (const [index, gone] of (labels.rejected ?? []).entries()) this.#band(part, `rejected ${index}`, gone, "rejected", "removed");
    for (const interval of labels.intervals) this.#interval(part, interval, view);
    if (state.mark)
      this.#band(
        part,
        "mark",
        { start_us: state.mark.start_us, end_us: Math.max(state.at_us, state.mark.start_us) },
        `mark ${state.mark.touch}`,
        `${state.mark.touch} …`,
      );
    for (const [key, element] of this.parts) {
      if (used.has(key)) continue;
      element.remove();
      this.parts.delete(key);
    }
    this.drawCursor();
  }

  #place(element, from_us, to_us) {
    const [left, right] = [from_us, to_us].map((t) => pixelOf(t, this.state.view, this.width));
    const from = Math.max(left, -4);
    const to = Math.min(right, this.width + 4);
    element.hidden = to < from;
    element.style.left = `${from}px`;
    element.style.width = `${Math.max(to - from, 1)}px`;
  }

  #band(part, key, { start_us, end_us }, kind, words) {
    const band = part(key, () => el("div", {}, el("span", { class: "band-name" })));
    band.className = `band ${kind}`;
    band.firstChild.textContent = words;
    this.#place(band, start_us, end_us);
    return band;
  }

  #interval(part, interval, view) {
    const { state } = this;
    const flagged = state.labels.flags.some((flag) => flag.interval_id === interval.id && !flag.confirmed);
    const selected = state.selected?.id === interval.id;
    const kind = [interval.touch, selected ? "selected" : "", interval.confirmed ? "confirmed" : "", flagged ? "flagged" : ""].join(" ");
    const mark = flagged ? " ⚑" : interval.confirmed ? " ✓" : "";
    this.#band(part, `band ${interval.id}`, interval, kind, interval.id + mark);
    for (const end of ["start", "end"]) {
      const [low, at, high] = [`${end}_low_us`, `${end}_us`, `${end}_high_us`].map((name) => interval[name]);
      const doubt = part(`doubt ${interval.id} ${end}`, () => el("div", {}));
      doubt.className = `doubt ${interval.touch}`;
      this.#place(doubt, low ?? at, high ?? at);
      this.#handle(part, interval, end, { low, at, high, view });
    }
  }

  #handle(part, interval, end, { low, at, high, view }) {
    const { state, handles } = this;
    const { id } = interval;
    const handle = part(`handle ${id} ${end}`, () =>
      el("div", {
        role: "slider",
        tabindex: 0,
        "data-key": `handle ${id} ${end}`,
        "data-id": id,
        "data-end": end,
        "aria-orientation": "horizontal",
        onpointerdown: (event) => handles.pointerdown(event, id, end),
        onkeydown: (event) => handles.keydown(event, id, end),
        onfocus: () => handles.focus(id, end),
      }),
    );
    const moved = state.draft?.id === id && state.draft.end === end;
    handle.className = `handle ${interval.touch} ${end}${moved ? " moved" : ""}${state.selected?.id === id && state.selected.end === end ? " selected" : ""}`;
    handle.setAttribute("aria-label", `${END_WORDS[end]} of ${id}`);
    handle.setAttribute("aria-valuemin", "0");
    handle.setAttribute("aria-valuemax", String(state.length_us / 1e6));
    handle.setAttribute("aria-valuenow", String(at / 1e6));
    handle.setAttribute(
      "aria-valuetext",
      `${secondsText(at)}, 95 % interval ${withinText(low ?? at, at, high ?? at)}${moved ? ", not saved" : ""}`,
    );
    const x = pixelOf(at, view, this.width);
    const inside = x >= -1 && x <= this.width + 1;
    handle.style.left = `${inside ? x : x < 0 ? 0 : this.width}px`;
    handle.classList.toggle("outside", !inside); // still in the order of Tab; the axis goes there when it has the focus
  }

  drawCursor() {
    const x = pixelOf(this.state.at_us, this.state.view, this.width);
    this.cursor.hidden = x < -1 || x > this.width + 1;
    this.cursor.style.left = `${x}px`;
    const mark = this.parts.get("mark");
    if (mark && this.state.mark) this.#place(mark, this.state.mark.start_us, Math.max(this.state.at_us, this.state.mark.start_us));
  }
}
