import assert from "node:assert/strict";
import { test } from "node:test";

globalThis.matchMedia = () => ({ matches: false, addEventListener() {}, removeEventListener() {} }); // of the browser
const { countsOf, heatScale, paintEvents, paintHeat } = await import("../../../apps/tactile/web/counts_picture.js");
const { Player, otherSpeed } = await import("../../../apps/tactile/web/player.js");
const { nameOf } = await import("../../../apps/tactile/web/keys.js");
const { confirmMany, confirmable, flagKinds } = await import("../../../apps/tactile/web/confirm_many.js");
const { announce, endMessage } = await import("../../../apps/tactile/web/dom.js");
const { jointRows, stripsOf, valueAt } = await import("../../../apps/tactile/web/signal_strips.js");

function answer(width, height, on, off, bytes) {
  const buffer = new Uint8Array(16 + bytes.length);
  new DataView(buffer.buffer).setUint32(0, width, true);
  new DataView(buffer.buffer).setUint32(4, height, true);
  new DataView(buffer.buffer).setUint32(8, on, true);
  new DataView(buffer.buffer).setUint32(12, off, true);
  buffer.set(bytes, 16);
  return buffer.buffer;
}

test("counts have a header of four numbers and one or two planes", () => {
  const counts = countsOf(answer(2, 1, 3, 4, [1, 2, 0, 4]));
  assert.deepEqual([counts.width, counts.height, counts.on, counts.off], [2, 1, 3, 4]);
  assert.deepEqual(
    [[...counts.first], [...counts.second]],
    [
      [1, 2],
      [0, 4],
    ],
  );
  assert.equal(countsOf(answer(2, 1, 3, 0, [9, 8])).second, null);
  assert.throws(() => countsOf(answer(2, 1, 3, 0, [9, 8, 7])), /19 bytes for 2 x 1 pixels/);
});

test("a pixel without events is paper; ON is bluer than red and OFF redder than blue, light and dark", () => {
  const counts = countsOf(answer(3, 1, 1, 1, [0, 1, 0, 0, 0, 1]));
  for (const dark of [false, true]) {
    const pixels = new Uint8ClampedArray(12);
    paintEvents(counts, pixels, dark);
    assert.ok(pixels[0] === pixels[1] && pixels[1] === pixels[2]);
    assert.ok(pixels[4 + 2] > pixels[4], `ON, ${dark}`);
    assert.ok(pixels[8] > pixels[8 + 2], `OFF, ${dark}`);
    assert.deepEqual([pixels[3], pixels[7], pixels[11]], [255, 255, 255]);
  }
});

test("the heatmap's scale grows brighter from black to nearly white", () => {
  const scale = heatScale();
  const brightness = scale.map(([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b);
  assert.equal(scale.length, 256);
  assert.ok(brightness.every((value, i) => i === 0 || value >= brightness[i - 1]));
  const pixels = new Uint8ClampedArray(8);
  paintHeat(countsOf(answer(2, 1, 0, 0, [0, 255])), pixels);
  assert.ok(pixels[0] < 10 && pixels[4] > 240);
});

test("playing moves the cursor by the time that passes, times the speed, to the end", () => {
  const frames = [];
  const state = {
    at_us: 0,
    length_us: 100_000,
    playing: false,
    setPlaying(on) {
      this.playing = on;
    },
    setAt(at) {
      this.at_us = Math.min(Math.round(at), this.length_us);
    },
  };
  const player = new Player(state, 0.5, (frame) => frames.push(frame));
  player.toggle();
  frames.shift()(1000);
  frames.shift()(1020);
  assert.equal(state.at_us, 10_000);
  player.speed = 4;
  frames.shift()(1040);
  assert.equal(state.at_us, 90_000);
  frames.shift()(1060);
  assert.equal(state.at_us, 100_000);
  assert.equal(state.playing, false);
  assert.equal(frames.length, 0);
});

test("speeds go from 0.05 to 4 and no further", () => {
  assert.equal(otherSpeed(1, 1), 2);
  assert.equal(otherSpeed(0.05, -1), 0.05);
  assert.equal(otherSpeed(4, 1), 4);
});

test("a key's name has Ctrl and Shift where they matter", () => {
  const name = (key, more = {}) => nameOf({ key, shiftKey: false, ctrlKey: false, metaKey: false, ...more });
  assert.equal(name(" "), "Space");
  assert.equal(name("N", { shiftKey: true }), "Shift+N");
  assert.equal(name("?", { shiftKey: true }), "?");
  assert.equal(name("ArrowLeft", { shiftKey: true }), "Shift+ArrowLeft");
  assert.equal(name("z", { ctrlKey: true }), "Ctrl+z");
  assert.equal(name("Z", { metaKey: true, shiftKey: true }), "Ctrl+Shift+Z");
});

test("the probabilities share one strip, with rows at the times of the first", () => {
  const strips = stripsOf([
    { name: "event_rate", label: "Rate" },
    { name: "p_press", label: "" },
    { name: "p_slip", label: "" },
  ]);
  assert.deepEqual(
    strips.map((s) => s.names),
    [["event_rate"], ["p_press", "p_slip"]],
  );
  const series = (t_us, v) => ({ t_us, min: v, mean: v, max: v });
  assert.deepEqual(jointRows([series([0, 1e6], [1, 2]), series([1e6], [5])]), [
    [0, [1, 1, 1], [null, null, null]],
    [1, [2, 2, 2], [5, 5, 5]],
  ]);
});

test("the value at the cursor is the last sample, or the first where the cursor is just before it", () => {
  const series = { t_us: [100, 300], mean: [5, null] };
  assert.deepEqual([-200, -100, 99, 100, 299, 300].map((t) => valueAt(series, t)), [null, 5, 5, 5, 5, null]);
  assert.equal(valueAt({ t_us: [], mean: [] }, 5), null);
});

test("many runs are confirmed, or lose the flags of one kind, each by its own edits", async () => {
  const flag = (index, kind, confirmed = false) => ({ index, kind, what: `${kind} by 3 ms`, confirmed });
  const runs = [
    { name: "fan/01", has: { labels: true }, flags: [flag(0, "no-robot"), flag(1, "late")] },
    { name: "fan/02", has: { labels: true }, flags: [flag(0, "no-robot", true), flag(1, "late")] },
    { name: "fan/03", has: { labels: true }, confirmed: true, flags: [] },
    { name: "fan/04", has: { labels: false }, flags: [] },
  ];
  assert.deepEqual(confirmable(runs).map((run) => run.name), ["fan/01", "fan/02"]);
  assert.deepEqual(flagKinds(runs).map(({ kind, runs: having }) => [kind, having.join()]), [["late", "fan/01,fan/02"], ["no-robot", "fan/01"]]);
  const sent = [];
  const server = {
    getLabels: async (name) => ({ version: 1, flags: runs.find((run) => run.name === name).flags }),
    sendOperation: async (name, { edit, why }, version) => {
      if (name === "fan/02" && edit.flag === 1) throw new Error("the labels have changed");
      sent.push([name, edit.kind, edit.flag, why, version]);
      return { version: version + 1, flags: [] };
    },
  };
  const lifted = await confirmMany(["fan/01", "fan/02"], "late", "seen", server);
  assert.deepEqual(sent, [["fan/01", "lift", 1, "seen", 1]]);
  assert.deepEqual(lifted, { done: ["fan/01"], problems: ["fan/02: the labels have changed"] });
  await confirmMany(["fan/02"], "", "", server);
  assert.deepEqual(sent.at(-1), ["fan/02", "confirm-run", undefined, "", 1]);
});

test("a message goes with the next act of the person, news stays, and a modifier is no act", () => {
  const line = { textContent: "", dataset: {} };
  const listeners = new Map();
  globalThis.document = { getElementById: () => line };
  globalThis.addEventListener = (act, listener) => listeners.set(act, listener);
  globalThis.removeEventListener = (act) => listeners.delete(act);
  const act = (name, event) => listeners.get(name)?.(event);
  announce("A press begins. Press the same key at its end.");
  act("keydown", { key: "Shift" });
  assert.notEqual(line.textContent, "");
  act("keydown", { key: "p" });
  assert.equal(line.textContent, "");
  announce("Not made: the server refuses.", "error", { news: true });
  act("pointerdown", {});
  assert.notEqual(line.textContent, "");
  endMessage();
  assert.equal(line.textContent, "");
});
