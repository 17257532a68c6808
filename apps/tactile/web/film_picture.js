// The film's frame at the cursor.

import { el } from "./dom.js";
import { secondsText } from "./format.js";
import { lastUntil } from "./snapping.js";
import { Latest } from "./latest.js";

export class FilmPicture {
  /// @param frames  times of all frames, ascending
  /// @param load    async (at_us, {signal}) => {blob, frame_us}
  constructor({ frames, load, failed }) {
    this.frames = frames;
    this.shown = null;
    this.image = el("img", { alt: "Frame of the film at the cursor" });
    this.number = el("span", { class: "number" });
    this.element = el(
      "figure",
      { class: "picture film" },
      el("div", { class: "frame" }, this.image),
      el("figcaption", {}, "Film", this.number),
    );
    this.latest = new Latest(async (at_us, signal) => this.#draw(await load(at_us, { signal })), failed);
  }

  show(at_us) {
    const index = lastUntil(this.frames, at_us);
    const frame = index < 0 ? null : this.frames[index];
    if (frame === this.shown) return;
    this.shown = frame;
    this.number.textContent = frame === null ? "not begun yet" : `frame ${index + 1} of ${this.frames.length}, ${secondsText(frame)}`;
    if (frame !== null) this.latest.ask(at_us);
    this.image.classList.toggle("absent", frame === null);
  }

  again(at_us) {
    this.shown = null;
    this.show(at_us);
  }

  async #draw({ blob }) {
    this.image.classList.toggle("absent", blob === null);
    if (blob === null) return;
    const address = URL.createObjectURL(blob);
    const before = this.image.src;
    this.image.src = address;
    await this.image.decode().catch(() => {});
    if (before) URL.revokeObjectURL(before);
  }

  stop() {
    this.latest.stop();
    if (this.image.src) URL.revokeObjectURL(this.image.src);
  }
}
