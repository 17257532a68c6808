// Begins the live page of `record --preview` and `detect --page`: it shows what the server sends twenty times a second.

import { announce, el, refill } from "./dom.js";
import { CountsPicture } from "./counts_picture.js";
import { LiveCharts } from "./live_charts.js";
import { LiveChoices } from "./live_choices.js";
import { LiveFilm } from "./live_film.js";
import { Steps, factsOf, headline, lostWords, warningsOf } from "./live_words.js";

const LOOK_UP_MS = 1000;

async function bytesOf(kind, signal) {
  const answer = await fetch(`/api/live/${kind}`, { signal });
  if (answer.status !== 200) throw new Error(`no picture of ${kind} yet`);
  return answer.arrayBuffer();
}

/// The parts of the page.
class LivePage {
  constructor() {
    this.title = el("h1", {}, "Connecting");
    this.detail = el("span", { class: "live-detail" });
    this.warnings = el("ul", { class: "live-warnings", "aria-live": "polite", "aria-label": "Warnings" });
    this.facts = el("dl", { class: "live-facts" });
    this.messages = el("ul", { class: "live-messages" });
    this.charts = new LiveCharts();
    this.choices = new LiveChoices();
    const picture = (kind, title) => new CountsPicture({ title, kind, load: (number, { signal }) => bytesOf(kind, signal), failed: () => {} });
    this.events = picture("events", "Events");
    this.heatmap = picture("heatmap", "Heatmap");
    this.film = new LiveFilm();
    this.element = el(
      "main",
      { id: "main", tabindex: -1, class: "live" },
      el("div", { class: "live-head" }, this.title, this.detail),
      this.choices.element,
      this.warnings,
      el(
        "div",
        { class: "live-body" },
        el("div", { class: "live-left" }, el("div", { class: "pictures" }, this.events.element, this.heatmap.element, this.film.element), this.charts.element),
        el("div", { class: "live-right" }, el("h2", {}, "Now"), this.facts, this.messages),
      ),
    );
    this.steps = new Steps();
    this.shown = {};
  }

  show(message) {
    const { words, detail = "", mark } = headline(message);
    if (this.title.textContent !== words) this.title.textContent = words;
    this.title.dataset.mark = mark;
    this.detail.textContent = detail;
    document.title = `${words} – tactile`;
    this.choices.show(message.state);
    this.#fill(this.warnings, warningsOf(message), (warning) => el("li", {}, warning));
    this.#fill(this.facts, factsOf(message), ([term, text, bad]) => [el("dt", {}, term), el("dd", { class: bad ? "bad" : "" }, text)]);
    this.#fill(this.messages, message.state?.messages ?? [], (line) => el("li", {}, line));
    this.steps.add(message.steps);
    this.charts.show(this.steps, message.columns);
    this.film.show(message.ended ? undefined : message.state?.has_film);
    const { picture, picture_us } = message.live;
    if (!message.ended && picture > 0 && picture !== this.picture) {
      this.picture = picture;
      this.events.show(picture);
      this.heatmap.show(picture);
      this.events.caption.firstChild.textContent = `Events of ${picture_us / 1000} ms`;
    }
  }

  /// Only what has changed: a person may be selecting text.
  #fill(container, items, make) {
    const key = JSON.stringify(items);
    if (container.dataset.shown === key) return;
    container.dataset.shown = key;
    refill(container, items.map(make));
  }
}

function begin() {
  const page = new LivePage();
  document.getElementById("main").replaceWith(page.element);
  const banner = document.getElementById("lost");
  let last = null;
  let ended = false;
  let answers = true;
  const source = new EventSource("/api/live");
  source.onmessage = ({ data }) => {
    last = performance.now();
    if (!answers) announce("The program answers again.", "note", { news: true });
    answers = true;
    banner.hidden = true;
    const message = JSON.parse(data);
    page.show(message);
    if (!message.ended) return;
    ended = true;
    source.close();
    banner.textContent = `${headline(message).words} This page shows its last state.`;
    banner.hidden = false;
  };
  const tell = () => {
    if (ended || answers) return;
    banner.textContent = lostWords((performance.now() - (last ?? 0)) / 1000, last !== null);
    banner.hidden = false;
  };
  source.onerror = () => {
    answers = false;
    tell();
  };
  setInterval(tell, LOOK_UP_MS);
  document.getElementById("skip").addEventListener("click", (event) => {
    event.preventDefault();
    page.element.focus();
  });
}

begin();
