// The edits of one run on their way to the server, one after the other. None is lost: each is kept in `store` until the server has it, through
// a reload, a server that ended, and a conflict. No document here; `send` and `store` are given.

import { alreadyMade, withOperations, wordsOf } from "./label_edits.js";
import { historyMark, rebased, rebasedAll } from "./label_changes.js";

export class Conflict extends Error {
  constructor(message, current) {
    super(message);
    this.current = current;
  }
}

/// The server does not answer. What was sent may have been made or not.
export class Unreachable extends Error {}

/// The server cannot make this edit, and says why.
export class Refused extends Error {
  constructor(message, status = 0) {
    super(message);
    this.status = status; // of the answer
  }
}

/// Why an operation cannot be made on the present labels.
const whyNot = ({ op }) => (op === "edit" ? "what it edits is gone" : "the edits have changed since");

export class EditQueue extends EventTarget {
  /// @param send   async (operation, version) => labels; throws Conflict, Unreachable or Refused
  /// @param store  {load() => state or null, save(state)}
  constructor({ labels, send, store }) {
    super();
    this.send = send;
    this.store = store;
    this.labels = labels;
    this.waiting = []; // not at the server yet, the oldest first
    this.setAside = []; // not made, with the reason: a person can make them after all
    this.conflict = null; // {base, current}
    this.lost = false;
    this.busy = false;
    this.#takeUp(store.load());
  }

  /// What a reload or an earlier visit left.
  #takeUp(kept) {
    if (!kept) return;
    this.setAside = kept.setAside ?? [];
    this.waiting = (kept.waiting ?? []).filter((operation) => !(operation.tried && alreadyMade(operation, this.labels)));
    if (this.waiting.length && kept.base && kept.base.version !== this.labels.version)
      this.conflict = { base: kept.base, current: this.labels };
    if (this.waiting.length === 0) this.#save();
  }

  /// The labels as they will be: those of the server with all that waits.
  get shown() {
    return withOperations(this.labels, this.waiting);
  }

  get state() {
    if (this.conflict) return "conflict";
    if (this.lost) return "lost";
    return this.waiting.length ? "saving" : "saved";
  }

  /// Takes an operation and begins to send.
  add(operation) {
    this.waiting.push({ ...operation, tried: false });
    this.#changed();
    return this.pump();
  }

  /// Sends what waits until it is all there or something must be decided. One at a time.
  async pump() {
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.waiting.length && !this.conflict) {
        if (!(await this.#sendFirst())) break;
      }
    } finally {
      this.busy = false;
    }
  }

  async #sendFirst() {
    const [operation] = this.waiting;
    operation.of ??= historyMark(operation.op, this.labels); // it shows later whether it was made
    operation.tried = true;
    this.#save();
    try {
      const before = this.labels;
      this.labels = await this.send(operation, before.version);
      this.lost = false;
      this.waiting.shift();
      this.#nameAdded(operation, before);
    } catch (error) {
      if (error instanceof Conflict) return this.#conflicting(operation, error.current);
      if (error instanceof Unreachable) {
        this.lost = true;
        this.#changed();
        return false;
      }
      this.waiting.shift();
      this.setAside.push({ ...operation, reason: error.message });
      if (operation.op === "edit") this.#dropUndoOf();
      this.dispatchEvent(new CustomEvent("refused", { detail: { words: wordsOf(operation), reason: error.message } }));
    }
    this.#changed();
    return true;
  }

  /// A waiting undo of the edit that was just refused would undo another one.
  #dropUndoOf() {
    const { kept, dropped } = rebasedAll(this.waiting, this.labels, this.labels, [false]);
    this.waiting = kept;
    for (const undo of dropped) this.setAside.push({ ...undo, reason: whyNot(undo) });
  }

  #conflicting(operation, current) {
    this.lost = false;
    if (alreadyMade(operation, current)) {
      this.labels = current;
      this.waiting.shift();
      this.#changed();
      return true;
    }
    this.conflict = { base: this.labels, current };
    this.#changed();
    return false;
  }

  /// Later edits of an interval that was just added name it as the server does.
  #nameAdded({ edit }, before) {
    if (edit?.kind !== "add") return;
    const known = new Set(before.intervals.map((interval) => interval.id));
    const made = this.labels.intervals.find((interval) => !known.has(interval.id) && interval.touch === edit.touch);
    if (!made) return;
    for (const later of this.waiting) if (later.edit?.id === edit.local_id) later.edit.id = made.id;
    this.dispatchEvent(new CustomEvent("named", { detail: { from: edit.local_id, to: made.id } }));
  }

  /// The person's answer to a conflict: `mine` makes the waiting edits on the current labels; else they are set aside.
  resolve(mine) {
    const { base, current } = this.conflict;
    this.conflict = null;
    this.labels = current;
    const { kept, dropped } = mine ? rebasedAll(this.waiting, base, current) : { kept: [], dropped: this.waiting };
    this.waiting = kept.map((operation) => ({ ...operation, of: null, tried: false }));
    for (const operation of dropped) this.setAside.push({ ...operation, reason: mine ? whyNot(operation) : "you took the other labels" });
    this.#changed();
    return this.pump();
  }

  /// Makes an edit that was set aside after all, or forgets it.
  makeAfterAll(index) {
    const [operation] = this.setAside.splice(index, 1);
    const again = rebased(operation, this.shown);
    if (again) return this.add({ op: again.op, edit: again.edit, why: again.why });
    this.setAside.splice(index, 0, operation);
    this.dispatchEvent(new CustomEvent("refused", { detail: { words: wordsOf(operation), reason: whyNot(operation) } }));
    return Promise.resolve();
  }

  forget(index) {
    this.setAside.splice(index, 1);
    this.#changed();
  }

  /// Asks for the labels when nothing waits, and shows them if they are new: another page or `tactile label` changed them. An answer
  /// that an edit has overtaken, saved while it was on its way, is not shown: it would look like a change by somebody else.
  /// @param ask  gives the server's labels, or null if there is no answer
  async refresh(ask) {
    if (this.waiting.length || this.conflict) return false;
    const before = this.labels.version;
    const labels = await ask();
    if (!labels) return false;
    this.lost = false;
    if (this.waiting.length || this.conflict || this.labels.version !== before || labels.version === before) return false;
    this.labels = labels;
    this.#changed();
    return true;
  }

  #save() {
    if (this.waiting.length === 0 && this.setAside.length === 0) return this.store.save(null);
    const { history, ...base } = this.conflict?.base ?? this.labels;
    return this.store.save({ base: { ...base, history: (history ?? []).slice(-50) }, waiting: this.waiting, setAside: this.setAside });
  }

  #changed() {
    this.#save();
    this.dispatchEvent(new Event("change"));
  }
}
