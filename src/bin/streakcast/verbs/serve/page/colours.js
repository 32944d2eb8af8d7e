// Colours of magnitudes: viridis, shades of red under red light, and the dark half of viridis on paper. Brighter satellites
// have the colours that contrast most with the ground.

const VIRIDIS = ["#440154", "#482475", "#414487", "#355f8d", "#2a788e", "#21918c", "#22a884", "#44bf70", "#7ad151", "#bddf26", "#fde725"];
const RED = ["#2a0000", "#480400", "#640a02", "#801206", "#9c1c0c", "#b82a16", "#d03c24", "#e45034", "#f26a4c", "#fb8a6c", "#ffb09a"];
const PAPER = VIRIDIS.slice(0, 8).reverse();

/** Brightest and faintest magnitude of the colour scale. */
export const BRIGHT = 3;
export const FAINT = 10;

const channels = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
const RAMPS = { dark: VIRIDIS.map(channels), red: RED.map(channels), paper: PAPER.map(channels) };

const isPrinted = matchMedia("print");
const isForced = matchMedia("(forced-colors: active)");

/**
 * Returns the colour scheme of the charts: dark, red, or paper (in print, and if the colours of the system have a light
 * ground).
 */
export function scheme() {
  if (knownScheme) return knownScheme;
  if (isPrinted.matches) knownScheme = "paper";
  else if (isForced.matches) knownScheme = isLight(theme().ground) ? "paper" : "dark";
  else knownScheme = document.documentElement.dataset.light === "red" ? "red" : "dark";
  return knownScheme;
}

/** Calls `change` when the page is printed or shown on the screen again, and when the colours of the system change. */
export function onScheme(change) {
  const changed = () => {
    known = knownScheme = null;
    change();
  };
  for (const query of [isPrinted, isForced]) query.addEventListener("change", changed);
}

/** Returns red, green and blue of a magnitude, 0 to 255. */
export function ofMagnitude(magnitude) {
  const ramp = RAMPS[scheme()];
  const share = Math.min(1, Math.max(0, (FAINT - magnitude) / (FAINT - BRIGHT)));
  // The colours with the least contrast are reserved for the background.
  const place = (0.18 + 0.82 * share) * (ramp.length - 1);
  const below = Math.min(ramp.length - 2, Math.floor(place));
  return ramp[below].map((low, channel) => low + (ramp[below + 1][channel] - low) * (place - below));
}

/** Returns the CSS colour of a magnitude; a neutral colour without a magnitude. */
export function css(magnitude, alpha = 1) {
  if (magnitude == null) return theme().muted;
  const [red, green, blue] = ofMagnitude(magnitude).map(Math.round);
  return `rgb(${red} ${green} ${blue} / ${alpha})`;
}

/** Colours and scheme, computed once, because a chart needs them for each of its parts. */
let known = null;
let knownScheme = null;

/** Returns the colours of the style sheet by name, as rgb(). */
export function theme() {
  if (known) return known;
  // The colours of an element are resolved, also those that the system defines.
  const probe = document.createElement("i");
  document.body.append(probe);
  const resolved = (name) => {
    probe.style.color = `var(--${name})`;
    return getComputedStyle(probe).color;
  };
  const names = ["ground", "panel", "line", "text", "muted", "mark", "good", "day", "civil", "nautical", "astronomical", "dark", "shadow"];
  known = Object.fromEntries(names.map((name) => [name, resolved(name)]));
  probe.remove();
  return known;
}

/** Returns whether a colour rgb() is light. */
const isLight = (colour) => colour.match(/[\d.]+/g).slice(0, 3).reduce((sum, channel) => sum + Number(channel), 0) > 384;

/** Switches red light on or off. */
export function light(red) {
  if (red) document.documentElement.dataset.light = "red";
  else delete document.documentElement.dataset.light;
  known = knownScheme = null;
}
