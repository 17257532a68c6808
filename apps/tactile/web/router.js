// The address of a page, after the #: which part of the review is shown.

/// {page, ...} of a hash: "#/run/fan/01?t=1.2345" is {page: "run", name: "fan/01", at_us: 1234500}. Anything unknown is the list of runs.
export function routeOf(hash) {
  const [path, query = ""] = hash.replace(/^#\/?/, "").split("?");
  const parts = path.split("/").map(decoded);
  const asked = new URLSearchParams(query);
  if (parts[0] === "run" && parts.length >= 3) {
    const seconds = Number(asked.get("t"));
    const at_us = asked.has("t") && Number.isFinite(seconds) ? Math.round(seconds * 1e6) : null;
    return { page: "run", name: `${parts[1]}/${parts[2]}`, at_us };
  }
  if (parts[0] === "split" && parts.length >= 3) return { page: "split", name: `${parts[1]}/${parts[2]}` };
  if (parts[0] === "models" && parts.length >= 4 && parts[2] === "vs") {
    return { page: "compare", first: parts[1], second: parts[3], run: asked.get("run") };
  }
  if (parts[0] === "models") return { page: "models" };
  if (parts[0] === "studies") return { page: "studies", first: asked.get("first"), second: asked.get("second") };
  return { page: "runs" };
}

function decoded(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return part; // a % that begins no character: no such run will be found, and a message says so
  }
}

export function runAddress(name, at_us = null) {
  const [object, run] = name.split("/");
  const at = at_us === null ? "" : `?t=${(at_us / 1e6).toFixed(6)}`;
  return `#/run/${encodeURIComponent(object)}/${encodeURIComponent(run)}${at}`;
}

export function splitAddress(name) {
  const [object, run] = name.split("/");
  return `#/split/${encodeURIComponent(object)}/${encodeURIComponent(run)}`;
}

export function compareAddress(first, second, run = null) {
  const asked = run === null ? "" : `?run=${encodeURIComponent(run)}`;
  return `#/models/${encodeURIComponent(first)}/vs/${encodeURIComponent(second)}${asked}`;
}
