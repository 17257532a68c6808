// The time axis of a run: overview, labels and signals; zoom, pan, cursor and drags by mouse, pen, finger and key.

import { AxisGestures } from "./axis_gestures.js";
import { BandLayer } from "./band_layer.js";
import { SignalStrips } from "./signal_strips.js";
import { Overview } from "./overview.js";
import { el } from "./dom.js";
import { MOST_EVENT_TIMES_US, neededEventTimes } from "./detail.js";
import { Latest } from "./latest.js";
import { timeAt, zoomedAround } from "./time_view.js";

const LEAST_TIMES_US = 200; // of single events; with more than 20 000 in it, a tick is as good

export class Timeline {
  /// @param load  {signals(request, options), eventTimes(window, options)} of this run
  /// @param drag  EndDrag: moves an end
  constructor({ state, signals, load, drag, failed }) {
    this.state = state;
    this.load = load;
    this.drag = drag;
    this.most_us = MOST_EVENT_TIMES_US;
    this.strips = new SignalStrips({ signals, load: load.signals, length_us: state.length_us, failed });
    this.bands = new BandLayer(state, {
      pointerdown: (event, id, end) => this.#startDrag(event, id, end),
      keydown: (event, id, end) => drag.key(event, id, end),
      focus: (id, end) => drag.focused(id, end),
    });
    this.overview = new Overview(this);
    const isFree = (target) => !target.closest(".handle");
    this.surface = el(
      "div",
      { class: "surface", ondblclick: (e) => isFree(e.target) && this.gestures.zoomAt(e, 0.25) },
      this.bands.element,
      this.bands.cursor,
    );
    this.gestures = new AxisGestures(this.surface, this, { isFree, clicked: (e) => this.#clicked(e) });
    this.element = el(
      "section",
      { class: "timeline", "aria-label": "Time axis: labels and signals" },
      this.overview.element,
      el("div", { class: "stack" }, el("div", { class: "lane" }), this.strips.element, this.surface),
    );
    this.times = new Latest(
      (window, signal) => this.#loadTimes(window, signal),
      () => {},
    );
    this.listeners = {
      view: () => this.#viewChanged(),
      at: () => this.#atChanged(),
      labels: () => this.#redraw(),
      draft: () => this.#redraw(),
      selection: () => this.#redraw(),
      mark: () => this.#redraw(),
    };
  }

  start() {
    for (const [name, listener] of Object.entries(this.listeners)) this.state.addEventListener(name, listener);
    this.strips.start(this.state.view);
    this.sizes = new ResizeObserver(() => this.#resize());
    this.sizes.observe(this.element);
    this.#resize();
    this.#viewChanged();
    this.#atChanged();
  }

  stop() {
    for (const [name, listener] of Object.entries(this.listeners)) this.state.removeEventListener(name, listener);
    this.sizes?.disconnect();
    this.times.stop();
    this.strips.stop();
  }

  /// Asks again for what did not come.
  again() {
    this.strips.again();
    this.#wantTimes();
  }

  #resize() {
    this.strips.resize();
    const { left, width } = this.strips.area();
    this.width = width;
    this.surface.style.left = `${left}px`;
    this.surface.style.width = `${width}px`;
    this.overview.element.style.marginLeft = `${left}px`;
    this.overview.element.style.width = `${width}px`;
    this.#redraw();
  }

  get view() {
    return this.state.view;
  }
  get length_us() {
    return this.state.length_us;
  }
  get at_us() {
    return this.state.at_us;
  }
  get labels() {
    return this.state.labels;
  }
  show(view) {
    this.state.setView(view);
  }
  get usPerPixel() {
    return (this.view.to_us - this.view.from_us) / Math.max(this.width, 1);
  }

  #redraw() {
    Object.assign(this.element.dataset, this.state.view); // the view, for whoever looks at the document
    this.bands.draw(this.width);
    this.overview.draw();
  }

  #viewChanged() {
    this.strips.show(this.state.view);
    this.#redraw();
    this.#wantTimes();
  }

  #wantTimes() {
    const { view, at_us, length_us, events } = this.state;
    const need = neededEventTimes(view, at_us, length_us, events, this.most_us);
    if (need) this.times.ask(need);
  }

  #atChanged() {
    if (!this.state.playing) this.#wantTimes();
    this.bands.drawCursor();
    this.overview.drawCursor();
    this.strips.values(this.state.at_us);
  }

  async #loadTimes(window, signal) {
    const { t_us, too_many } = await this.load.eventTimes(window, { signal });
    if (too_many) this.most_us = Math.max((window.to_us - window.from_us) / 4, LEAST_TIMES_US);
    else if (t_us.length < 4000) this.most_us = Math.min(2 * this.most_us, MOST_EVENT_TIMES_US);
    if (!too_many) this.state.events = { ...window, t_us };
    else if (window.to_us - window.from_us > LEAST_TIMES_US) this.#wantTimes();
  }

  // Pointers

  #startDrag(event, id, end) {
    if (event.button !== 0) return;
    event.stopPropagation();
    const handle = event.currentTarget;
    handle.focus({ preventScroll: true });
    handle.setPointerCapture(event.pointerId);
    const grip = this.gestures.pixelOf(event) - (this.drag.timeOf(id, end) - this.state.view.from_us) / this.usPerPixel;
    const moved = (e) => this.drag.to(timeAt(this.gestures.pixelOf(e) - grip, this.state.view, this.width), e.altKey, this.usPerPixel);
    const done = (e) => {
      handle.removeEventListener("pointermove", moved);
      this.drag.drop(e.type === "pointercancel");
    };
    this.drag.begin(id, end);
    handle.addEventListener("pointermove", moved);
    handle.addEventListener("pointerup", done, { once: true });
    handle.addEventListener("pointercancel", done, { once: true });
  }

  #clicked(event) {
    this.state.setAt(this.gestures.timeOf(event), true);
    const band = this.state.labels.intervals.find((i) => i.start_us <= this.state.at_us && this.state.at_us < i.end_us);
    if (band && this.state.selected?.id !== band.id) this.state.select({ id: band.id, end: "start" });
  }

  /// Around the cursor if it is on the screen, else around the middle. Infinity shows the whole run.
  zoom(factor) {
    this.show(zoomedAround(this.view, this.at_us, factor, this.length_us));
  }
}
