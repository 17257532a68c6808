// The pictures of a run at the cursor: events, heatmap, and the film once the server has decoded it.

import * as api from "./api.js";
import { CountsPicture } from "./counts_picture.js";
import { FilmPicture } from "./film_picture.js";
import { el } from "./dom.js";

const FILM_EVERY_MS = 500;

export class RunPictures {
  /// @param failed  (error) => anything
  constructor({ state, failed }) {
    this.state = state;
    this.failed = failed;
    this.name = state.run.name;
    this.abort = new AbortController();
    this.pictures = [this.#counts("events", `Events of the last ${state.history_us / 1000} ms`), this.#counts("heatmap", "Heatmap")];
    if (state.run.film) this.pictures.push(this.#film());
    this.element = el("div", { class: "pictures" }, this.pictures.map((picture) => picture.element));
    state.addEventListener("at", () => this.#each("show"));
  }

  start(filmCame) {
    this.#each("show");
    this.#awaitFilm(filmCame).catch((error) => {
      if (!this.abort.signal.aborted) this.failed(error);
    });
  }

  #each(what) {
    for (const picture of this.pictures) picture[what](this.state.at_us);
  }

  #counts(kind, title) {
    const load = (at_us, options) => api.getCounts(this.name, kind, at_us, this.state.history_us, options);
    return new CountsPicture({ title, kind, failed: this.failed, load });
  }

  #film() {
    const load = (at_us, options) => api.getFilm(this.name, at_us, options);
    return new FilmPicture({ frames: this.state.frames, failed: this.failed, load });
  }

  /// The server shows the run before it has decoded the film.
  async #awaitFilm(filmCame) {
    let { run } = this.state;
    const options = { signal: this.abort.signal };
    while (run.film_pending) {
      await new Promise((resolve) => { setTimeout(resolve, FILM_EVERY_MS); });
      run = await api.getRun(this.name, options).catch(() => run);
      if (this.abort.signal.aborted) return;
    }
    if (!run.film || this.state.run.film) return;
    this.state.frames = (await api.getFrames(this.name, options)).t_us;
    const film = this.#film();
    this.pictures.push(film);
    this.element.append(film.element);
    film.show(this.state.at_us);
    filmCame();
  }

  /// Asks again for what did not come.
  again() {
    this.#each("again");
  }

  stop() {
    this.abort.abort();
    for (const picture of this.pictures) picture.stop();
  }
}
