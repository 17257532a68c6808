// The cuts of a long recording, and the runs between them. All times are whole microseconds after the first event. No document here.

const LEAST_US = 1000; // between two cuts

/// The runs between cuts, with the touches that begin in each: {begin_us, end_us, presses, slips, releases}.
export function runsBetween(cuts, touches, length_us) {
  const begins = [0, ...cuts];
  return begins.map((begin_us, index) => {
    const end_us = index + 1 < begins.length ? begins[index + 1] : length_us;
    const here = touches.filter((touch) => touch.begin_us >= begin_us && (touch.begin_us < end_us || index + 1 === begins.length));
    const presses = here.filter(({ kind }) => kind === "press").length;
    const slips = here.filter(({ kind }) => kind === "slip").length;
    return { begin_us, end_us, presses, slips, releases: here.filter(({ kind }) => kind === "release").length };
  });
}

function nearestFree(cuts, at_us, length_us) {
  const at = Math.round(at_us);
  if (at < LEAST_US || at > length_us - LEAST_US) return null;
  return cuts.every((cut) => Math.abs(cut - at) >= LEAST_US) ? at : null;
}

/// One more cut; null if it is outside, or at one that is there.
export function withCut(cuts, at_us, length_us) {
  const at = nearestFree(cuts, at_us, length_us);
  return at === null ? null : [...cuts, at].sort((a, b) => a - b);
}

export function withoutCut(cuts, index) {
  return cuts.filter((_, i) => i !== index);
}

/// A cut at another time: it stays between its neighbours, so that its number stays.
export function movedCut(cuts, index, to_us, length_us) {
  const low = (index > 0 ? cuts[index - 1] : 0) + LEAST_US;
  const high = (index + 1 < cuts.length ? cuts[index + 1] : length_us) - LEAST_US;
  return cuts.map((cut, i) => (i === index ? Math.min(high, Math.max(low, Math.round(to_us))) : cut));
}

/// Names of objects from a field: "fan, mug"; one for all runs, or one for each. A sentence if they do not suit.
export function objectsFrom(text, runs) {
  const names = text
    .split(",")
    .map((name) => name.trim())
    .filter(Boolean);
  if (names.length === 0) return { problem: "Name the object." };
  const wrong = names.find((name) => !/^[a-z0-9]+(-[a-z0-9]+)*$/.test(name));
  if (wrong) return { problem: `'${wrong}' is no name of an object: use lower-case letters, digits and inner hyphens.` };
  if (names.length > 1 && names.length !== runs) return { problem: `${names.length} names for ${runs} runs: give one name, or one for each run.` };
  return { names };
}

/// What a person should look at before writing: numbers of runs, from 1.
export function incompleteRuns(runs) {
  return runs.flatMap(({ presses, slips }, i) => (presses > 0 && slips > 0 ? [] : [i + 1]));
}
