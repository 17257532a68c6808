import assert from "node:assert/strict";
import { test } from "node:test";
import { Conflict, EditQueue, Refused, Unreachable } from "../../../apps/tactile/web/edit_queue.js";
import { changesBetween, meets, newEdits, rebased, rebasedAll } from "../../../apps/tactile/web/label_changes.js";
import { alreadyMade, edited, limitsOf, withOperations, wordsOf } from "../../../apps/tactile/web/label_edits.js";
import { Latest } from "../../../apps/tactile/web/latest.js";

// Node 18, of Debian 12, has no CustomEvent; browsers have.
globalThis.CustomEvent ??= class extends Event {
  constructor(type, options = {}) {
    super(type, options);
    this.detail = options.detail;
  }
};

const interval = (id, touch, start_us, end_us, more = {}) => ({
  id,
  touch,
  start_us,
  start_low_us: start_us - 100,
  start_high_us: start_us + 100,
  end_us,
  end_low_us: end_us - 100,
  end_high_us: end_us + 100,
  confirmed: false,
  source: "events",
  ...more,
});

const made = (version = "v1") => ({
  version,
  intervals: [interval("press-1", "press", 1000, 2000), interval("slip-1", "slip", 3000, 4000)],
  releases: [],
  rejected: [],
  remarks: [],
  history: [],
  flags: [
    { index: 0, interval_id: "slip-1", what: "uncertain", confirmed: false, lifted_why: null },
    { index: 1, interval_id: null, what: "no film", confirmed: false, lifted_why: null },
  ],
  can_undo: false,
  can_redo: false,
});

const move = (id, end, to_us, more = {}) => ({ op: "edit", why: "", edit: { kind: "move", id, end, to_us, ...more } });

/// A server in memory: makes edits, and can be made to fail once.
function server(labels) {
  const state = { labels, asked: [], fail: [] };
  state.send = async (operation, version) => {
    state.asked.push(wordsOf(operation));
    const failure = state.fail.shift();
    if (failure === "lost before") throw new Unreachable("no answer");
    if (failure instanceof Refused) throw failure;
    if (version !== state.labels.version) throw new Conflict("changed", state.labels);
    const after = operation.op === "edit" ? edited(state.labels, operation.edit, operation.why) : structuredClone(state.labels);
    if (operation.op === "undo") after.history.findLast((entry) => !entry.undone).undone = true;
    for (const [n, i] of after.intervals.entries()) if (i.id.startsWith("new ")) i.id = `${i.touch}-${n + 7}`;
    state.labels = { ...after, version: `v${Number(state.labels.version.slice(1)) + 1}` };
    if (failure === "lost after") throw new Unreachable("no answer");
    return structuredClone(state.labels);
  };
  return state;
}

function store(state = null) {
  return {
    state,
    load() {
      return this.state === null ? null : structuredClone(this.state);
    },
    save(value) {
      this.state = value === null ? null : structuredClone(value);
    },
  };
}

test("a moved end has its interval, is a person's, is confirmed, and so are its flags", () => {
  const before = made();
  const after = edited(before, move("slip-1", "start", 2900, { within_us: 250 }).edit);
  assert.deepEqual(after.intervals[1], {
    ...before.intervals[1],
    start_us: 2900,
    start_low_us: 2650,
    start_high_us: 3150,
    confirmed: true,
    source: "person",
  });
  assert.deepEqual(
    after.flags.map((f) => f.confirmed),
    [true, false],
  );
  assert.equal(before.intervals[1].start_us, 3000, "the labels before stay as they were");
});

test("a start that moves into the interval before it ends that one there, if asked", () => {
  const after = edited(made(), move("slip-1", "start", 1500, { end_earlier: true }).edit);
  assert.deepEqual(
    after.intervals.map((i) => [i.start_us, i.end_us]),
    [
      [1000, 1500],
      [1500, 4000],
    ],
  );
});

test("a removed interval is rejected, an added one is in order", () => {
  const after = edited(edited(made(), { kind: "reject", id: "press-1" }), { kind: "add", touch: "press", start_us: 100, end_us: 300 });
  assert.deepEqual(after.rejected, [{ touch: "press", start_us: 1000, end_us: 2000 }]);
  assert.deepEqual(
    after.intervals.map((i) => i.id),
    ["new press", "slip-1"],
  );
});

test("confirming the run confirms intervals and flags; lifting keeps the reason", () => {
  const confirmed = edited(made(), { kind: "confirm-run" });
  assert.ok([...confirmed.intervals, ...confirmed.flags].every((part) => part.confirmed));
  assert.deepEqual(edited(made(), { kind: "lift", flag: 1 }, "seen in the film").flags[1], {
    index: 1,
    interval_id: null,
    what: "no film",
    confirmed: true,
    lifted_why: "seen in the film",
  });
});

test("undo and redo of what waits are shown at once", () => {
  const operations = [move("press-1", "start", 1100), move("press-1", "start", 1200), { op: "undo" }];
  assert.equal(withOperations(made(), operations).intervals[0].start_us, 1100);
  assert.equal(withOperations(made(), [...operations, { op: "redo" }]).intervals[0].start_us, 1200);
  assert.equal(withOperations(made(), [...operations, { op: "undo" }, { op: "undo" }]).intervals[0].start_us, 1000);
});

test("an end may go from its own start to the next interval; a start may cut the one before", () => {
  const { intervals } = made();
  assert.deepEqual(limitsOf(intervals, "press-1", "end", 9000), { low: 1001, high: 3000 });
  assert.deepEqual(limitsOf(intervals, "slip-1", "end", 9000), { low: 3001, high: 9000 });
  assert.deepEqual(limitsOf(intervals, "slip-1", "start", 9000), { low: 1001, high: 3999 });
  assert.deepEqual(limitsOf(intervals, "press-1", "start", 9000), { low: 0, high: 1999 });
});

test("differences are in words, by interval", () => {
  const after = edited(edited(edited(made(), move("press-1", "start", 1500).edit), { kind: "reject", id: "slip-1" }), {
    kind: "add",
    touch: "slip",
    start_us: 5000,
    end_us: 6000,
    local_id: "slip-2",
  });
  assert.deepEqual(
    changesBetween(made(), after).map((c) => c.words),
    [
      "start of press-1 moved from 0.001000 s to 0.001500 s (500 µs)",
      "press-1 was confirmed",
      "slip-1 was removed",
      "slip-2 was added, 0.005000 s to 0.006000 s",
      'the flag "uncertain" is gone',
    ],
  );
  assert.deepEqual(changesBetween(made(), made("v9")), []);
});

test("an edit meets a change of the same interval only; undo and the whole run meet any", () => {
  const changes = changesBetween(made(), edited(made(), move("press-1", "start", 1500).edit));
  assert.equal(meets(move("press-1", "end", 2500), changes), true);
  assert.equal(meets(move("slip-1", "end", 4500), changes), false);
  assert.equal(meets({ op: "undo" }, changes), true);
  assert.equal(meets({ op: "edit", edit: { kind: "confirm-run" } }, changes), true);
  assert.equal(meets({ op: "undo" }, []), false);
});

test("new edits of others are those that the history did not have", () => {
  const entry = (when, undone = false) => ({ who: "bo", when, what: "x", undone });
  const [before, after] = [{ history: [entry("1")] }, { history: [entry("1"), entry("2")] }];
  assert.deepEqual(newEdits(before, after), [entry("2")]);
});

test("a flag keeps its words where its number changed, and an edit of what is gone is none", () => {
  const lift = { op: "edit", edit: { kind: "lift", flag: 1, flag_what: "no film", flag_interval: null } };
  const current = made();
  current.flags = [{ ...current.flags[1], index: 0 }];
  assert.equal(rebased(lift, current).edit.flag, 0);
  assert.equal(rebased(lift, { ...current, flags: [] }), null);
  assert.equal(rebased(move("press-9", "end", 1), current), null);
});

test("an undo is not made where it would undo another edit than the one that was meant", () => {
  const entry = (when, undone = false) => ({ who: "bo", when, what: "x", undone });
  const undo = { op: "undo", of: { when: "1", what: "x" } };
  assert.equal(rebased(undo, { history: [entry("1")] }), undo);
  assert.equal(rebased(undo, { history: [entry("1"), entry("2")] }), null, "another person has edited");
  assert.equal(rebased(undo, { history: [] }), null);
  assert.equal(rebased({ op: "undo" }, { history: [entry("2")] }), null, "what it means is not known");
  const redo = { op: "redo", of: { when: "2", what: "x" } };
  assert.equal(rebased(redo, { history: [entry("1"), entry("2", true)] }), redo);
  assert.equal(rebased(redo, { history: [entry("1", true), entry("2", true)] }), null);
});

test("a waiting undo means the waiting edit before it, else the history that was there", () => {
  const entry = (when) => ({ who: "bo", when, what: "x", undone: false });
  const [base, theirs] = [{ ...made(), history: [entry("1")] }, { ...made(), history: [entry("1"), entry("2")] }];
  const [undo, edit, lost] = [{ op: "undo" }, move("press-1", "start", 1100), move("press-9", "start", 1100)];
  const ops = ({ kept, dropped }) => [kept, dropped].map((list) => list.map((operation) => operation.edit?.id ?? operation.op).join());
  assert.deepEqual(ops(rebasedAll([undo, undo], base, base)), ["undo,undo", ""]);
  assert.deepEqual(ops(rebasedAll([undo, undo], base, theirs)), ["", "undo,undo"], "another person has edited");
  assert.deepEqual(ops(rebasedAll([edit, undo], base, theirs)), ["press-1,undo", ""], "it takes back what waits before it");
  assert.deepEqual(ops(rebasedAll([lost, undo], base, theirs)), ["", "press-9,undo"], "and goes with it");
  assert.deepEqual(ops(rebasedAll([edit, lost, undo, undo], base, theirs)), ["press-1,undo", "press-9,undo"]);
  assert.deepEqual(ops(rebasedAll([edit, undo, { op: "redo" }], base, theirs)), ["press-1,undo,redo", ""]);
  assert.deepEqual(ops(rebasedAll([undo], base, base, [false])), ["", "undo"], "the edit before it was refused");
});

test("two undos that wait while the server is lost do not undo another person's edit", async () => {
  const entry = (when, who) => ({ who, when, what: `edit ${when}`, undone: false });
  const history = [entry("1", "ada"), entry("2", "ada")];
  const there = server({ ...made(), history: structuredClone(history) });
  there.fail = ["lost before", "lost before"];
  const queue = new EditQueue({ labels: { ...made(), history: structuredClone(history) }, send: there.send, store: store() });
  await queue.add({ op: "undo" });
  await queue.add({ op: "undo" });
  there.labels = { ...there.labels, version: "v9", history: [...history, entry("3", "bo")] };
  there.fail = [];
  await queue.pump();
  assert.equal(queue.state, "conflict");
  await queue.resolve(true);
  assert.deepEqual(there.labels.history.map((e) => e.undone), [false, false, false]);
  assert.equal(queue.setAside.length, 2);
});

test("edits are sent one after the other, each on the version that the one before gave", async () => {
  const there = server(made());
  const queue = new EditQueue({ labels: made(), send: there.send, store: store() });
  queue.add(move("press-1", "start", 1100));
  assert.equal(queue.shown.intervals[0].start_us, 1100, "shown before it is saved");
  assert.equal(queue.state, "saving");
  await queue.add(move("press-1", "end", 2100));
  await queue.pump();
  while (queue.busy) await new Promise((r) => setImmediate(r));
  assert.deepEqual(there.asked, ["start of press-1 to 0.001100 s", "end of press-1 to 0.002100 s"]);
  assert.equal(queue.state, "saved");
  assert.equal(queue.labels.version, "v3");
  assert.equal(queue.store.state, null, "nothing is kept once the server has all");
});

test("an interval that was just added keeps its later edits under the server's name", async () => {
  const there = server(made());
  const queue = new EditQueue({ labels: made(), send: there.send, store: store() });
  queue.add({ op: "edit", edit: { kind: "add", touch: "slip", start_us: 5000, end_us: 6000, local_id: "new slip 1" } });
  await queue.add(move("new slip 1", "end", 6500));
  while (queue.busy) await new Promise((r) => setImmediate(r));
  assert.deepEqual(queue.labels.intervals.at(-1).end_us, 6500);
  assert.equal(queue.setAside.length, 0);
});

test("a lost server keeps the edits, and they are sent when it answers", async () => {
  const there = server(made());
  there.fail = ["lost before"];
  const kept = store();
  const queue = new EditQueue({ labels: made(), send: there.send, store: kept });
  await queue.add(move("press-1", "start", 1100));
  assert.equal(queue.state, "lost");
  assert.equal(kept.state.waiting.length, 1);
  const after = new EditQueue({ labels: made(), send: there.send, store: kept });
  assert.equal(after.shown.intervals[0].start_us, 1100, "a reload shows the edit");
  await after.pump();
  assert.equal(there.labels.intervals[0].start_us, 1100);
  assert.equal(after.state, "saved");
});

test("an edit whose answer was lost is not made twice", async () => {
  const there = server(made());
  there.fail = ["lost after"];
  const kept = store();
  const queue = new EditQueue({ labels: made(), send: there.send, store: kept });
  await queue.add(move("press-1", "start", 1100));
  assert.equal(queue.state, "lost");
  const after = new EditQueue({ labels: structuredClone(there.labels), send: there.send, store: kept });
  assert.equal(after.state, "saved");
  await queue.pump();
  assert.equal(queue.state, "saved", "without a reload, too");
  assert.equal(there.labels.version, "v2");
});

test("an undo whose answer was lost is found in the history", () => {
  const entry = { when: "1", what: "x", undone: false };
  const undo = { op: "undo", of: { when: "1", what: "x" } };
  assert.equal(alreadyMade(undo, { history: [entry] }), false);
  assert.equal(alreadyMade(undo, { history: [{ ...entry, undone: true }] }), true);
});

test("an undo whose answer was lost is not made twice", async () => {
  const history = ["1", "2"].map((when) => ({ when, what: "x", undone: false }));
  const there = server({ ...made(), history });
  there.fail = ["lost after"];
  const queue = new EditQueue({ labels: { ...made(), history: structuredClone(history) }, send: there.send, store: store() });
  await queue.add({ op: "undo" });
  assert.equal(queue.state, "lost");
  await queue.pump();
  assert.equal(queue.state, "saved");
  assert.deepEqual(there.labels.history.map((entry) => entry.undone), [false, true]);
});

test("a conflict waits for the person; mine is made on top of theirs", async () => {
  const there = server(made());
  there.labels = { ...edited(made(), move("slip-1", "end", 4400).edit), version: "v5" };
  const queue = new EditQueue({ labels: made(), send: there.send, store: store() });
  await queue.add(move("press-1", "start", 1100));
  assert.equal(queue.state, "conflict");
  assert.equal(there.labels.intervals[0].start_us, 1000, "nothing is overwritten before the person answers");
  await queue.resolve(true);
  assert.deepEqual([there.labels.intervals[0].start_us, there.labels.intervals[1].end_us], [1100, 4400]);
});

test("taking theirs sets mine aside, from where they can be made after all", async () => {
  const there = server(made());
  there.labels = { ...edited(made(), move("slip-1", "end", 4400).edit), version: "v5" };
  const kept = store();
  const queue = new EditQueue({ labels: made(), send: there.send, store: kept });
  await queue.add(move("press-1", "start", 1100));
  await queue.resolve(false);
  assert.equal(queue.shown.intervals[0].start_us, 1000);
  assert.equal(kept.state.setAside.length, 1);
  await queue.makeAfterAll(0);
  assert.equal(there.labels.intervals[0].start_us, 1100);
  assert.equal(kept.state, null);
});

test("a conflict that a reload finds is asked about, too", () => {
  const kept = store({ base: made(), waiting: [{ ...move("press-1", "start", 1100), tried: false }], setAside: [] });
  const now = { ...edited(made(), move("press-1", "start", 900).edit), version: "v2" };
  const queue = new EditQueue({ labels: now, send: () => assert.fail("nothing is sent"), store: kept });
  assert.equal(queue.state, "conflict");
  assert.equal(queue.conflict.base.version, "v1");
});

test("an edit that the server refuses is set aside with its reason, and the next one is sent", async () => {
  const there = server(made());
  there.fail = [new Refused("would overlap slip-1")];
  const queue = new EditQueue({ labels: made(), send: there.send, store: store() });
  const refused = [];
  queue.addEventListener("refused", (event) => refused.push(event.detail.reason));
  queue.add(move("press-1", "end", 3500));
  await queue.add(move("press-1", "start", 900));
  while (queue.busy) await new Promise((r) => setImmediate(r));
  assert.deepEqual(refused, ["would overlap slip-1"]);
  assert.deepEqual(there.labels.intervals[0].start_us, 900);
  assert.equal(queue.setAside[0].reason, "would overlap slip-1");
});

test("new labels of others are taken only while nothing waits", async () => {
  const queue = new EditQueue({
    labels: made(),
    send: async () => {
      throw new Unreachable("no answer");
    },
    store: store(),
  });
  const answered = (version) => queue.refresh(async () => (version ? made(version) : null));
  assert.equal(await answered("v2"), true);
  assert.equal(await answered("v2"), false);
  assert.equal(await answered(null), false, "no answer");
  await queue.add(move("press-1", "start", 900));
  assert.equal(await answered("v3"), false);
  assert.equal(queue.labels.version, "v2");
});

test("labels that an edit has overtaken on their way are not shown", async () => {
  const there = server(made());
  const queue = new EditQueue({ labels: made(), send: there.send, store: store() });
  let arrive;
  const refreshed = queue.refresh(() => new Promise((resolve) => (arrive = resolve)));
  await queue.add(move("press-1", "start", 900));
  while (queue.busy) await new Promise((r) => setImmediate(r));
  const saved = queue.labels.version;
  assert.notEqual(saved, made().version);
  arrive(made());
  assert.equal(await refreshed, false);
  assert.equal(queue.labels.version, saved);
  assert.equal(queue.shown.intervals[0].start_us, 900);
  await queue.add(move("press-1", "start", 800));
  while (queue.busy) await new Promise((r) => setImmediate(r));
  assert.equal(queue.conflict, null, "the next edit meets no conflict");
});

test("of many requests only the first and the newest are worked on", async () => {
  const done = [];
  const release = [];
  const latest = new Latest(
    (request) =>
      new Promise((resolve) => {
        done.push(request);
        release.push(resolve);
      }),
  );
  for (const request of [1, 2, 3, 4]) latest.ask(request);
  release[0]();
  await new Promise((r) => setImmediate(r));
  assert.deepEqual(done, [1, 4]);
  latest.stop();
  release[1]();
  latest.ask(5);
  await new Promise((r) => setImmediate(r));
  assert.deepEqual(done, [1, 4]);
});
