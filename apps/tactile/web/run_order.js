// Which runs the table shows, and in which order. No part of the document is used here.

/// What a person must look at first: flagged runs, then unconfirmed ones, then the rest. Lower comes first.
export function urgency(run) {
  if (run.error) return 0;
  if (run.open_flags > 0) return 1;
  return run.confirmed ? 3 : 2;
}

export const STATES = { 0: "unreadable", 1: "flagged", 2: "unconfirmed", 3: "confirmed" };

export function stateOf(run) {
  return STATES[urgency(run)];
}

const names = new Intl.Collator("en", { numeric: true });

function onsetOf(run, touch) {
  const interval = (run.intervals ?? []).find((i) => i.touch === touch);
  return interval ? interval.start_us : null;
}

/// What each column is sorted by. null comes last, in both directions.
export const SORT_KEYS = {
  state: (run) => urgency(run),
  name: (run) => run.name,
  length: (run) => run.length_s ?? null,
  rate: (run) => run.rate_mean_per_s ?? null,
  flags: (run) => run.open_flags ?? 0,
  clock: (run) => run.clocks?.robot_interval_ms ?? null,
  press: (run) => onsetOf(run, "press"),
  slip: (run) => onsetOf(run, "slip"),
};

/// The runs by `column`, upward or downward; equal ones by urgency and name.
export function sorted(runs, column, downward = false) {
  const key = SORT_KEYS[column] ?? SORT_KEYS.state;
  const compared = (a, b) => {
    const [x, y] = [key(a), key(b)];
    if (x === null || y === null) return (x === null) - (y === null);
    const order = typeof x === "string" ? names.compare(x, y) : x - y;
    return downward ? -order : order;
  };
  return [...runs].sort((a, b) => compared(a, b) || urgency(a) - urgency(b) || names.compare(a.name, b.name));
}

/// Runs whose name, flags or error contain every word of `search`, and whose state is `state` ("all" keeps each).
export function filtered(runs, search, state = "all") {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  return runs.filter((run) => {
    if (state === "simulated" ? !run.simulated : state !== "all" && stateOf(run) !== state) return false;
    const text = [run.name, run.error ?? "", ...(run.flags ?? []).map((f) => f.what)].join(" ").toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

/// The name of the next run after `name` that needs a person, or null. It begins again at the first.
export function nextToReview(runs, name, direction = 1) {
  const open = sorted(
    runs.filter((run) => !run.error && (run.open_flags > 0 || !run.confirmed) && run.name !== name),
    "name",
  ).map((run) => run.name);
  const flagged = new Set(runs.filter((run) => run.open_flags > 0).map((run) => run.name));
  const wanted = open.some((other) => flagged.has(other)) ? open.filter((other) => flagged.has(other)) : open;
  if (wanted.length === 0) return null;
  if (direction > 0) return wanted.find((other) => names.compare(other, name) > 0) ?? wanted[0];
  return wanted.findLast((other) => names.compare(other, name) < 0) ?? wanted.at(-1);
}

/// Some number of the server is still being computed.
export function stillComputing(runs) {
  return runs.some((run) => !run.error && (run.length_s === null || run.rate_mean_per_s === null));
}
