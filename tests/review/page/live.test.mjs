import assert from "node:assert/strict";
import { test } from "node:test";
import { Steps, factsOf, headline, lostWords, warningsOf } from "../../../apps/tactile/web/live_words.js";

const LIVE = { rate_per_s: 213_000, silent_s: 0, picture: 3, picture_us: 40_000, scene: null, warnings: [] };

const nothingLost = () => ({ by_reason: { queue_full: { events: 0, others: 0, packets: 0 } } });

function recording(more = {}) {
  return {
    live: { ...LIVE },
    ended: false,
    state: {
      kind: "record",
      state: "recording",
      run: "fan/03",
      words: "recording data/fan/03, Ctrl-C ends it",
      recording: { elapsed_s: 83.4, events: 1_234_567, others: 800, bytes: 6_020_939, queue_bytes: 0, dropped: nothingLost() },
      sources: [{ name: "tcp://127.0.0.1:7777", state: "sends", packets_per_s: 1000, error: null }],
      robot: null,
      video: null,
      disk: { free_bytes: 63e9, minutes: 650 },
      warnings: [],
      ...more,
    },
  };
}

function detection(more = {}) {
  return {
    live: { ...LIVE },
    ended: false,
    state: {
      kind: "detect",
      state: "detecting",
      source: "camera",
      model: "fan",
      tick: { t_us: 1, verdict: "none", predicted: "press", p: [0.2, 0.7, 0.1], events: 900, beginning: 0 },
      ticks: { reported: 5000, skipped: 0, late: 0, incomplete: 0 },
      lateness: { p50_ms: 0.4, p99_ms: 1.25, max_ms: 3 },
      warnings: [],
      ...more,
    },
  };
}

const fact = (message, term) => factsOf(message).find(([name]) => name === term);

test("the chart has the steps of the last minute, once each and in order", () => {
  const steps = new Steps();
  steps.add([[0.1, 5], [0.2, 6]]);
  steps.add([[0.3, 7]]);
  steps.add([]);
  assert.deepEqual(
    steps.rows.map(([t]) => t),
    [0.1, 0.2, 0.3],
  );
  assert.deepEqual(steps.of(["b"], ["a", "b"]).length, 3);
  steps.add([[60.25, 8]]);
  assert.deepEqual(
    steps.rows.map(([t]) => t),
    [0.3, 60.25],
  );
  assert.deepEqual(steps.of(["a"], ["a"]), [
    [0.3 - 60.25, 7],
    [0, 8],
  ]);
});

test("a program that began again begins a new chart", () => {
  const steps = new Steps();
  steps.add([[10, 1], [11, 2]]);
  steps.add([[0.1, 3]]);
  assert.deepEqual(steps.rows, [[0.1, 3]]);
});

test("columns are found by their names, in any order", () => {
  const steps = new Steps();
  steps.add([[1, 100, 0.2, null]]);
  assert.deepEqual(steps.of(["p_slip", "p_press"], ["events_per_s", "p_press", "p_slip"]), [[0, null, 0.2]]);
});

test("the camera's clock is shown at once and its drift after ten seconds, only of a live camera", () => {
  const withClock = (clock) => {
    const message = recording();
    message.state.recording.clock = clock;
    return message;
  };
  assert.equal(fact(withClock(null), "Camera clock"), undefined);
  assert.equal(fact(recording(), "Packet lateness"), undefined, "an earlier program has no clock");
  const early = withClock({ offset_us: 5, change_ms: 0.2, seconds: 3.2, lateness_ms: 1.25 });
  assert.deepEqual(fact(early, "Camera clock").slice(1), ["5 µs behind the host's; drift known in 7 s"]);
  assert.deepEqual(fact(early, "Packet lateness").slice(1), ["up to 1.25 ms"]);
  const slow = withClock({ offset_us: 5, change_ms: 0.12, seconds: 40, lateness_ms: 0.5 });
  assert.deepEqual(fact(slow, "Camera clock").slice(1), ["5 µs behind the host's; 0.12 ms slow in 40 s (3 ppm)"]);
  const fast = withClock({ offset_us: 5, change_ms: -2, seconds: 100, lateness_ms: 0.5 });
  assert.deepEqual(fact(fast, "Camera clock").slice(1), ["5 µs behind the host's; 2.00 ms fast in 100 s (20 ppm)"]);
});

test("the robot's clock is known like the camera's", () => {
  const clock = { offset_us: -1_700_000_123_456_789, change_ms: -0.4, seconds: 40 };
  const robot = { connected: true, rate_hz: 500, gaps: 0, missing: 0 };
  assert.deepEqual(fact(recording({ robot: { ...robot, clock } }), "Robot clock").slice(1), ["counts from another moment than the host's; 0.40 ms fast in 40 s (10 ppm)"]);
  assert.equal(fact(recording({ robot: { ...robot, clock: null } }), "Robot clock"), undefined, "before its first package");
});

test("the headline says what the program does", () => {
  assert.deepEqual(headline({ state: null, live: LIVE }), { words: "The program begins.", mark: "" });
  assert.deepEqual(headline(recording()), { words: "Recording fan/03", detail: "1:23", mark: "bad" });
  assert.deepEqual(headline(recording({ state: "waiting", run: null, recording: null, words: "Enter starts" })), {
    words: "Waiting",
    detail: "Enter starts",
    mark: "",
  });
  assert.deepEqual(headline(detection()), { words: "none", detail: "press 0.70", mark: "none" });
  assert.equal(headline(detection({ tick: null })).words, "Waiting for the first verdict.");
});

test("at the end it says what is kept, and the error if there was one", () => {
  const runs = [{ object: "fan", run: "01" }, { object: "fan", run: "02" }];
  assert.equal(headline(recording({ state: "ended", runs, words: null })).words, "Recording has ended, with 2 runs; the last is fan/02.");
  assert.equal(
    headline(recording({ state: "ended", runs: [], words: "source gone" })).words,
    "Recording has ended, with no run. Error: source gone.",
  );
  assert.equal(headline(detection({ state: "ended", words: "interrupted" })).words, "Detection has ended: interrupted.");
});

test("losses name their reason and are marked", () => {
  assert.deepEqual(fact(recording(), "Dropped"), ["Dropped", "nothing", false]);
  const lost = { by_reason: { queue_full: { events: 2000, others: 5, packets: 3 }, outside: { events: 1, others: 0, packets: 0 } } };
  const message = recording();
  message.state.recording.dropped = lost;
  assert.deepEqual(fact(message, "Dropped"), [
    "Dropped",
    "2.0 k elements, 3 packets (disk too slow); 1 element, 0 packets (outside the sensor)",
    true,
  ]);
});

test("sources, robot, video and disk are marked when something is wrong with them", () => {
  const well = recording({
    robot: { connected: true, rate_hz: 500, rows: 9, gaps: 0, missing: 0, reconnects: 0 },
    video: { running: true, frames_per_s: 29.97, frames: 90, dropped: 0 },
  });
  assert.deepEqual(fact(well, "Robot"), ["Robot", "connected, 500 Hz", false]);
  assert.deepEqual(fact(well, "Video"), ["Video", "30.0 frames/s", false]);
  assert.equal(fact(well, "Film clock"), undefined, "the source gives no times");
  well.state.video.clock = { offset_us: 1.7e15, change_ms: 0.4, seconds: 40 };
  assert.equal(fact(well, "Film clock")[1], "counts from another moment than the host's; 0.40 ms slow in 40 s (10 ppm)");
  assert.deepEqual(fact(well, "Free disk"), ["Free disk", "63.0 GB, for 11 h", false]);
  const ill = recording({
    robot: { connected: false, rate_hz: 0, rows: 9, gaps: 2, missing: 40, reconnects: 0 },
    video: { running: false, frames_per_s: 0, frames: 90, dropped: 1 },
    disk: { free_bytes: 5e8, minutes: 4.2 },
    sources: [{ name: "unix:imu", state: "silent", packets_per_s: 0, error: null }],
  });
  assert.deepEqual(fact(ill, "Robot"), ["Robot", "not connected, 40 packages missing in 2 gaps", true]);
  assert.deepEqual(fact(ill, "Video"), ["Video", "has ended, 1 frame dropped", true]);
  assert.deepEqual(fact(ill, "Free disk"), ["Free disk", "500 MB, for 4 min", true]);
  assert.deepEqual(fact(ill, "unix:imu"), ["unix:imu", "is silent", true]);
});

test("a detection shows probabilities, missed ticks and lateness", () => {
  assert.equal(fact(detection(), "Probabilities")[1], "none 0.20, press 0.70, slip 0.10");
  assert.equal(fact(detection(), "Lateness")[1], "400 µs (median), 1.25 ms (99 %), 3 ms (highest of a second)");
  assert.equal(fact(detection({ lateness: null }), "Lateness")[1], "none: a replay has no deadline");
  assert.deepEqual(fact(detection({ ticks: { reported: 9, skipped: 1, late: 2, incomplete: 0 } }), "Missed ticks"), [
    "Missed ticks",
    "1 skipped, 2 late",
    true,
  ]);
});

test("a detection shows lost events, and the disk where it records", () => {
  assert.equal(fact(detection({ events: { late: 0, dropped: 0 } }), "Events lost"), undefined);
  assert.deepEqual(fact(detection({ events: { late: 12_000, dropped: 3 } }), "Events lost").slice(1), ["12 k too late, 3 dropped", true]);
  assert.equal(fact(detection(), "Free disk"), undefined);
  assert.deepEqual(fact(detection({ disk: { free_bytes: 5e9, minutes: null } }), "Free disk").slice(1), ["5.00 GB", false]);
});

test("warnings come from the program and from the events, and end with it", () => {
  const message = recording({ warnings: ["the robot is not connected"] });
  message.live.warnings = ["500 hot pixels"];
  message.live.silent_s = 3.4;
  assert.deepEqual(warningsOf(message), [
    "the robot is not connected",
    "no event for 3 s: a still scene, a covered lens, or a camera that has stopped",
    "500 hot pixels",
  ]);
  assert.deepEqual(warningsOf({ ...message, ended: true }), []);
});

test("a lost server is named with the age of what is seen", () => {
  assert.equal(lostWords(4.2, true), "The program does not answer: it has ended, or was stopped. What you see is 4 s old. The page tries again.");
  assert.equal(lostWords(4.2, false), "The program does not answer: it has ended, or was stopped. The page tries again.");
});
