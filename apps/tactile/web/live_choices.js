// The buttons and keys of a live page: what a person can choose while runs are recorded. A choice answers the question that the page
// shows, by its number: the program refuses an answer that comes too late.

import { announce, el, refill } from "./dom.js";

const KEYS = { start: "Enter", stop: "Enter", redo: "r", skip: "s" }; // none ends the session: it would be pressed by mistake

/// Sends a choice. @return  why it was not done; empty if it was
async function send(question, choice) {
  try {
    const answer = await fetch("/api/live/choice", {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ question, choice }),
    });
    return answer.ok ? "" : (await answer.json()).error;
  } catch {
    return "The program does not answer, so nothing was done.";
  }
}

export class LiveChoices {
  constructor() {
    this.element = el("div", { class: "live-choices", role: "group", "aria-label": "What to do" });
    this.question = null;
    this.offered = [];
    this.answered = null; // the number of the question that was answered
    document.addEventListener("keydown", (event) => this.#key(event));
    // A key that is held is one choice: the next question's button gets the focus.
    this.element.addEventListener("keydown", (event) => {
      if (event.repeat) event.preventDefault();
    });
  }

  /// Shows what the newest state offers.
  show(state) {
    const { question = null, choices = [] } = state ?? {};
    if (question === this.question) return;
    this.question = question;
    this.offered = choices;
    const hadFocus = this.element.contains(document.activeElement);
    refill(
      this.element,
      choices.map(({ choice, words }) =>
        el(
          "button",
          { type: "button", class: choice, onclick: () => this.#choose(choice) },
          words,
          KEYS[choice] ? el("kbd", {}, KEYS[choice]) : null,
        ),
      ),
    );
    // Enter does what its key says, also after a click on another button.
    if (hadFocus) this.element.querySelector("button")?.focus();
  }

  async #choose(choice) {
    const question = this.question;
    if (this.answered === question) return;
    this.answered = question;
    const why = await send(question, choice);
    if (!why) return;
    announce(why, "error");
    if (this.answered === question) this.answered = null;
  }

  #key(event) {
    // Enter on a button or a link is theirs.
    const isElsewhere = event.target.closest?.(event.key === "Enter" ? "button, a, input, select, textarea" : "input, select, textarea");
    if (event.repeat || event.ctrlKey || event.altKey || event.metaKey || isElsewhere) return;
    const found = this.offered.find(({ choice }) => KEYS[choice] === event.key);
    if (!found) return;
    event.preventDefault();
    this.#choose(found.choice);
  }
}
