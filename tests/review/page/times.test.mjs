import assert from "node:assert/strict";
import { test } from "node:test";
import { neededEventTimes, neededSamples, rootTicks, rowsOf } from "../../../apps/tactile/web/detail.js";
import {
  lastUntil,
  nearestOf,
  nearestTick,
  snapped,
  steppedOf,
  steppedTick,
  withinWhilePlaying,
} from "../../../apps/tactile/web/snapping.js";
import { around, fitted, following, panned, pixelOf, timeAt, zoomed, zoomedAround } from "../../../apps/tactile/web/time_view.js";

const ticks = { tick_us: 2000, tick_origin_us: 500 };

test("the nearest tick counts from the origin, and of two it is the earlier", () => {
  assert.equal(nearestTick(1400, ticks), 500);
  assert.equal(nearestTick(1500, ticks), 500);
  assert.equal(nearestTick(1501, ticks), 2500);
  assert.equal(nearestTick(0, ticks), 500);
  assert.equal(nearestTick(-900, ticks), -1500);
});

test("a step from between two ticks goes to the next tick, not over it", () => {
  assert.equal(steppedTick(500, 1, ticks), 2500);
  assert.equal(steppedTick(600, 1, ticks), 2500);
  assert.equal(steppedTick(2499, -1, ticks), 500);
  assert.equal(steppedTick(2500, -1, ticks), 500);
  assert.equal(steppedTick(500, 3, ticks), 6500);
});

test("the last time until another is found at the edges and between", () => {
  assert.deepEqual(
    [5, 10, 15, 20, 25].map((t) => lastUntil([10, 20], t)),
    [-1, 0, 0, 1, 1],
  );
  assert.equal(lastUntil([], 5), -1);
  assert.equal(lastUntil([10, 10, 10], 10), 2);
});

test("the nearest of some times is the earlier of two, and nothing where there are none", () => {
  assert.equal(nearestOf([10, 20], 15), 10);
  assert.equal(nearestOf([10, 20], 16), 20);
  assert.equal(nearestOf([10, 20], -4), 10);
  assert.equal(nearestOf([10, 20], 99), 20);
  assert.equal(nearestOf([], 99), null);
});

test("steps through times stop at the first and the last", () => {
  const times = [10, 20, 30];
  assert.equal(steppedOf(times, 20, 1), 30);
  assert.equal(steppedOf(times, 20, -1), 10);
  assert.equal(steppedOf(times, 25, 1), 30);
  assert.equal(steppedOf(times, 25, -1), 20);
  assert.equal(steppedOf(times, 30, 1), 30);
  assert.equal(steppedOf(times, 3, -1), 10);
  assert.equal(steppedOf([], 3, -1), null);
});

test("a drag snaps to an event where events are known, else to a tick, and to neither on demand", () => {
  assert.deepEqual(snapped(3100, "automatic", ticks, [3000, 3300], 10), { to_us: 3000, within_us: 1000, to: "event" });
  assert.deepEqual(snapped(3100, "automatic", ticks, [], 10), { to_us: 2500, within_us: 1000, to: "tick" });
  assert.deepEqual(snapped(3100, "ticks", ticks, [3000, 3300], 10), { to_us: 2500, within_us: 1000, to: "tick" });
  assert.deepEqual(snapped(3100.4, "nothing", ticks, [3000, 3300], 10), { to_us: 3100, within_us: 1000, to: null });
});

test("the interval of a dragged end is as wide as two pixels, and as half the gap between events", () => {
  assert.equal(snapped(3100, "ticks", ticks, [], 2000).within_us, 4000);
  assert.equal(snapped(3100, "events", ticks, [3000, 13000], 10).within_us, 5000);
});

test("a mark while playing has the interval of a person's reaction, slowed as the recording", () => {
  assert.equal(withinWhilePlaying(1), 200_000);
  assert.equal(withinWhilePlaying(0.05), 10_000);
  assert.ok(withinWhilePlaying(0.001) >= 1000);
});

test("a view stays in the run and shows a millisecond at least", () => {
  assert.deepEqual(fitted({ from_us: -500, to_us: 500 }, 10_000), { from_us: 0, to_us: 1000 });
  assert.deepEqual(fitted({ from_us: 9_800, to_us: 9_900 }, 10_000), { from_us: 9000, to_us: 10_000 });
  assert.deepEqual(fitted({ from_us: -5, to_us: 99_000 }, 10_000), { from_us: 0, to_us: 10_000 });
});

test("zooming keeps the time under the pointer where it is", () => {
  const before = { from_us: 100_000, to_us: 300_000 };
  const after = zoomed(before, 150_000, 0.5, 1_000_000);
  assert.equal(after.to_us - after.from_us, 100_000);
  assert.equal(pixelOf(150_000, after, 800), pixelOf(150_000, before, 800));
  let view = before;
  for (let i = 0; i < 40; ++i) view = zoomed(view, 150_000, 0.5, 1_000_000);
  assert.equal(view.to_us - view.from_us, 1000);
  for (let i = 0; i < 40; ++i) view = zoomed(view, 150_000, 2, 1_000_000);
  assert.deepEqual(view, { from_us: 0, to_us: 1_000_000 });
});

test("a pan ends at the run's ends and keeps the length", () => {
  assert.deepEqual(panned({ from_us: 0, to_us: 2000 }, -500, 10_000), { from_us: 0, to_us: 2000 });
  assert.deepEqual(panned({ from_us: 0, to_us: 2000 }, 99_000, 10_000), { from_us: 8000, to_us: 10_000 });
  assert.deepEqual(around(5000, 2000, 10_000), { from_us: 4000, to_us: 6000 });
});

test("the axis follows the cursor only where it leaves it", () => {
  const view = { from_us: 0, to_us: 100_000 };
  assert.equal(following(view, 50_000, 1_000_000), view);
  assert.ok(following(view, 120_000, 1_000_000).to_us > 120_000);
  assert.ok(following({ from_us: 500_000, to_us: 600_000 }, 100, 1_000_000).from_us === 0);
});

test("pixels and times are each other's inverse", () => {
  const view = { from_us: 1234, to_us: 9876 };
  for (const t of [1234, 2000, 9876]) assert.equal(timeAt(pixelOf(t, view, 777), view, 777), t);
});

test("samples are asked for where none cover the view or they are too coarse", () => {
  const view = { from_us: 400_000, to_us: 500_000 };
  const first = neededSamples(view, 2_000_000, null, 800);
  assert.deepEqual(first, { from_us: 350_000, to_us: 550_000, points: 1600, smooth_us: 1000 });
  assert.equal(neededSamples(view, 2_000_000, first, 800), null);
  assert.equal(neededSamples(panned(view, 40_000, 2_000_000), 2_000_000, first, 800), null);
  assert.notEqual(neededSamples(panned(view, 60_000, 2_000_000), 2_000_000, first, 800), null);
  assert.notEqual(neededSamples({ from_us: 400_000, to_us: 440_000 }, 2_000_000, first, 800), null, "2.5 times as close");
});

test("a request never leaves the run and never asks for more than 4000 samples", () => {
  const need = neededSamples({ from_us: 0, to_us: 600_000_000 }, 600_000_000, null, 9000);
  assert.deepEqual(need, { from_us: 0, to_us: 600_000_000, points: 4000, smooth_us: 6_000_000 });
});

test("rates are smoothed by a hundredth of the view, also after zooming out", () => {
  const close = neededSamples({ from_us: 480_000, to_us: 540_000 }, 2_000_000, null, 1000);
  assert.equal(close.smooth_us, 600);
  const all = { from_us: 0, to_us: 2_000_000, points: 4000, smooth_us: 600 };
  assert.equal(neededSamples({ from_us: 0, to_us: 2_000_000 }, 2_000_000, all, 1000).smooth_us, 20_000);
});

test("an axis of square roots has round numbers that do not overlap", () => {
  const ticks = rootTicks(Math.sqrt(120), Math.sqrt(120) / 4);
  assert.deepEqual(ticks.map((tick) => tick.label), ["0", "10", "50", "100"]);
  for (const { v, label } of ticks) assert.ok(Math.abs(v * v - Number(label)) < 1e-9);
});

test("single events are asked for only where the view is a tenth of a second at most", () => {
  assert.equal(neededEventTimes({ from_us: 0, to_us: 100_001 }, 0, 1_000_000, null), null);
  const view = { from_us: 200_000, to_us: 240_000 };
  const need = neededEventTimes(view, 210_000, 1_000_000, null);
  assert.deepEqual(need, { from_us: 170_000, to_us: 270_000 });
  assert.equal(neededEventTimes(panned(view, 20_000, 1_000_000), 230_000, 1_000_000, need), null);
  assert.notEqual(neededEventTimes(panned(view, 60_000, 1_000_000), 290_000, 1_000_000, need), null);
});

test("where events are dense, those around the cursor are asked for, and others when it moves on", () => {
  const view = { from_us: 200_000, to_us: 260_000 };
  const need = neededEventTimes(view, 230_000, 1_000_000, null, 8_000);
  assert.deepEqual(need, { from_us: 226_000, to_us: 234_000 });
  assert.equal(neededEventTimes(view, 231_000, 1_000_000, need, 8_000), null);
  assert.deepEqual(neededEventTimes(view, 240_000, 1_000_000, need, 8_000), { from_us: 236_000, to_us: 244_000 });
});

test("rows of a chart are in seconds, with gaps kept", () => {
  assert.deepEqual(rowsOf({ t_us: [1000, 2000], min: [1, null], mean: [2, null], max: [3, null] }), [
    [0.001, [1, 2, 3]],
    [0.002, [null, null, null]],
  ]);
});

test("a zoom is around the cursor where the view has it, else around the middle", () => {
  const view = { from_us: 0, to_us: 100_000 };
  assert.deepEqual(zoomedAround(view, 20_000, 0.5, 1_000_000), { from_us: 10_000, to_us: 60_000 });
  assert.deepEqual(zoomedAround(view, 500_000, 0.5, 1_000_000), { from_us: 25_000, to_us: 75_000 });
  assert.deepEqual(zoomedAround(view, null, 0.5, 1_000_000), { from_us: 25_000, to_us: 75_000 }, "no cursor is not a cursor at 0");
  assert.deepEqual(zoomedAround(view, 20_000, Infinity, 1_000_000), { from_us: 0, to_us: 1_000_000 });
});
