// Someone else changed the labels meanwhile: shows both sides, and lets the person choose.

import { ask, el } from "./dom.js";
import { whenText } from "./format.js";
import { changesBetween, meets, newEdits } from "./label_changes.js";
import { wordsOf } from "./label_edits.js";

const list = (words, empty) =>
  words.length
    ? el(
        "ul",
        {},
        words.map((w) => el("li", {}, w)),
      )
    : el("p", { class: "empty" }, empty);

/// Resolves the conflict of the queue as the person wants. Nothing is lost: edits that are not made stay in the list of edits not made.
/// Returns whether the person has decided.
export async function settle(queue) {
  const { base, current } = queue.conflict;
  const changes = changesBetween(base, current);
  const edits = newEdits(base, current);
  const both = queue.waiting.some((operation) => meets(operation, changes));
  const mine = queue.waiting.map(
    (operation) => wordsOf(operation) + (meets(operation, changes) && operation.op === "edit" ? " (changed by both)" : ""),
  );
  const content = el(
    "div",
    { class: "conflict" },
    el(
      "p",
      {},
      "Another page or ",
      el("code", {}, "tactile label"),
      " saved these labels after this page read them. Your edits are not saved yet.",
    ),
    el("h3", {}, "What changed meanwhile"),
    list(
      changes.map((change) => change.words),
      "Nothing in intervals or flags.",
    ),
    edits.length
      ? el(
          "p",
          { class: "by" },
          `By ${edits
            .map((e) => `${e.who}, ${whenText(e.when)}: ${e.what}`)
            .slice(-3)
            .join("; ")}.`,
        )
      : null,
    el("h3", {}, "Your edits"),
    list(mine, "None."),
    el("p", {}, both ? "Yours, on top, replaces the other change where both changed the same." : "The two do not touch the same interval."),
  );
  const answer = await ask("The labels changed meanwhile", content, [
    { words: "Keep mine, on top of theirs", value: "mine", kind: "primary" },
    { words: "Take theirs, set mine aside", value: "theirs" },
    { words: "Decide later", value: null },
  ]);
  if (answer === null || !queue.conflict) return false;
  await queue.resolve(answer === "mine");
  return true;
}
