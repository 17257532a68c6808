// The page of one run: builds its parts and joins them.

import * as api from "./api.js";
import { announce, button, el, refill } from "./dom.js";
import { EditQueue, Refused, Unreachable } from "./edit_queue.js";
import { EndDrag, draftWords } from "./end_drag.js";
import { HistoryList } from "./history_list.js";
import { LabelList } from "./label_list.js";
import { Player, otherSpeed } from "./player.js";
import { RunActions } from "./run_actions.js";
import { RunBar } from "./run_bar.js";
import { RunPictures } from "./run_pictures.js";
import { RunState } from "./run_state.js";
import { MODEL_SIGNALS } from "./signal_strips.js";
import { Timeline } from "./timeline.js";
import { counted, secondsText } from "./format.js";
import { keptChoice, keptEdits, keptPlace } from "./kept.js";
import { nextToReview } from "./run_order.js";
import { runAddress } from "./router.js";
import { runKeys, press } from "./keys.js";
import { settle } from "./conflict_dialog.js";

const LABELS_EVERY_MS = 4000; // another page or `tactile label` may change them
const RETRY_MS = 2000;
const NO_LABELS = { version: "", intervals: [], releases: [], flags: [], rejected: [], remarks: [], history: [], can_undo: false, can_redo: false };

export class RunPage {
  constructor({ name, at_us }) {
    this.name = name;
    this.asked_us = at_us;
    this.address = location.hash;
    this.abort = new AbortController();
    this.element = el("main", { id: "main", class: "run-page", tabindex: -1 });
    this.title = name;
    this.model = keptChoice("model", null);
    this.snap = keptChoice("snap", "automatic");
    this.speed = keptChoice("speed", 1);
  }

  async start() {
    const share = el("progress", { max: 1, value: 0, "aria-label": "Reading the run" });
    refill(this.element, el("h1", {}, this.name), el("p", { class: "reading" }, "Reading the recording … ", share));
    const options = {
      signal: this.abort.signal,
      reading: (part) => {
        share.value = part;
      },
    };
    this.run = await api.getRun(this.name, options);
    const [labels, frames, who] = await Promise.all([
      this.#labels(options),
      this.run.film ? api.getFrames(this.name, options) : { t_us: [] },
      api.getWho().catch(() => ({ who: "" })),
    ]);
    if (this.abort.signal.aborted) return;
    this.#build(labels, frames.t_us, who.who);
  }

  /// A run without labels, or with some that cannot be read, is still worth a look.
  async #labels(options) {
    try {
      return await api.getLabels(this.name, options);
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      if (error.status !== 404) this.without = error.message;
      return NO_LABELS;
    }
  }

  #build(labels, frames, who) {
    const data = document.body.dataset.data ?? "";
    const queue = new EditQueue({
      labels,
      store: keptEdits(data, this.name),
      send: (operation, version) => api.sendOperation(this.name, operation, version),
    });
    const state = new RunState({ run: this.run, queue, frames, place: keptPlace(this.name), at_us: this.asked_us });
    this.queue = queue;
    this.state = state;
    this.player = new Player(state, this.speed.load());
    this.bar = new RunBar({ state, page: this, who, player: this.player });
    this.drag = new EndDrag(
      state,
      () => this.snap.load(),
      (edit) => this.actions.make(edit),
    );
    this.actions = new RunActions({ state, player: this.player, drag: this.drag, reason: this.bar });
    this.timeline = this.#timeline(state);
    this.pictures = new RunPictures({ state, failed: (error) => this.#failed(error) });
    const lists = [new LabelList(state, this.actions), new HistoryList(state, this.actions)];
    refill(
      this.element,
      this.bar.head,
      this.#withoutLabels(),
      el(
        "div",
        { class: "run-body" },
        el(
          "div",
          { class: "run-left" },
          this.bar.tools,
          this.bar.choices,
          this.timeline.element,
          this.pictures.element,
        ),
        el("div", { class: "run-right" }, lists[0].element, el("p", { class: "why-field" }, this.bar.why), lists[1].element),
      ),
    );
    for (const part of lists) part.draw();
    this.keys = runKeys({ actions: this.actions, player: this.player, timeline: this.timeline, page: this });
    this.bar.start(this.actions);
    this.timeline.start();
    this.#listen();
    this.#resume();
  }

  /// One message: what is missing, and the button that makes it.
  #withoutLabels() {
    if (this.without) return el("p", { class: "error" }, `${this.without}. Until then nothing can be edited here.`);
    if (this.queue.labels.version) return null;
    const label = button("Label this run", () => this.#label(label), { class: "primary" });
    return el("p", { class: "no-labels" }, "This run has no labels yet. ", label, " finds its presses and slips, as ", el("code", {}, "tactile label"), " does.");
  }

  async #label(button) {
    button.disabled = true;
    button.textContent = "Labelling …";
    try {
      await api.sendLabel(this.name, { signal: this.abort.signal });
      dispatchEvent(new Event("hashchange")); // shows the run from the beginning: its robot and film now have clocks
    } catch (error) {
      if (error.name === "AbortError") return;
      button.disabled = false;
      button.textContent = "Label this run";
      this.#failed(error);
    }
  }

  #timeline(state) {
    const model = this.chosenModel;
    const signals = model ? [...this.run.signals, ...MODEL_SIGNALS] : this.run.signals;
    return new Timeline({
      state,
      signals,
      drag: this.drag,
      failed: (error) => this.#failed(error),
      load: {
        signals: (request, options) => api.getSignals(this.name, { ...request, model }, options),
        eventTimes: (window, options) => api.getEventTimes(this.name, window, options),
      },
    });
  }

  get chosenModel() {
    const models = this.run.models ?? [];
    const wanted = this.model.load();
    return models.includes(wanted) ? wanted : wanted === "" ? null : (this.run.default_model ?? null);
  }

  #listen() {
    const { queue } = this;
    this.pictures.start(() => this.bar.showFrames());
    queue.addEventListener("change", () => this.#queueChanged());
    queue.addEventListener("refused", ({ detail }) => announce(`Not made: ${detail.words}. ${detail.reason}`, "error", { news: true }));
    this.endConnection = api.onConnection((reachable) => {
      if (reachable) this.#again();
    });
    this.timers = [setInterval(() => this.#retry(), RETRY_MS), setInterval(() => this.#refresh(), LABELS_EVERY_MS)];
    this.remember = setInterval(() => this.#rememberPlace(), 1000);
  }

  /// What an earlier visit left: edits that wait, a reason that was being typed, an end that was being moved.
  #resume() {
    const { state } = this;
    if (this.queue.waiting.length && !this.queue.conflict)
      announce(`${counted(this.queue.waiting.length, "edit")} from before the reload: being saved.`, "note", { news: true });
    if (state.draft) announce("An end that was moved and not saved is back. Enter saves it, Escape discards it.");
    this.#queueChanged();
    this.queue.pump();
    const reason = keptPlace(`reason:${this.name}`).load();
    const flag = reason && state.labels.flags.find((f) => f.what === reason.flag && !f.confirmed);
    if (flag) this.actions.lift(flag);
  }

  #queueChanged() {
    if (!this.queue.conflict || this.asking) return;
    this.player.pause();
    this.asking = true;
    settle(this.queue)
      .catch((error) => this.#failed(error))
      .then((answered) => {
        this.asking = false;
        if (answered) this.#queueChanged(); // a new conflict may have come meanwhile
      });
  }

  decide() {
    if (this.queue.conflict) this.#queueChanged();
  }

  /// The server answers again: what was asked meanwhile has no answer.
  #again() {
    this.timeline.again();
    this.pictures.again();
    this.#retry();
  }

  #retry() {
    if (this.queue.lost) this.queue.pump();
  }

  async #refresh() {
    if (document.hidden || !this.queue.labels.version) return;
    const ask = () => api.getLabels(this.name, { signal: this.abort.signal }).catch(() => null);
    if (await this.queue.refresh(ask))
      announce("The labels were changed by another page or by tactile label. You see the new ones.", "note", { news: true });
  }

  /// Puts the cursor into the address, unless somebody goes to another place: that address must not be lost.
  #rememberPlace() {
    if (this.state.playing || location.hash !== this.address) return;
    const address = runAddress(this.name, this.state.at_us);
    if (this.address !== address) history.replaceState(null, "", address);
    this.address = location.hash;
  }

  #failed(error) {
    if (error instanceof Unreachable) return; // the banner shows it
    announce(error.message, "error", { news: true });
    if (!(error instanceof Refused)) console.error(error);
  }

  setSpeed(direction) {
    this.player.speed = otherSpeed(this.player.speed, direction);
    this.speed.save(this.player.speed);
    this.bar.showSpeed();
  }

  chooseModel(name) {
    this.model.save(name ?? "");
    const before = this.timeline;
    this.timeline = this.#timeline(this.state);
    before.stop();
    before.element.replaceWith(this.timeline.element);
    this.timeline.start();
    this.keys = runKeys({ actions: this.actions, player: this.player, timeline: this.timeline, page: this });
  }

  async goToNext(direction) {
    this.drag.commit();
    const { runs } = await api.getRuns().catch(() => ({ runs: null }));
    if (!runs) return;
    const next = nextToReview(runs, this.name, direction);
    if (next) location.hash = runAddress(next);
    else announce("Every other run is confirmed and without an open flag.");
  }

  key(event) {
    if (!this.keys) return;
    if (event.key === "Enter" && this.state.draft && event.target === document.body) this.drag.commit();
    else press(event, this.keys);
  }

  draftText() {
    const { draft, queue } = this.state;
    const was = queue.shown.intervals.find((interval) => interval.id === draft?.id)?.[`${draft?.end}_us`];
    return draft && was !== undefined ? draftWords(draft, was) : null;
  }

  markText() {
    const { mark, at_us } = this.state;
    return mark ? `${mark.touch} from ${secondsText(mark.start_us)} to the cursor, ${secondsText(at_us)}` : null;
  }

  stop() {
    this.abort.abort();
    this.endConnection?.();
    this.player?.pause();
    for (const timer of this.timers ?? []) clearInterval(timer);
    clearInterval(this.remember);
    this.timeline?.stop();
    this.pictures?.stop();
  }
}
