// The state of the page in the address: what is after # brings back what was seen.

const NUMBERS = ["row", "shift", "duration", "limit", "height", "satellite"];
const WORDS = { night: /^\d{4}-\d{2}-\d{2}$/, model: /^[\w.-]{1,100}$/, light: /^red$/, sigma: /^1$/ };

/** What the address says; anything that is no state is passed over. */
export function read(hash = location.hash) {
  const said = new URLSearchParams(hash.replace(/^#/, ""));
  const state = {};
  for (const name of NUMBERS) {
    const number = said.has(name) ? Number(said.get(name)) : NaN;
    if (Number.isFinite(number)) state[name] = number;
  }
  for (const [name, pattern] of Object.entries(WORDS)) {
    if (pattern.test(said.get(name) ?? "")) state[name] = said.get(name);
  }
  return state;
}

/** The same as text. */
export function text(state) {
  const said = new URLSearchParams();
  for (const name of ["night", ...NUMBERS, "model", "light", "sigma"]) {
    const value = state[name];
    if (value != null && value !== "" && !(name === "shift" && value === 0)) said.set(name, String(value));
  }
  return "#" + said;
}

let timer = 0;

/** Writes it into the address, not more often than browsers allow. */
export function write(state) {
  clearTimeout(timer);
  timer = setTimeout(() => history.replaceState(null, "", text(state)), 120);
}
