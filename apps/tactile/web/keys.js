// The keys of the pages: one table per page, which the handler and the help read.

import { ask, dialogIsOpen, el } from "./dom.js";
import { keptChoice } from "./kept.js";
import { zoomedAround } from "./time_view.js";

/// [keys, what they do, action]. A key is `event.key`, with "Ctrl+" or "Shift+" before it where that matters.
export function runKeys({ actions, player, timeline, page }) {
  return {
    See: [
      [["Space"], "play and pause", () => player.toggle()],
      [["<"], "play slower", () => page.setSpeed(-1)],
      [[">"], "play quicker", () => page.setSpeed(1)],
      [["ArrowLeft"], "one tick back", () => actions.stepTick(-1)],
      [["ArrowRight"], "one tick forward", () => actions.stepTick(1)],
      [["Shift+ArrowLeft"], "one event back", () => actions.stepEvent(-1)],
      [["Shift+ArrowRight"], "one event forward", () => actions.stepEvent(1)],
      [[","], "one film frame back", () => actions.stepFrame(-1)],
      [["."], "one film frame forward", () => actions.stepFrame(1)],
      [["ArrowUp", "+"], "zoom in", () => timeline.zoom(0.5)],
      [["ArrowDown", "-"], "zoom out", () => timeline.zoom(2)],
      [["0"], "the whole run", () => timeline.zoom(Infinity)],
      [["n"], "the next start or end, closely", () => actions.goToEnd(1)],
      [["Shift+N"], "the one before", () => actions.goToEnd(-1)],
    ],
    Correct: [
      [["i", "["], "put the selected interval's start at the cursor", () => actions.setEnd("start")],
      [["o", "]"], "put its end at the cursor", () => actions.setEnd("end")],
      [["p"], "begin a press here; again: end it here", () => actions.mark("press")],
      [["s"], "begin a slip here; again: end it here", () => actions.mark("slip")],
      [["t"], "change the selected interval's class", () => actions.changeClass()],
      [["Delete", "x"], "remove the selected interval", () => actions.remove()],
      [["c"], "confirm the selected interval", () => actions.confirm()],
      [["Shift+C"], "confirm the run", () => actions.confirmRun()],
      [["l"], "lift a flag, with a reason", () => actions.liftFirst()],
      [["u", "Ctrl+z"], "undo", () => actions.undo()],
      [["r", "Ctrl+y", "Ctrl+Shift+Z"], "make the undone edit again", () => actions.redo()],
      [["Escape"], "discard what is begun and not saved", () => actions.escape()],
    ],
    Go: [
      [["f"], "the next run that is flagged or not confirmed", () => page.goToNext(1)],
      [["Shift+F"], "the one before", () => page.goToNext(-1)],
      [
        ["g"],
        "all runs",
        () => {
          location.hash = "#/";
        },
      ],
      [["?"], "this help", () => showRunHelp(page.keys)],
    ],
  };
}

/// The keys of the page that cuts a recording. Its lines are an axis, as `AxisGestures` takes it.
export function splitKeys({ lines, page }) {
  const zoom = (factor) => lines.show(zoomedAround(lines.view, null, factor, lines.length_us));
  return {
    See: [
      [["+"], "zoom in", () => zoom(0.5)],
      [["-"], "zoom out", () => zoom(2)],
      [["0"], "the whole recording", () => zoom(Infinity)],
      [["?"], "this help", () => showSplitHelp(page.keys)],
    ],
  };
}

/// Keys of a handle that has the focus; end_drag.js acts on them.
const HANDLE_KEYS = [
  [["ArrowLeft", "ArrowRight"], "move it by a tick"],
  [["Shift+ArrowLeft", "Shift+ArrowRight"], "move it by an event (0.1 s or less on the axis)"],
  [["Alt+ArrowLeft", "Alt+ArrowRight"], "move it by 0.1 ms"],
  [["Enter"], "save where it is"],
  [["Escape"], "put it back"],
];

/// Keys of a cut that has the focus; cut_lines.js acts on them.
const CUT_KEYS = [
  [["ArrowLeft", "ArrowRight"], "move it by 10 ms, or a hundredth of the axis if that is less"],
  [["Shift+ArrowLeft", "Shift+ArrowRight"], "move it ten times as far"],
  [["Delete"], "remove it"],
];

const LIST_KEYS = [
  [["/"], "search"],
  [["j", "k"], "the next run, the one before"],
  [["Enter"], "open it"],
  [["f"], "the first run that is flagged or not confirmed"],
  [["?"], "this help"],
];

const AXIS_MOUSE = [
  ["Wheel, pinch", "zoom"],
  ["Drag, Shift + wheel", "move the axis"],
];
const RUN_MOUSE = [
  ["Drag a start or end", "move it; Alt: without snapping"],
  ["Click", "put the cursor there"],
  ...AXIS_MOUSE,
  ["Shift + drag, double click", "zoom to it"],
];
const SPLIT_MOUSE = [["Drag a cut", "move it"], ["Double click", "add a cut"], ...AXIS_MOUSE, ["Shift + drag", "zoom to it"]];

const NAMES = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", Escape: "Esc" };

function keyName(key) {
  const parts = key.split(/\+(?=.)/).map((part) => NAMES[part] ?? (part.length === 1 ? part.toUpperCase() : part));
  return el("kbd", {}, parts.join(" "));
}

export function nameOf(event) {
  const key = event.key === " " ? "Space" : event.key;
  const shift = event.shiftKey && (key.length > 1 || /[a-z]/i.test(key)) ? "Shift+" : "";
  return (event.ctrlKey || event.metaKey ? "Ctrl+" : "") + shift + (shift && key.length === 1 ? key.toUpperCase() : key);
}

const single = keptChoice("single-keys", true);

/// Runs the action of a key press. Returns true if there was one.
export function press(event, keys) {
  if (event.defaultPrevented || event.altKey || dialogIsOpen()) return false;
  const target = event.target;
  if (target.matches?.("input, textarea, select, [contenteditable]")) return false;
  if ((event.key === " " || event.key === "Enter") && target.closest?.("button, a, summary")) return false;
  const name = nameOf(event);
  if (!single.load() && !name.includes("Ctrl+") && name.replace("Shift+", "").length === 1 && name !== "?") return false;
  for (const [wanted, , action] of Object.values(keys).flat()) {
    if (!wanted.some((key) => key === name || (key.length === 1 && !/[a-z]/i.test(key) && key === event.key))) continue;
    event.preventDefault();
    action();
    return true;
  }
  return false;
}

const row = ([what, words]) => el("tr", {}, el("th", { scope: "row" }, Array.isArray(what) ? what.map(keyName) : what), el("td", {}, words));
const table = ([title, rows]) => el("table", { class: "keys" }, el("caption", {}, title), el("tbody", {}, rows.map(row)));

/// @param tables  [[title, rows], …]; a row is [["+", "ArrowUp"], "zoom in"], or ["Wheel, pinch", "zoom"]
async function showHelp(tables) {
  const box = el("input", { type: "checkbox", id: "single", checked: single.load(), onchange: () => single.save(box.checked) });
  const content = el(
    "div",
    { class: "help" },
    tables.map(table),
    el("p", {}, box, el("label", { for: "single" }, " Letters and signs are keys. Switch this off if you dictate.")),
  );
  await ask("Keys", content, [{ words: "Close", value: null, kind: "primary" }]);
}

export const showRunHelp = (keys) =>
  showHelp([...Object.entries(keys), ["A start or end that has the focus (Tab goes there)", HANDLE_KEYS], ["Mouse and fingers", RUN_MOUSE]]);
export const showSplitHelp = (keys) =>
  showHelp([...Object.entries(keys), ["A cut that has the focus (Tab goes there)", CUT_KEYS], ["Mouse and fingers", SPLIT_MOUSE]]);
export const showListHelp = () => showHelp([["List of runs", LIST_KEYS]]);
