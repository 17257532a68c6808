// What the live page says of a message of the server, in words. No document here.

import { countText, counted, lengthText, shortNumber } from "./format.js";

const MINUTE_S = 60;
const SILENT_S = 2;

/// The steps of the last minute, in the order of time. A message has those that came since the last one.
export class Steps {
  constructor() {
    this.rows = [];
  }

  add(steps) {
    if (steps.length && this.rows.length && steps[0][0] <= this.rows[this.rows.length - 1][0]) this.rows = []; // the program began again
    this.rows.push(...steps);
    const newest = this.rows.length ? this.rows[this.rows.length - 1][0] : 0;
    const from = this.rows.findIndex(([t]) => t > newest - MINUTE_S);
    if (from > 0) this.rows.splice(0, from);
  }

  /// [[seconds before now, value, …], …] of some columns, by their names.
  of(names, columns) {
    const places = names.map((name) => columns.indexOf(name) + 1);
    const newest = this.rows.length ? this.rows[this.rows.length - 1][0] : 0;
    return this.rows.map((row) => [row[0] - newest, ...places.map((place) => row[place])]);
  }
}

function bytesText(bytes) {
  if (bytes === null || bytes === undefined) return "–";
  const units = ["bytes", "kB", "MB", "GB", "TB"];
  let power = 0;
  let size = bytes;
  while (size >= 1000 && power + 1 < units.length) {
    size /= 1000;
    ++power;
  }
  return `${power === 0 ? size : shortNumber(size)} ${units[power]}`;
}

const clockText = (seconds) => `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;

function durationText(minutes) {
  if (minutes >= 48 * 60) return `${Math.round(minutes / 60 / 24)} days`;
  if (minutes >= 120) return `${Math.round(minutes / 60)} h`;
  return `${Math.round(minutes)} min`;
}

/// {words, mark}: what the program does now. `mark` names a colour: press, slip, none, bad or nothing.
export function headline({ state }) {
  if (!state) return { words: "The program begins.", mark: "" };
  if (state.state === "ended") return { words: endedWords(state), mark: "" };
  if (state.kind === "detect") {
    if (!state.tick) return { words: "Waiting for the first verdict.", mark: "" };
    const { verdict, predicted, p } = state.tick;
    return { words: verdict, detail: `${predicted} ${p[["none", "press", "slip"].indexOf(predicted)].toFixed(2)}`, mark: verdict };
  }
  if (state.state === "waiting") return { words: "Waiting", detail: state.words ?? "", mark: "" };
  return { words: `Recording ${state.run}`, detail: clockText(state.recording?.elapsed_s ?? 0), mark: "bad" };
}

function endedWords(state) {
  if (state.kind === "detect") return `Detection has ended: ${state.words}.`;
  const runs = state.runs ?? [];
  const last = runs[runs.length - 1];
  const kept = last ? `${counted(runs.length, "run")}; the last is ${last.object}/${last.run}` : "no run";
  return `Recording has ended, with ${kept}${state.words ? `. Error: ${state.words}` : ""}.`;
}

function lossesText({ by_reason }) {
  const words = { queue_full: "disk too slow", back_in_time: "back in time", outside: "outside the sensor", unwritten: "not written", source: "lost by the source" };
  const lost = Object.entries(by_reason ?? {}).filter(([, n]) => n.packets + n.events + n.others > 0);
  if (lost.length === 0) return "nothing";
  const elements = (n) => `${countText(n)} ${n === 1 ? "element" : "elements"}`;
  return lost.map(([why, n]) => `${elements(n.events + n.others)}, ${counted(n.packets, "packet")} (${words[why] ?? why})`).join("; ");
}

/// How much a device's clock differs from the host's, and how far it has drifted since the run began: "20 ms behind the host's; 0.12 ms slow in 40 s (3 ppm)".
function clockWords({ offset_us, change_ms, seconds }) {
  const LONG_ENOUGH_S = 10;
  const ppm = (1000 * Math.abs(change_ms)) / seconds;
  const moved =
    seconds < LONG_ENOUGH_S
      ? `drift known in ${Math.ceil(LONG_ENOUGH_S - seconds)} s`
      : `${Math.abs(change_ms).toFixed(2)} ms ${change_ms < 0 ? "fast" : "slow"} in ${seconds.toFixed(0)} s (${ppm.toFixed(0)} ppm)`;
  return `${offsetWords(offset_us)}; ${moved}`;
}

/// Clocks that count from another moment, such as the controller's start, differ by days or years.
function offsetWords(offset_us) {
  const HOUR_US = 3600e6;
  if (Math.abs(offset_us) > HOUR_US) return "counts from another moment than the host's";
  return `${lengthText(Math.abs(offset_us))} ${offset_us < 0 ? "ahead of" : "behind"} the host's`;
}

function diskFacts({ disk }) {
  if (!disk) return [];
  const { free_bytes, minutes } = disk;
  const left = minutes === null ? "" : `, for ${durationText(minutes)}`;
  return [["Free disk", bytesText(free_bytes) + left, minutes !== null && minutes < 10]];
}

function recordFacts(state) {
  const run = state.recording;
  const facts = [];
  if (run) {
    const lost = lossesText(run.dropped);
    facts.push(["Events", countText(run.events)], ["IMU, triggers, frames", countText(run.others)], ["Dropped", lost, lost !== "nothing"]);
    if (run.clock) facts.push(["Camera clock", clockWords(run.clock)], ["Packet lateness", `up to ${lengthText(Math.round(1000 * run.clock.lateness_ms))}`]);
    facts.push(["File", bytesText(run.bytes)], ["Waits for the disk", bytesText(run.queue_bytes)]);
  }
  facts.push(...diskFacts(state));
  for (const source of state.sources ?? []) {
    const words = { sends: `sends ${shortNumber(source.packets_per_s)} packets/s`, silent: "is silent", ended: "has ended", lost: `is lost: ${source.error}` };
    facts.push([source.name, words[source.state] ?? source.state, source.state === "silent" || source.state === "lost"]);
  }
  if (state.robot) {
    const { connected, rate_hz, gaps, missing, clock } = state.robot;
    const missed = missing > 0 ? `, ${missing} packages missing in ${counted(gaps, "gap")}` : "";
    facts.push(["Robot", (connected ? `connected, ${rate_hz.toFixed(0)} Hz` : "not connected") + missed, !connected || missing > 0]);
    if (clock) facts.push(["Robot clock", clockWords(clock)]);
  }
  if (state.video) {
    const { running, frames_per_s, dropped, clock } = state.video;
    const lost = dropped > 0 ? `, ${counted(dropped, "frame")} dropped` : "";
    facts.push(["Video", (running ? `${frames_per_s.toFixed(1)} frames/s` : "has ended") + lost, !running || dropped > 0]);
    if (clock) facts.push(["Film clock", clockWords(clock)]);
  }
  return facts;
}

function detectFacts(state) {
  const { ticks, tick, lateness } = state;
  const facts = [
    ["Model", state.model],
    ["Source", state.source],
  ];
  if (tick) {
    facts.push(["Probabilities", ["none", "press", "slip"].map((name, i) => `${name} ${tick.p[i].toFixed(2)}`).join(", ")]);
    facts.push(["Events in t_h", countText(tick.events)]);
  }
  facts.push(["Verdicts", countText(ticks.reported)]);
  facts.push(["Missed ticks", `${countText(ticks.skipped)} skipped, ${countText(ticks.late)} late`, ticks.skipped + ticks.late > 0]);
  if (ticks.incomplete > 0) facts.push(["Incomplete histories", countText(ticks.incomplete), true]);
  const { late = 0, dropped = 0 } = state.events ?? {};
  if (late + dropped > 0) facts.push(["Events lost", `${countText(late)} too late, ${countText(dropped)} dropped`, true]);
  const us = (ms) => lengthText(Math.round(1000 * ms));
  facts.push([
    "Lateness",
    lateness ? `${us(lateness.p50_ms)} (median), ${us(lateness.p99_ms)} (99 %), ${us(lateness.max_ms)} (highest of a second)` : "none: a replay has no deadline",
  ]);
  return facts.concat(diskFacts(state));
}

/// [[term, text, is bad], …]
export function factsOf({ state, live }) {
  const facts = [["Event rate", `${countText(live.rate_per_s)} events/s`]];
  if (live.scene) {
    facts.push(["Background", `${countText(live.scene.background_hz)} events/s, ${counted(live.scene.hot_pixels, "hot pixel")}`]);
    if (live.scene.readout_us) facts.push(["Read-out", `every ${shortNumber(live.scene.readout_us)} µs`]);
  }
  if (!state) return facts;
  return facts.concat(state.kind === "detect" ? detectFacts(state) : recordFacts(state));
}

/// What one would regret later, as sentences.
export function warningsOf({ state, live, ended }) {
  if (ended) return [];
  const silent =
    live.silent_s > SILENT_S ? [`no event for ${live.silent_s.toFixed(0)} s: a still scene, a covered lens, or a camera that has stopped`] : [];
  return [...(state?.warnings ?? []), ...silent, ...live.warnings];
}

/// What the page says when its server is gone; empty while it answers.
export function lostWords(seconds, hadMessage) {
  const last = hadMessage ? ` What you see is ${seconds.toFixed(0)} s old.` : "";
  return `The program does not answer: it has ended, or was stopped.${last} The page tries again.`;
}
