// All that the page asks of the server. A token, where the server wants one, goes along with each request.

import { Conflict, Refused, Unreachable } from "./edit_queue.js";

const TOKEN = "tactile-token";

/// Keeps the token of the printed address for this browser's tabs, and takes it out of the address.
export function keepToken(where = location) {
  const token = new URLSearchParams(where.search).get("token");
  if (!token) return;
  localStorage.setItem(TOKEN, token);
  history.replaceState(null, "", where.pathname + where.hash);
}

function headers(more = {}) {
  const token = localStorage.getItem(TOKEN);
  return token ? { ...more, "X-Tactile-Token": token } : more;
}

const connection = new EventTarget();
let reachable = true;

/// Calls `listener(true or false)` when the server begins or ceases to answer; returns what ends that.
export function onConnection(listener) {
  const listen = () => listener(reachable);
  connection.addEventListener("change", listen);
  return () => connection.removeEventListener("change", listen);
}

function noteReachable(now) {
  if (reachable === now) return;
  reachable = now;
  connection.dispatchEvent(new Event("change"));
}

async function ask(path, options = {}) {
  let answer;
  try {
    answer = await fetch(path, { ...options, headers: headers(options.headers) });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    noteReachable(false);
    throw new Unreachable("the server does not answer");
  }
  noteReachable(true);
  return answer;
}

const post = (path, body, options) =>
  ask(path, { ...options, method: "POST", body: JSON.stringify(body), headers: { "Content-Type": "application/json" } });

async function refusal(answer) {
  if (answer.status === 401)
    return new Refused("open the address that tactile review printed: it has a token, which is new at every start", answer.status);
  const body = await answer.json().catch(() => null);
  return new Refused(body?.error ?? `the server answers ${answer.status}`, answer.status);
}

const pause = (ms) =>
  new Promise((resolve) => {
    setTimeout(resolve, ms);
  });

/// Asks until the server has read the run. `reading(share)` gets how far it is.
async function whenRead(path, { signal, reading } = {}) {
  for (;;) {
    const answer = await ask(path, { signal });
    if (answer.status !== 202) {
      if (!answer.ok) throw await refusal(answer);
      return answer;
    }
    const { share } = await answer.json();
    reading?.(share ?? 0);
    await pause(200);
    signal?.throwIfAborted();
  }
}

const ofRun = (name, rest = "") => `/api/runs/${name.split("/").map(encodeURIComponent).join("/")}${rest}`;

function query(values) {
  const given = Object.entries(values).filter(([, value]) => value !== null && value !== undefined);
  return "?" + new URLSearchParams(given.map(([key, value]) => [key, String(value)])).toString();
}

export async function getJson(path, options) {
  return (await whenRead(path, options)).json();
}

export const getRuns = (options) => getJson("/api/runs", options);
export const getRun = (name, options) => getJson(ofRun(name), options);
export const getLabels = (name, options) => getJson(ofRun(name, "/labels"), options);
export const getFrames = (name, options) => getJson(ofRun(name, "/frames"), options);
export const getWho = () => getJson("/api/who");
export const getModels = (options) => getJson("/api/models", options);
export const getStudies = (options) => getJson("/api/studies", options);

export function getSignals(name, { names, ...window }, options) {
  return getJson(ofRun(name, "/signals" + query({ ...window, names: names.join(",") })), options);
}

export const getEventTimes = (name, { from_us, to_us }, options) =>
  getJson(ofRun(name, "/event_times" + query({ from_us, to_us })), options);

/// Event counts or the heatmap of the history before `at_us`, as bytes. `kind` is "events" or "heatmap".
export async function getCounts(name, kind, at_us, history_us, options) {
  return (await whenRead(ofRun(name, `/${kind}` + query({ at_us, history_us })), options)).arrayBuffer();
}

/// The film's frame at `at_us`: {blob, frame_us}; both null before the first.
export async function getFilm(name, at_us, options) {
  const answer = await whenRead(ofRun(name, "/film" + query({ at_us })), options);
  if (answer.status === 204) return { blob: null, frame_us: null };
  const stamp = answer.headers.get("X-Frame-Us");
  return { blob: await answer.blob(), frame_us: stamp === null ? null : Number(stamp) };
}

/// The run's small picture, or null while it is not made yet. undefined: there will be none.
export async function getThumbnail(name, options) {
  const answer = await ask(ofRun(name, "/thumbnail"), options);
  if (answer.status === 200) return answer.blob();
  return answer.status === 202 ? null : undefined;
}

/// Has the server label a run that has no labels.
export async function sendLabel(name, options) {
  const answer = await post(ofRun(name, "/label"), {}, options);
  if (!answer.ok) throw await refusal(answer);
}

const ofSplit = (name) => `/api/splits/${name.split("/").map(encodeURIComponent).join("/")}`;

/// The cuts of a recording, proposed with this quiet time, and how far the server is with them.
export const getSplit = (name, quiet_ms, options) => getJson(ofSplit(name) + query({ quiet_ms }), options);

/// Begins to write the runs between cuts.
export async function sendSplit(name, wanted) {
  const answer = await post(ofSplit(name), wanted);
  if (!answer.ok) throw await refusal(answer);
  return answer.json();
}

/// Sends an operation on labels of this version, and gives the new labels.
export async function sendOperation(name, { op, edit, why }, version) {
  const path = ofRun(name, op === "edit" ? "/edits" : `/${op}`);
  const { local_id, flag_what, flag_interval, ...sent } = edit ?? {};
  const body = op === "edit" ? { version, edit: sent, ...(why ? { why } : {}) } : { version };
  const answer = await post(path, body);
  if (answer.status === 409) {
    const { error, current } = await answer.json();
    throw new Conflict(error, current);
  }
  if (answer.status >= 500) throw new Unreachable((await refusal(answer)).message);
  if (!answer.ok) throw await refusal(answer);
  return answer.json();
}
