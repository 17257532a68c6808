// What an edit does to labels. The page shows it at once, and the server makes the same edit on its own. No document here.
//
// An operation is {op: "edit", edit, why} or {op: "undo"} or {op: "redo"}. Labels are as GET …/labels gives them.

import { secondsText } from "./format.js";

const copied = (labels) => structuredClone(labels);

function find(labels, id) {
  return labels.intervals.find((interval) => interval.id === id) ?? null;
}

function madeByPerson(labels, interval) {
  interval.confirmed = true;
  interval.source = "person";
  for (const flag of labels.flags) if (flag.interval_id === interval.id) flag.confirmed = true;
}

function inOrder(labels) {
  labels.intervals.sort((a, b) => a.start_us - b.start_us);
  return labels;
}

/// The interval before `start_us`, which a start placed inside it ends; null if there is none.
function cutBy(labels, start_us, id) {
  return labels.intervals.find((other) => other.id !== id && other.start_us < start_us && other.end_us > start_us) ?? null;
}

const MAKE = {
  move(labels, edit) {
    const interval = find(labels, edit.id);
    if (!interval) return;
    const within = edit.within_us ?? 1000;
    if (edit.end === "start" && edit.end_earlier) {
      const earlier = cutBy(labels, edit.to_us, edit.id);
      if (earlier) Object.assign(earlier, { end_us: edit.to_us, end_low_us: edit.to_us - within, end_high_us: edit.to_us + within });
    }
    interval[`${edit.end}_us`] = edit.to_us;
    interval[`${edit.end}_low_us`] = edit.to_us - within;
    interval[`${edit.end}_high_us`] = edit.to_us + within;
    madeByPerson(labels, interval);
  },
  add(labels, edit) {
    const within = edit.within_us ?? 1000;
    if (edit.end_earlier) {
      const earlier = cutBy(labels, edit.start_us, null);
      if (earlier) earlier.end_us = edit.start_us;
    }
    labels.intervals.push({
      id: edit.local_id ?? `new ${edit.touch}`,
      touch: edit.touch,
      source: "person",
      confirmed: true,
      start_us: edit.start_us,
      start_low_us: edit.start_us - within,
      start_high_us: edit.start_us + within,
      end_us: edit.end_us,
      end_low_us: edit.end_us - within,
      end_high_us: edit.end_us + within,
    });
  },
  reject(labels, edit) {
    const gone = find(labels, edit.id);
    if (!gone) return;
    labels.intervals = labels.intervals.filter((interval) => interval !== gone);
    labels.flags = labels.flags.filter((flag) => flag.interval_id !== gone.id);
    labels.rejected.push({ touch: gone.touch, start_us: gone.start_us, end_us: gone.end_us });
  },
  class(labels, edit) {
    const interval = find(labels, edit.id);
    if (!interval) return;
    interval.touch = edit.touch;
    madeByPerson(labels, interval);
  },
  confirm(labels, edit) {
    const interval = find(labels, edit.id);
    if (!interval) return;
    interval.confirmed = true;
    for (const flag of labels.flags) if (flag.interval_id === edit.id) flag.confirmed = true;
  },
  "confirm-run"(labels) {
    for (const part of [...labels.intervals, ...labels.flags]) part.confirmed = true;
  },
  lift(labels, edit, why) {
    const flag = labels.flags.find((f) => f.index === edit.flag);
    if (flag) Object.assign(flag, { confirmed: true, lifted_why: why });
  },
};

const LEAST_LENGTH_US = 1;

/// Where an end may lie: {low, high, cuts}. A start may move into the interval before it, which then ends there.
export function limitsOf(intervals, id, end, length_us) {
  const here = intervals.findIndex((interval) => interval.id === id);
  const interval = intervals[here];
  const [before, after] = [intervals[here - 1], intervals[here + 1]];
  if (end === "end") return { low: interval.start_us + LEAST_LENGTH_US, high: after ? after.start_us : length_us };
  return { low: before ? before.start_us + LEAST_LENGTH_US : 0, high: interval.end_us - LEAST_LENGTH_US };
}

/// Labels after one edit; the given ones stay as they are.
export function edited(labels, edit, why = "") {
  const after = copied(labels);
  MAKE[edit.kind](after, edit, why);
  return inOrder(after);
}

/// Labels after all operations that the server does not have yet. An undo takes back the operation before it; one that would reach back into
/// what the server has shows when the server answers.
export function withOperations(labels, operations) {
  const standing = [];
  const undone = [];
  for (const operation of operations) {
    if (operation.op === "undo") {
      if (standing.length) undone.push(standing.pop());
    } else if (operation.op === "redo") {
      if (undone.length) standing.push(undone.pop());
    } else {
      undone.length = 0;
      standing.push(operation);
    }
  }
  return standing.reduce((now, { edit, why }) => edited(now, edit, why), labels);
}

/// The operation in words: "start of press-1 to 1.234500 s".
export function wordsOf({ op, edit }) {
  if (op !== "edit") return op === "undo" ? "undo the last edit" : "make the undone edit again";
  switch (edit.kind) {
    case "move":
      return `${edit.end} of ${edit.id} to ${secondsText(edit.to_us)}`;
    case "add":
      return `add a ${edit.touch} from ${secondsText(edit.start_us)} to ${secondsText(edit.end_us)}`;
    case "reject":
      return `remove ${edit.id}`;
    case "class":
      return `make ${edit.id} a ${edit.touch}`;
    case "confirm":
      return `confirm ${edit.id}`;
    case "confirm-run":
      return "confirm the run";
    default:
      return `lift the flag "${edit.flag_what ?? edit.flag}"`;
  }
}

function historyHas(history, mark, undone) {
  return mark !== null && (history ?? []).some((entry) => entry.when === mark.when && entry.what === mark.what && entry.undone === undone);
}

/// These labels have the operation already: an answer was lost, not the edit.
export function alreadyMade(operation, labels) {
  if (operation.op === "undo") return historyHas(labels.history, operation.of ?? null, true);
  if (operation.op === "redo") return historyHas(labels.history, operation.of ?? null, false);
  const { edit } = operation;
  const interval = edit.id ? find(labels, edit.id) : null;
  switch (edit.kind) {
    case "move":
      return interval !== null && interval[`${edit.end}_us`] === edit.to_us && interval.source === "person";
    case "add":
      return labels.intervals.some((i) => i.touch === edit.touch && i.start_us === edit.start_us && i.end_us === edit.end_us);
    case "reject":
      return interval === null;
    case "class":
      return interval !== null && interval.touch === edit.touch;
    case "confirm":
      return interval !== null && interval.confirmed;
    case "confirm-run":
      return labels.intervals.every((i) => i.confirmed) && labels.flags.every((f) => f.confirmed);
    default:
      return labels.flags.some((f) => f.what === edit.flag_what && f.confirmed);
  }
}
