// Confirms many runs, or lifts the flags of one kind in all of them, in one step: as `tactile label --confirm 'fan/*'`.

import { ask, el } from "./dom.js";
import { counted } from "./format.js";

const openFlags = (run) => (run.flags ?? []).filter((flag) => !flag.confirmed);
const sameCount = (runs) => counted(runs.length, "run");

/// The runs that can be confirmed and are not.
export function confirmable(runs) {
  return runs.filter((run) => !run.error && run.has?.labels && !run.confirmed);
}

/// The kinds of open flags, the most frequent first: {kind, what, runs}, with the words of the first.
export function flagKinds(runs) {
  const kinds = new Map();
  for (const run of runs) {
    for (const { kind, what } of openFlags(run)) {
      if (!kinds.has(kind)) kinds.set(kind, { kind, what, runs: [] });
      const { runs: having } = kinds.get(kind);
      if (having.at(-1) !== run.name) having.push(run.name);
    }
  }
  return [...kinds.values()].sort((a, b) => b.runs.length - a.runs.length);
}

/// The edits of one run with these labels: of the flags of one kind, or with "" of the whole run.
export function editsFor(labels, kind) {
  if (kind === "") return [{ kind: "confirm-run" }];
  return openFlags(labels).filter((flag) => flag.kind === kind).map((flag) => ({ kind: "lift", flag: flag.index }));
}

/// Makes the edits run by run. Returns {done, problems}: the names of edited runs, and sentences.
/// @param server  {getLabels(name), sendOperation(name, operation, version)}
export async function confirmMany(names, kind, why, server) {
  const done = [];
  const problems = [];
  for (const name of names) {
    try {
      let labels = await server.getLabels(name);
      for (const edit of editsFor(labels, kind)) labels = await server.sendOperation(name, { op: "edit", edit, why }, labels.version);
      done.push(name);
    } catch (error) {
      problems.push(`${name}: ${error.message}`);
    }
  }
  return { done, problems };
}

/// Asks what to confirm in these runs. Returns {names, kind, why}, or null.
export async function askWhatToConfirm(runs) {
  const kinds = flagKinds(runs);
  const choice = el("select", { id: "confirm-what", onchange: () => reason.toggleAttribute("required", choice.value !== "") },
    el("option", { value: "" }, `all intervals and flags of ${sameCount(runs)}`),
    kinds.map(({ kind, what, runs: having }) => el("option", { value: kind }, `only the flag in ${sameCount(having)}: ${what}`)));
  const reason = el("input", { type: "text", id: "confirm-why", maxlength: 500, autofocus: true });
  const content = el("div", { class: "confirm-many" },
    el("p", {}, "To confirm means: you looked at each of them, and it is right."),
    el("p", {}, el("label", { for: "confirm-what" }, "Confirm "), choice),
    el("p", {}, el("label", { for: "confirm-why" }, "Reason, for the history (flags need one) "), reason),
    el("details", {}, el("summary", {}, sameCount(runs)), el("p", {}, runs.map((run) => run.name).join(", "))));
  const answer = await ask("Confirm the runs that are shown", content, [
    { words: "Confirm", value: "confirm", kind: "primary" },
    { words: "Cancel", value: null },
  ]);
  if (answer === null) return null;
  const kind = choice.value;
  const names = kind === "" ? runs.map((run) => run.name) : kinds.find((one) => one.kind === kind).runs;
  return { names, kind, why: reason.value.trim() };
}
