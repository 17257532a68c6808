// Small pictures of runs, loaded when they come into view, three at a time. They are fetched, so that a token goes along.

import { getThumbnail } from "./api.js";
import { el } from "./dom.js";

const AT_ONCE = 3;
const AGAIN_MS = 3000; // the server makes them in the background
const MOST_TRIES = 20;

export class Thumbnails {
  constructor() {
    this.images = new Map();
    this.waiting = [];
    this.running = 0;
    this.abort = new AbortController();
    this.seen = new IntersectionObserver(
      (entries) => {
        for (const { isIntersecting, target } of entries) {
          if (!isIntersecting) continue;
          this.seen.unobserve(target);
          this.waiting.push({ image: target, tries: 0 });
        }
        this.#next();
      },
      { rootMargin: "200px" },
    );
  }

  /// The image of a run; the same one each time.
  of(name) {
    if (!this.images.has(name)) {
      const image = el("img", { alt: "", width: 80, height: 60, "data-run": name });
      this.images.set(name, image);
      this.seen.observe(image);
    }
    return this.images.get(name);
  }

  #next() {
    while (this.running < AT_ONCE && this.waiting.length) {
      const task = this.waiting.shift();
      this.running += 1;
      this.#load(task).finally(() => {
        this.running -= 1;
        this.#next();
      });
    }
  }

  async #load(task) {
    const blob = await getThumbnail(task.image.dataset.run, { signal: this.abort.signal }).catch(() => null);
    if (blob) {
      task.image.src = URL.createObjectURL(blob);
    } else if (blob === null && ++task.tries < MOST_TRIES && !this.abort.signal.aborted) {
      setTimeout(() => {
        this.waiting.push(task);
        this.#next();
      }, AGAIN_MS);
    }
  }

  stop() {
    this.abort.abort();
    this.waiting.length = 0;
    this.seen.disconnect();
    for (const image of this.images.values()) if (image.src) URL.revokeObjectURL(image.src);
  }
}
