// What outlives a reload: the place in a run and what is half done (this tab), and edits that the server does not have (this browser).

function read(storage, key) {
  try {
    return JSON.parse(storage.getItem(key));
  } catch {
    return null; // written by another version, or storage is refused: begin without
  }
}

function write(storage, key, value) {
  if (value === null) storage.removeItem(key);
  else storage.setItem(key, JSON.stringify(value));
}

/// The place in a run, its draft and marks: of this tab.
export function keptPlace(run) {
  const key = `tactile-place:${run}`;
  return { load: () => read(sessionStorage, key), save: (value) => write(sessionStorage, key, value) };
}

const TAB = "tactile-tab";
const ALIVE_MS = 10_000;

function thisTab() {
  let tab = sessionStorage.getItem(TAB);
  if (!tab) {
    tab = `${Date.now()}-${Math.random().toString(36).slice(2)}`;
    sessionStorage.setItem(TAB, tab);
  }
  return tab;
}

/// The edits of a run that wait: of this tab, or of a tab that was closed before the server had them.
export function keptEdits(data, run) {
  const prefix = `tactile-edits:${data}:${run}:`;
  const own = prefix + thisTab();
  return {
    load() {
      const mine = read(localStorage, own);
      if (mine) return mine;
      for (const key of Object.keys(localStorage)) {
        const left = key.startsWith(prefix) ? read(localStorage, key) : null;
        if (!left || Date.now() - left.alive < ALIVE_MS) continue;
        localStorage.removeItem(key);
        write(localStorage, own, { ...left, alive: Date.now() });
        return left;
      }
      return null;
    },
    save(value) {
      write(localStorage, own, value && { ...value, alive: Date.now() });
    },
  };
}

/// A choice of the person that every run and visit keeps.
export function keptChoice(name, usual) {
  const key = `tactile-choice:${name}`;
  return { load: () => read(localStorage, key) ?? usual, save: (value) => write(localStorage, key, value) };
}
