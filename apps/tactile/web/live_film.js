// The newest picture of the film on the live page.

import { el } from "./dom.js";

export class LiveFilm {
  constructor() {
    this.image = el("img", { alt: "The film now" });
    this.element = el("figure", { class: "picture film", hidden: true }, el("div", { class: "frame" }, this.image), el("figcaption", {}, "Film"));
    this.asks = false;
  }

  /// Asks for the newest picture, one at a time: a slow line gets fewer.
  /// @param has_film  whether the film continues; undefined: the shown picture stays
  async show(has_film) {
    if (has_film === false) this.element.hidden = true;
    if (!has_film || this.asks) return;
    this.asks = true;
    try {
      const answer = await fetch("/api/live/film");
      if (answer.status === 200) await this.#draw(await answer.blob());
    } catch {
      // The page says already that the program does not answer.
    } finally {
      this.asks = false;
    }
  }

  async #draw(blob) {
    const before = this.image.src;
    this.image.src = URL.createObjectURL(blob);
    await this.image.decode().catch(() => {});
    if (before) URL.revokeObjectURL(before);
    this.element.hidden = false;
  }
}
