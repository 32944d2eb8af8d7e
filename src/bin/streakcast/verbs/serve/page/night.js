// Night chart: exposures as bars over the bands of twilight, UTC below and local time above.

import { css, scheme, theme, BRIGHT, FAINT, ofMagnitude } from "./colours.js";
import { Backdrop, label, prepare, step } from "./canvas.js";
import { hover } from "./hover.js";
import { clock, fixed, hour, moment, offsetAt, zones } from "./words.js";

const MARGIN = { left: 6, right: 6, top: 20, bottom: 20 };
const HOUR = 3600e3;

/** Bands of the Sun's altitude, from day to night. */
const BANDS = [
  [0, "day", "day"],
  [-6, "civil", "civil"],
  [-12, "nautical", "nautical"],
  [-18, "astronomical", "astronomical"],
  [-Infinity, "dark", "night"],
];

/** Heights of bars by verdict, in addition to their colours. */
const HEIGHTS = { clear: 0.3, streaked: 0.65, avoid: 1, unknown: 0.15, invalid: 0.15 };

export class Night {
  constructor(canvas, choose) {
    this.canvas = canvas;
    this.choose = choose;
    this.bars = [];
    this.backdrop = new Backdrop();
    const nearest = (x) => this.bars.reduce((best, bar) => (Math.abs(bar.x - x) < Math.abs(best.x - x) ? bar : best), { x: Infinity });
    canvas.addEventListener("click", (event) => {
      const { place } = nearest(event.clientX - canvas.getBoundingClientRect().left);
      if (place != null) choose(place);
    });
    hover(canvas, (x) => {
      const bar = nearest(x);
      const row = Math.abs(bar.x - x) < 12 ? this.rows[bar.place] : null;
      if (!row) return this.describe(x);
      const bright = row.flag.brightest_mag;
      return `${row.id}: ${row.flag.verdict}${bright == null ? "" : `, ${fixed(bright, 1)} mag`}, ${clock(row.start)} UTC`;
    });
    canvas.addEventListener("keydown", (event) => {
      const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageUp: -10, PageDown: 10, Home: -1e9, End: 1e9 };
      if (!(event.key in steps)) return;
      event.preventDefault();
      choose(Math.min(this.rows.length - 1, Math.max(0, this.selected + steps[event.key])));
    });
  }

  /** Returns time and altitude of the Sun at a position, CSS pixels; nothing beside the chart. */
  describe(x) {
    const share = (x - MARGIN.left) / (this.canvas.getBoundingClientRect().width - MARGIN.left - MARGIN.right);
    if (share < 0 || share > 1) return "";
    const ms = this.from + share * (this.to - this.from);
    return `${hour(ms)} UTC, ${hour(ms, offsetAt(this.night.utc_offsets, ms))} local, Sun ${fixed(this.sunAltitude(ms), 0)}°`;
  }

  /** Shows a night; `rows` are exposures with their flags, which are null for those that are not in the schedule. */
  show(night, rows) {
    this.night = night;
    this.rows = rows;
    const sun = night.sun.map((place) => [moment(place.utc), place.sun_altitude_deg]);
    const times = rows.filter((row) => row.start != null).flatMap((row) => [row.start, row.start + row.duration_s * 1e3]);
    const down = sun.filter(([, altitude]) => altitude < 2).map(([ms]) => ms);
    this.sun = sun;
    // The part of the night with dusk, dawn and all exposures; the whole day if the Sun does not set.
    const all = down.length ? down : sun.map(([ms]) => ms);
    this.from = Math.min(...times, all[0]) - 10 * 60e3;
    this.to = Math.max(...times, all.at(-1)) + 10 * 60e3;
  }

  draw(selected, start) {
    this.selected = selected;
    const { context, width, height } = prepare(this.canvas);
    const colours = theme();
    const left = MARGIN.left, right = width - MARGIN.right, top = MARGIN.top, bottom = height - MARGIN.bottom;
    const at = (ms) => left + ((ms - this.from) / (this.to - this.from)) * (right - left);
    this.backdrop.show(context, [this.night, this.rows, scheme()], (behind) => {
      for (let x = left; x < right; x += 1) {
        behind.fillStyle = colours[this.band(this.from + ((x - left) / (right - left)) * (this.to - this.from))];
        behind.fillRect(x, top, 1.5, bottom - top);
      }
      this.axis(behind, at, (right - left) / 62, top, bottom, colours);
      this.exposures(behind, at, top, bottom, colours);
    });
    const chosen = this.rows[selected];
    if (chosen?.start != null) {
      const x = at(start ?? chosen.start);
      context.strokeStyle = colours.mark;
      context.fillStyle = colours.mark;
      context.lineWidth = 2;
      context.beginPath();
      context.moveTo(x, top);
      context.lineTo(x, bottom);
      context.stroke();
      context.beginPath();
      context.moveTo(x - 6, top - 1);
      context.lineTo(x + 6, top - 1);
      context.lineTo(x, top + 8);
      context.fill();
    }
    this.state(chosen, selected);
  }

  exposures(context, at, top, bottom, colours) {
    this.bars = [];
    const full = bottom - top - 4;
    this.rows.forEach((row, place) => {
      const flag = row.flag;
      if (row.start == null || !flag) return;
      const x = at(row.start);
      const wide = Math.max(2, at(row.start + row.duration_s * 1e3) - x);
      const tall = full * (HEIGHTS[flag.verdict] ?? 0.15);
      const isMuted = ["clear", "unknown", "invalid"].includes(flag.verdict);
      context.fillStyle = isMuted ? colours.muted : css(flag.brightest_mag);
      context.globalAlpha = isMuted ? 0.55 : 1;
      context.fillRect(x, bottom - tall, wide, tall);
      context.globalAlpha = 1;
      this.bars.push({ x: x + wide / 2, place });
    });
  }

  axis(context, at, count, top, bottom, colours) {
    const every = step((this.to - this.from) / HOUR, count, [0.25, 0.5, 1, 2, 3, 6]) * HOUR;
    const offsets = this.night.utc_offsets;
    context.textAlign = "center";
    context.font = "11px system-ui, sans-serif";
    for (let ms = Math.ceil(this.from / every) * every; ms <= this.to; ms += every) {
      const x = at(ms);
      context.fillStyle = colours.line;
      context.fillRect(x - 0.5, top, 1, bottom - top);
      if (x < 18 || x > at(this.to) - 18) continue;
      context.fillStyle = colours.muted;
      context.fillText(hour(ms), x, bottom + 14);
      context.fillText(hour(ms, offsetAt(offsets, ms)), x, top - 7);
    }
    context.textAlign = "left";
    label(context, "UTC", at(this.from) + 2, bottom - 4, colours.muted, colours.dark);
    label(context, `local, ${zones(offsets)}`, at(this.from) + 2, top + 12, colours.muted, colours.dark);
  }

  /** Returns the altitude of the Sun, degrees. */
  sunAltitude(ms) {
    let before = this.sun[0];
    for (const place of this.sun) {
      if (place[0] > ms) return before[1] + ((place[1] - before[1]) * (ms - before[0])) / (place[0] - before[0] || 1);
      before = place;
    }
    return before[1];
  }

  band(ms) {
    const altitude = this.sunAltitude(ms);
    return BANDS.find(([least]) => altitude >= least)[1];
  }

  /** States the selected exposure for screen readers. */
  state(row, selected) {
    const words = row && [row.id, `${selected + 1} of ${this.rows.length}`, row.flag?.verdict, row.start == null ? "" : `${hour(row.start)} UTC`];
    this.canvas.setAttribute("aria-valuemax", this.rows.length);
    this.canvas.setAttribute("aria-valuenow", row ? selected + 1 : 0);
    this.canvas.setAttribute("aria-valuetext", words ? words.filter(Boolean).join(", ") : "none");
  }
}

/** Draws the colour bar of magnitudes and the names of the bands below the chart. */
export function legend(scale, bands) {
  const bar = document.createElement("canvas");
  const faint = document.createElement("span");
  const bright = document.createElement("span");
  faint.textContent = `mag ${FAINT}`;
  bright.textContent = String(BRIGHT);
  const heights = document.createElement("span");
  heights.className = "wrap";
  heights.textContent = "high bars: avoid, half-high: streaked, low: clear";
  scale.replaceChildren(faint, bar, bright, heights);
  const { context, width, height } = prepare(bar);
  for (let x = 0; x < width; x += 1) {
    const [red, green, blue] = ofMagnitude(FAINT - ((FAINT - BRIGHT) * x) / width);
    context.fillStyle = `rgb(${red} ${green} ${blue})`;
    context.fillRect(x, 0, 1.5, height);
  }
  bands.replaceChildren(
    document.createTextNode("Sun: "),
    ...BANDS.flatMap(([, name, words]) => {
      const swatch = document.createElement("i");
      swatch.style.background = theme()[name];
      return [swatch, document.createTextNode(words)];
    }),
  );
}
