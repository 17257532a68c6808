import assert from "node:assert/strict";
import { test } from "node:test";
import { comparison, curvesOf, settingRows, sideBySide } from "../../../apps/tactile/web/figures.js";
import {
  clockTexts,
  countText,
  counted,
  figureText,
  lengthText,
  secondsFrom,
  secondsText,
  shortNumber,
  whenText,
  withinText,
} from "../../../apps/tactile/web/format.js";
import { compareAddress, routeOf, runAddress, splitAddress } from "../../../apps/tactile/web/router.js";
import { filtered, nextToReview, sorted, stateOf, stillComputing } from "../../../apps/tactile/web/run_order.js";

test("seconds have the decimals that the view can show", () => {
  assert.equal(secondsText(1_234_567), "1.234567 s");
  assert.equal(secondsText(1_234_567, 5_000_000), "1.235 s");
  assert.equal(secondsText(1_234_567, 50_000), "1.23457 s");
  assert.equal(secondsText(null), "–");
});

test("typed seconds are read with a point or a comma, and refused with letters", () => {
  assert.equal(secondsFrom(" 1.2345 s"), 1_234_500);
  assert.equal(secondsFrom("1,5"), 1_500_000);
  assert.equal(secondsFrom(".25"), 250_000);
  for (const wrong of ["", "1e3", "x", "1.2.3", "--1"]) assert.equal(secondsFrom(wrong), null, wrong);
});

test("lengths and counts are short", () => {
  assert.deepEqual([850, 12_500, 1_250, 2_700_000, 602_000_000].map(lengthText), ["850 µs", "12.5 ms", "1.25 ms", "2.70 s", "10 min 02 s"]);
  assert.deepEqual([999, 1_500, 37_000, 1_234_567, 5e9].map(countText), ["999", "1.5 k", "37 k", "1.23 M", "5.00 G"]);
  assert.deepEqual([0, 0.1234, 12.34, 123.4, 12_340].map(shortNumber), ["0", "0.123", "12.3", "123", "12 k"]);
  assert.equal(counted(1, "run"), "1 run");
  assert.equal(counted(0, "run"), "0 runs");
});

test("an interval is one number if it is symmetric, else two", () => {
  assert.equal(withinText(9000, 10_000, 11_000), "±1.0 ms");
  assert.equal(withinText(9400, 10_000, 12_100), "−0.6 … +2.1 ms");
  assert.equal(withinText(10_000, 10_000, 10_000), "exact");
});

test("figures carry their interval; shares are in percent", () => {
  assert.equal(figureText({ value: 0.971, low: 0.958, high: 0.98 }, "share"), "97.1 % (95.8 to 98.0)");
  assert.equal(figureText({ value: 97.1, low: 95.8, high: 98 }, "%"), "97.1 % (95.8 to 98.0)");
  assert.equal(figureText({ value: 24, low: 20, high: 29 }, "ms"), "24.0 ms (20.0 to 29.0)");
  assert.equal(figureText({ value: 24, low: null, high: null }, "ms"), "24.0 ms");
  assert.equal(figureText(null, "ms"), "–");
  assert.equal(whenText("2026-11-25T14:30:01.123Z"), "2026-11-25 14:30:01 UTC");
});

test("two figures differ only where their intervals do not meet", () => {
  const figure = (low, value, high) => ({ low, value, high });
  assert.equal(comparison(figure(5, 6, 7), figure(1, 2, 3)), "first is higher");
  assert.equal(comparison(figure(1, 2, 3), figure(5, 6, 7)), "first is lower");
  assert.equal(comparison(figure(1, 2, 3), figure(3, 6, 7)), "intervals overlap");
  assert.equal(comparison(figure(1, 2, 3), null), "");
});

test("two studies side by side have each figure once", () => {
  const rows = sideBySide(
    [
      { label: "a", value: 1 },
      { label: "b", value: 2 },
    ],
    [
      { label: "b", value: 3 },
      { label: "c", value: 4 },
    ],
  );
  assert.deepEqual(
    rows.map((r) => [r.label, r.first?.value ?? null, r.second?.value ?? null]),
    [
      ["a", 1, null],
      ["b", 2, 3],
      ["c", null, 4],
    ],
  );
});

test("nested settings become rows, and histories become curves of what they have", () => {
  assert.deepEqual(settingRows({ training: { epochs: 30 }, objects: ["fan", "box"] }), [
    ["training.epochs", "30"],
    ["objects", "fan, box"],
  ]);
  const curves = curvesOf([
    { epoch: 1, loss: 1, validation_loss: null, accuracy: 0.5, seconds: 2 },
    { epoch: 2, loss: 0.5, validation_loss: null, accuracy: 0.75, seconds: 2 },
  ]);
  assert.deepEqual(curves, [
    {
      title: "Loss",
      names: ["loss"],
      rows: [
        [1, 1],
        [2, 0.5],
      ],
    },
    {
      title: "Accuracy",
      names: ["accuracy"],
      rows: [
        [1, 0.5],
        [2, 0.75],
      ],
    },
  ]);
  assert.deepEqual(curvesOf([]), []);
});

test("an address and its route are each other's inverse, with any name", () => {
  assert.deepEqual(routeOf(runAddress("fan/01", 1_234_500)), { page: "run", name: "fan/01", at_us: 1_234_500 });
  assert.deepEqual(routeOf(runAddress("a b?c#d/01")), { page: "run", name: "a b?c#d/01", at_us: null });
  assert.deepEqual(routeOf(compareAddress("a/b", "c d", "fan/01")), { page: "compare", first: "a/b", second: "c d", run: "fan/01" });
  for (const odd of ["", "#", "#/", "#/nowhere", "#/run", "#/run/fan", "#/%E0%A4%A"]) assert.equal(routeOf(odd).page, "runs", odd);
});

const run = (name, more) => ({
  name,
  length_s: 1,
  rate_mean_per_s: 1,
  open_flags: 0,
  flags: [],
  confirmed: false,
  intervals: [],
  error: null,
  ...more,
});
const runs = [
  run("fan/10", { confirmed: true, length_s: 5 }),
  run("fan/9", { length_s: null }),
  run("box/1", { open_flags: 1, flags: [{ what: "no robot log" }], length_s: 2 }),
  run("cup/1", { error: "no event stream", length_s: null, rate_mean_per_s: null }),
];

test("what needs a person comes first, and confirmed runs last", () => {
  assert.deepEqual(
    sorted(runs, "state").map((r) => r.name),
    ["cup/1", "box/1", "fan/9", "fan/10"],
  );
  assert.deepEqual(runs.map(stateOf), ["confirmed", "unconfirmed", "flagged", "unreadable"]);
});

test("numbers in names sort as numbers, and unknown values come last in both directions", () => {
  assert.deepEqual(
    sorted(runs, "name").map((r) => r.name),
    ["box/1", "cup/1", "fan/9", "fan/10"],
  );
  assert.deepEqual(
    sorted(runs, "length").map((r) => r.name),
    ["box/1", "fan/10", "cup/1", "fan/9"],
  );
  assert.deepEqual(
    sorted(runs, "length", true).map((r) => r.name),
    ["fan/10", "box/1", "cup/1", "fan/9"],
  );
});

test("a search needs each of its words, in name, flag or error", () => {
  assert.deepEqual(
    filtered(runs, "ROBOT box").map((r) => r.name),
    ["box/1"],
  );
  assert.deepEqual(
    filtered(runs, "stream").map((r) => r.name),
    ["cup/1"],
  );
  assert.deepEqual(
    filtered(runs, "fan", "confirmed").map((r) => r.name),
    ["fan/10"],
  );
  assert.deepEqual(filtered(runs, "robot fan"), []);
});

test("the next run to review is flagged while there are flagged ones, and begins again at the first", () => {
  assert.equal(nextToReview(runs, "fan/9"), "box/1");
  assert.equal(nextToReview(runs, "box/1"), "fan/9");
  const three = ["a/1", "b/1", "c/1"].map((name) => run(name));
  assert.equal(nextToReview(three, "a/1"), "b/1");
  assert.equal(nextToReview(three, "c/1"), "a/1");
  assert.equal(nextToReview(three, "a/1", -1), "c/1");
  assert.equal(nextToReview([run("a/1", { confirmed: true })], ""), null);
});

test("numbers that are still computed make the table look again; unreadable runs do not", () => {
  assert.equal(stillComputing(runs), true);
  assert.equal(stillComputing([runs[0], runs[3]]), false);
});

test("the page that cuts a recording has an address of its own", () => {
  assert.deepEqual(routeOf(splitAddress("fan/01")), { page: "split", name: "fan/01" });
  assert.deepEqual(routeOf("#/split/fan"), { page: "runs" });
});

test("the clocks of a run have their interval", () => {
  const clocks = { robot_interval_ms: 0.812, video_interval_ms: 3 };
  assert.deepEqual(clockTexts(clocks), ["robot ±0.812 ms", "video ±3.00 ms"]);
  assert.deepEqual(clockTexts({ robot_interval_ms: null, video_interval_ms: null }), ["–"]);
  assert.deepEqual(clockTexts(null), ["–"]);
});
