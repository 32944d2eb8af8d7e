// State of the page in the address, after #.

const NUMBERS = ["row", "length", "shift", "duration", "limit", "height", "satellite", "bright"];
const WORDS = { target: /^.{1,100}$/, start: /^[\d:.TZ-]{1,40}$/, night: /^\d{4}-\d{2}-\d{2}$/, model: /^[\w.-]{1,100}$/, light: /^red$/, sigma: /^1$/, map: /^1$/, order: /^time$/ };

/** Reads the state from the address; unknown and invalid entries are ignored. */
export function read(hash = location.hash) {
  const entries = new URLSearchParams(hash.replace(/^#/, ""));
  const state = {};
  for (const name of NUMBERS) {
    const number = entries.has(name) ? Number(entries.get(name)) : NaN;
    if (Number.isFinite(number)) state[name] = number;
  }
  for (const [name, pattern] of Object.entries(WORDS)) {
    if (pattern.test(entries.get(name) ?? "")) state[name] = entries.get(name);
  }
  return state;
}

/** Returns the state as text of the address. */
export function text(state) {
  const entries = new URLSearchParams();
  for (const name of ["night", "target", "start", ...NUMBERS, "model", "light", "sigma", "map", "order"]) {
    const value = state[name];
    if (value != null && value !== "" && !(name === "shift" && value === 0)) entries.set(name, String(value));
  }
  return "#" + entries;
}

let timer = 0;
/** Kind of the change that is not in the address yet. */
let waiting = null;

/**
 * Writes the state into the address, within the rate limit of browsers. A change with a `kind` is a new entry of the
 * browser's history; several changes of the same kind in a row are one entry, except exposures.
 */
export function write(state, kind = null) {
  clearTimeout(timer);
  waiting = kind ?? waiting;
  timer = setTimeout(() => {
    const isSame = text(state) === location.hash;
    const isNew = waiting && !isSame && (waiting === "exposure" || waiting !== history.state);
    // The entry keeps the kind of the change that made it.
    if (isNew) history.pushState(waiting, "", text(state));
    else if (!isSame) history.replaceState(history.state, "", text(state));
    waiting = null;
  }, 120);
}

/** Discards a change that is not in the address yet, when the browser goes back or forward. */
export function forget() {
  clearTimeout(timer);
  waiting = null;
}
