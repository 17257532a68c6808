// What differs between two states of a run's labels, for a person who must choose. No document here.

import { secondsText, lengthText } from "./format.js";

const NAMES = { press: "press", slip: "slip" };

function endsThatMoved(before, after) {
  const moved = [];
  for (const end of ["start", "end"]) {
    const [from, to] = [before[`${end}_us`], after[`${end}_us`]];
    if (from !== to) moved.push(`${end} of ${before.id} moved from ${secondsText(from)} to ${secondsText(to)} (${lengthText(to - from)})`);
  }
  return moved;
}

/// Each difference as {id, words}; `id` is the interval's, or null for flags of the run.
export function changesBetween(before, after) {
  const changes = [];
  const later = new Map(after.intervals.map((interval) => [interval.id, interval]));
  for (const interval of before.intervals) {
    const now = later.get(interval.id);
    later.delete(interval.id);
    const say = (words) => changes.push({ id: interval.id, words });
    if (!now) {
      say(`${interval.id} was removed`);
      continue;
    }
    for (const words of endsThatMoved(interval, now)) say(words);
    if (now.touch !== interval.touch) say(`${interval.id} became a ${NAMES[now.touch] ?? now.touch}`);
    if (now.confirmed !== interval.confirmed) say(`${interval.id} was ${now.confirmed ? "confirmed" : "set back to unconfirmed"}`);
  }
  for (const added of later.values()) {
    changes.push({ id: added.id, words: `${added.id} was added, ${secondsText(added.start_us)} to ${secondsText(added.end_us)}` });
  }
  return [...changes, ...flagChanges(before, after)];
}

function flagChanges(before, after) {
  const changes = [];
  const same = (a) => (b) => a.what === b.what && (a.interval_id ?? null) === (b.interval_id ?? null);
  for (const flag of before.flags) {
    const now = after.flags.find(same(flag));
    const say = (words) => changes.push({ id: flag.interval_id ?? null, words });
    if (!now) say(`the flag "${flag.what}" is gone`);
    else if (now.confirmed !== flag.confirmed) say(`the flag "${flag.what}" was ${now.confirmed ? "lifted" : "raised again"}`);
  }
  for (const flag of after.flags) {
    if (!before.flags.some(same(flag))) changes.push({ id: flag.interval_id ?? null, words: `a flag was raised: "${flag.what}"` });
  }
  return changes;
}

/// The edits of the history of `after` that `before` does not have, by people: [{who, what, when}].
export function newEdits(before, after) {
  const known = new Set((before.history ?? []).map((entry) => `${entry.when} ${entry.what} ${entry.undone}`));
  return (after.history ?? []).filter((entry) => !known.has(`${entry.when} ${entry.what} ${entry.undone}`));
}

/// The operation changes something that `changes` changed, too.
export function meets(operation, changes) {
  if (operation.op !== "edit" || operation.edit.kind === "confirm-run") return changes.length > 0;
  const id = operation.edit.id ?? operation.edit.flag_interval ?? null;
  return id !== null && changes.some((change) => change.id === id);
}

/// The entry of the history that an undo or redo would act on now: {when, what}; null for an edit, and if there is none.
export function historyMark(op, { history = [] }) {
  if (op === "edit") return null;
  const entry = op === "undo" ? history.findLast((e) => !e.undone) : history.find((e) => e.undone);
  return entry ? { when: entry.when, what: entry.what } : null;
}

const sameEntry = (a, b) => (a?.when ?? null) === (b?.when ?? null) && (a?.what ?? null) === (b?.what ?? null);

/// The operation as it must be sent after the labels became `current`: a flag keeps its words, not its number. null if what it edits is gone,
/// and if an undo or redo would act on another edit than the one that was meant.
export function rebased(operation, current) {
  if (operation.op !== "edit") {
    return operation.of && sameEntry(operation.of, historyMark(operation.op, current)) ? operation : null;
  }
  const { edit } = operation;
  if (edit.kind === "lift") {
    const flag = current.flags.find((f) => f.what === edit.flag_what && (f.interval_id ?? null) === (edit.flag_interval ?? null));
    return flag ? { ...operation, edit: { ...edit, flag: flag.index } } : null;
  }
  if (edit.id && !edit.id.startsWith("new ") && !current.intervals.some((interval) => interval.id === edit.id)) return null;
  return operation;
}

/// The waiting operations as they must be sent after the labels `base` became `current`, and those that cannot be made: {kept, dropped}.
///
/// An undo or redo that was never sent means what was newest when it was asked for: a waiting edit before it, else the history of `base`.
/// @param before  of waiting edits that are gone already: whether each is kept
export function rebasedAll(waiting, base, current, before = []) {
  const same = ["undo", "redo"].every((op) => sameEntry(historyMark(op, base), historyMark(op, current)));
  const edits = [...before]; // that an undo here would take back: whether each is kept
  const undone = [];
  const kept = [];
  const dropped = [];
  const place = (operation, again) => (again ? kept.push(again) : dropped.push(operation));
  for (const operation of waiting) {
    if (operation.op === "edit") {
      const again = rebased(operation, current);
      edits.push(again !== null);
      place(operation, again);
    } else if (operation.of) {
      place(operation, rebased(operation, current));
    } else {
      const [from, to] = operation.op === "undo" ? [edits, undone] : [undone, edits];
      const isKept = from.length ? from.pop() : same;
      to.push(isKept);
      place(operation, isKept ? operation : null);
    }
  }
  return { kept, dropped };
}
