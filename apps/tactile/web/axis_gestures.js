// Zoom and pan of a time axis by wheel, drag, fingers and buttons.

import { button, el } from "./dom.js";
import { fitted, panned, timeAt, zoomed, zoomedAround } from "./time_view.js";

const CLICK_PX = 4; // a pointer that moved less has clicked

/// @param axis  as of AxisGestures
/// @param all  the words of the button that shows all
export function axisButtons(axis, all) {
  const zoom = (factor) => axis.show(zoomedAround(axis.view, null, factor, axis.length_us));
  const pan = (share) => axis.show(panned(axis.view, share * (axis.view.to_us - axis.view.from_us), axis.length_us));
  return [
    button("−", () => zoom(2), { "aria-label": "Zoom out" }),
    button("+", () => zoom(0.5), { "aria-label": "Zoom in" }),
    button("‹", () => pan(-0.5), { "aria-label": "Earlier" }),
    button("›", () => pan(0.5), { "aria-label": "Later" }),
    button(all, () => zoom(Infinity)),
  ];
}

/// Listens on `surface`, which lies over the axis.
export class AxisGestures {
  /// @param axis  {view, width, length_us, show(view)}: what is shown, its width in pixels, the length of all
  /// @param isFree  (target) => whether a pointer that goes down there is for the axis
  /// @param clicked  (event) => …, after a click
  constructor(surface, axis, { isFree = () => true, clicked = () => {} } = {}) {
    Object.assign(this, { surface, axis, isFree, clicked });
    this.pointers = new Map();
    const listeners = { pointerdown: this.#down, pointermove: this.#move, pointerup: this.#up, pointercancel: this.#up, wheel: this.#wheel };
    for (const [name, listener] of Object.entries(listeners)) surface.addEventListener(name, listener.bind(this), { passive: false });
  }

  /// From the axis' left edge.
  pixelOf(event) {
    return event.clientX - this.surface.getBoundingClientRect().left;
  }

  timeOf(event) {
    return this.#timeAt(this.pixelOf(event));
  }

  /// The time under the pointer stays where it is.
  zoomAt(event, factor) {
    this.#zoom(this.timeOf(event), factor);
  }

  #timeAt(pixel) {
    return timeAt(pixel, this.axis.view, this.axis.width);
  }
  #zoom(at_us, factor) {
    this.axis.show(zoomed(this.axis.view, at_us, factor, this.axis.length_us));
  }
  #pan(pixels) {
    const { view, width, length_us } = this.axis;
    this.axis.show(panned(view, (pixels * (view.to_us - view.from_us)) / Math.max(width, 1), length_us));
  }

  #down(event) {
    if (event.button > 1 || !this.isFree(event.target)) return;
    this.surface.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: this.pixelOf(event), from: this.pixelOf(event), shift: event.shiftKey });
    this.dragged = false;
  }

  #move(event) {
    const pointer = this.pointers.get(event.pointerId);
    if (!pointer) return;
    const x = this.pixelOf(event);
    if (Math.abs(x - pointer.from) > CLICK_PX) this.dragged = true;
    if (this.pointers.size === 2) this.#pinch(event.pointerId, x);
    else if (this.dragged && !pointer.shift) this.#pan(pointer.x - x);
    else if (pointer.shift) this.#choose(pointer.from, x);
    pointer.x = x;
  }

  #pinch(id, x) {
    const [other] = [...this.pointers].filter(([key]) => key !== id).map(([, pointer]) => pointer);
    const before = Math.abs(this.pointers.get(id).x - other.x);
    const now = Math.abs(x - other.x);
    if (before >= 8 && now >= 8) this.#zoom(this.#timeAt(other.x), before / now);
  }

  #choose(from, to) {
    this.chosen ??= this.surface.appendChild(el("div", { class: "chosen" }));
    this.chosen.style.left = `${Math.min(from, to)}px`;
    this.chosen.style.width = `${Math.abs(to - from)}px`;
  }

  #up(event) {
    const pointer = this.pointers.get(event.pointerId);
    if (!pointer) return;
    this.pointers.delete(event.pointerId);
    if (this.chosen) {
      this.chosen.remove();
      this.chosen = null;
      const [from_us, to_us] = [pointer.from, this.pixelOf(event)].map((x) => this.#timeAt(x)).sort((a, b) => a - b);
      if (to_us > from_us) this.axis.show(fitted({ from_us, to_us }, this.axis.length_us));
    } else if (!this.dragged && event.type === "pointerup") {
      this.clicked(event);
    }
  }

  #wheel(event) {
    event.preventDefault();
    const sideways = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
    const size = (event.deltaMode === 1 ? 30 : 1) * (sideways && event.deltaX ? event.deltaX : event.deltaY);
    if (sideways) this.#pan(size);
    else this.zoomAt(event, Math.exp(size / 300));
  }
}
