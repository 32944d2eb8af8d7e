// Colours of magnitudes: viridis, and shades of red under red light. In both scales, brighter satellites have lighter
// colours.

const VIRIDIS = ["#440154", "#482475", "#414487", "#355f8d", "#2a788e", "#21918c", "#22a884", "#44bf70", "#7ad151", "#bddf26", "#fde725"];
const RED = ["#2a0000", "#480400", "#640a02", "#801206", "#9c1c0c", "#b82a16", "#d03c24", "#e45034", "#f26a4c", "#fb8a6c", "#ffb09a"];

/** Brightest and faintest magnitude of the colour scale. */
export const BRIGHT = 3;
export const FAINT = 10;

const channels = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
const RAMPS = { dark: VIRIDIS.map(channels), red: RED.map(channels) };

export const isRed = () => document.documentElement.dataset.light === "red";

/** Returns red, green and blue of a magnitude, 0 to 255. */
export function ofMagnitude(magnitude) {
  const ramp = isRed() ? RAMPS.red : RAMPS.dark;
  const share = Math.min(1, Math.max(0, (FAINT - magnitude) / (FAINT - BRIGHT)));
  // The darkest colours are reserved for the background.
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

let known = null;

/** Returns the colours of the style sheet by name. */
export function theme() {
  if (known) return known;
  const style = getComputedStyle(document.documentElement);
  const names = ["ground", "panel", "line", "text", "muted", "mark", "good", "day", "civil", "nautical", "astronomical", "dark", "shadow"];
  known = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  return known;
}

/** Switches red light on or off. */
export function light(red) {
  if (red) document.documentElement.dataset.light = "red";
  else delete document.documentElement.dataset.light;
  known = null;
}
