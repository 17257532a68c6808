import assert from "node:assert/strict";
import { test } from "node:test";
import { incompleteRuns, movedCut, objectsFrom, runsBetween, withCut, withoutCut } from "../../../apps/tactile/web/split_cuts.js";

const LENGTH = 20_000_000;
const touch = (kind, begin_us) => ({ kind, begin_us, end_us: begin_us + 200_000 });
const TOUCHES = [touch("press", 1_000_000), touch("slip", 2_000_000), touch("press", 11_000_000), touch("release", 12_000_000), touch("slip", 20_000_000)];

test("runs lie between cuts and have the touches that begin in them", () => {
  assert.deepEqual(runsBetween([8_000_000], TOUCHES, LENGTH), [
    { begin_us: 0, end_us: 8_000_000, presses: 1, slips: 1, releases: 0 },
    { begin_us: 8_000_000, end_us: LENGTH, presses: 1, slips: 1, releases: 1 },
  ]);
  assert.deepEqual(incompleteRuns(runsBetween([1_500_000, 8_000_000], TOUCHES, LENGTH)), [1, 2]);
  assert.deepEqual(
    runsBetween([], TOUCHES, LENGTH).map(({ end_us }) => end_us),
    [LENGTH],
  );
});

test("a cut is added in order, and neither outside nor at another", () => {
  assert.deepEqual(withCut([8_000_000], 3_000_000.4, LENGTH), [3_000_000, 8_000_000]);
  for (const at of [0, -5, LENGTH, 8_000_500]) assert.equal(withCut([8_000_000], at, LENGTH), null, String(at));
  assert.deepEqual(withoutCut([1, 2, 3], 1), [1, 3]);
});

test("a cut that is moved stays between its neighbours", () => {
  const cuts = [3_000_000, 8_000_000, 15_000_000];
  assert.deepEqual(movedCut(cuts, 1, 9_000_000, LENGTH), [3_000_000, 9_000_000, 15_000_000]);
  assert.deepEqual(movedCut(cuts, 1, 1, LENGTH), [3_000_000, 3_001_000, 15_000_000]);
  assert.deepEqual(movedCut(cuts, 2, 99e6, LENGTH), [3_000_000, 8_000_000, LENGTH - 1000]);
  assert.deepEqual(movedCut(cuts, 0, -1, LENGTH)[0], 1000);
  assert.deepEqual(cuts, [3_000_000, 8_000_000, 15_000_000]);
});

test("objects are one name or one for each run", () => {
  assert.deepEqual(objectsFrom("fan", 3), { names: ["fan"] });
  assert.deepEqual(objectsFrom("fan, usb-hub ,mug", 3), { names: ["fan", "usb-hub", "mug"] });
  for (const wrong of ["", " , ", "Fan", "../data", "-fan", "fan,mug"]) assert.ok(objectsFrom(wrong, 3).problem, wrong);
});
