// Night chart: exposures as bars over the bands of twilight, UTC below and local time above.

import { css, isRed, theme, BRIGHT, FAINT, ofMagnitude } from "./colours.js";
import { Backdrop, label, prepare, step } from "./canvas.js";
import { hour, moment, zone } from "./words.js";

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
const HEIGHTS = { clear: 0.3, streaked: 0.65, avoid: 1, invalid: 0.15 };

export class Night {
  constructor(canvas, choose) {
    this.canvas = canvas;
    this.choose = choose;
    this.bars = [];
    this.backdrop = new Backdrop();
    const nearest = (event) => {
      const x = event.clientX - canvas.getBoundingClientRect().left;
      return this.bars.reduce((best, bar) => (Math.abs(bar.x - x) < Math.abs(best.x - x) ? bar : best), { x: Infinity }).place;
    };
    canvas.addEventListener("click", (event) => {
      const place = nearest(event);
      if (place != null) choose(place);
    });
    canvas.addEventListener("pointermove", (event) => {
      const place = nearest(event);
      const row = this.rows?.[place];
      const bright = row?.flag.brightest_mag;
      canvas.title = row ? `${row.id}: ${row.flag.verdict}${bright == null ? "" : `, ${bright.toFixed(1)} mag`}, ${hour(row.start)} UTC` : "";
    });
    canvas.addEventListener("keydown", (event) => {
      const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageUp: -10, PageDown: 10, Home: -1e9, End: 1e9 };
      if (!(event.key in steps)) return;
      event.preventDefault();
      choose(Math.min(this.rows.length - 1, Math.max(0, this.selected + steps[event.key])));
    });
  }

  /** Shows a night; `rows` are exposures with their flags. */
  show(night, rows) {
    this.night = night;
    this.rows = rows;
    const sun = night.sun.map((place) => [moment(place.utc), place.sun_altitude_deg]);
    const times = rows.filter((row) => row.start != null).flatMap((row) => [row.start, row.start + row.duration_s * 1e3]);
    const down = sun.filter(([, altitude]) => altitude < 2).map(([ms]) => ms);
    this.sun = sun;
    // The part of the night with dusk, dawn and all exposures.
    this.from = Math.min(...times, ...down.slice(0, 1)) - 10 * 60e3;
    this.to = Math.max(...times, ...down.slice(-1)) + 10 * 60e3;
  }

  draw(selected, start, limit) {
    this.selected = selected;
    const { context, width, height } = prepare(this.canvas);
    const colours = theme();
    const left = MARGIN.left, right = width - MARGIN.right, top = MARGIN.top, bottom = height - MARGIN.bottom;
    const at = (ms) => left + ((ms - this.from) / (this.to - this.from)) * (right - left);
    this.backdrop.show(context, [this.night, this.rows, limit, isRed()], (behind) => {
      for (let x = left; x < right; x += 1) {
        behind.fillStyle = colours[this.band(this.from + ((x - left) / (right - left)) * (this.to - this.from))];
        behind.fillRect(x, top, 1.5, bottom - top);
      }
      this.axis(behind, at, (right - left) / 62, top, bottom, colours);
      this.exposures(behind, at, top, bottom, limit, colours);
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
    this.describe(chosen, selected);
  }

  exposures(context, at, top, bottom, limit, colours) {
    this.bars = [];
    const full = bottom - top - 8;
    this.rows.forEach((row, place) => {
      if (row.start == null) return;
      const flag = row.flag;
      const x = at(row.start);
      const wide = Math.max(2, at(row.start + row.duration_s * 1e3) - x);
      const tall = full * (HEIGHTS[flag.verdict] ?? 0.15);
      const isOver = limit != null && flag.brightest_mag != null && flag.brightest_mag < limit;
      context.fillStyle = flag.verdict === "clear" || flag.verdict === "invalid" ? colours.muted : css(flag.brightest_mag);
      context.globalAlpha = flag.verdict === "clear" || flag.verdict === "invalid" ? 0.55 : 1;
      context.fillRect(x, bottom - tall, wide, tall);
      context.globalAlpha = 1;
      if (isOver) {
        context.fillStyle = colours.text;
        context.fillRect(x, bottom - tall - 4, Math.max(2, wide), 2);
      }
      this.bars.push({ x: x + wide / 2, place });
    });
  }

  axis(context, at, count, top, bottom, colours) {
    const every = step((this.to - this.from) / HOUR, count, [0.25, 0.5, 1, 2, 3, 6]) * HOUR;
    const offset = this.night.utc_offset_h;
    context.textAlign = "center";
    context.font = "11px system-ui, sans-serif";
    for (let ms = Math.ceil(this.from / every) * every; ms <= this.to; ms += every) {
      const x = at(ms);
      context.fillStyle = colours.line;
      context.fillRect(x - 0.5, top, 1, bottom - top);
      if (x < 18 || x > at(this.to) - 18) continue;
      context.fillStyle = colours.muted;
      context.fillText(hour(ms), x, bottom + 14);
      context.fillText(hour(ms, offset), x, top - 7);
    }
    context.textAlign = "left";
    label(context, "UTC", at(this.from) + 2, bottom - 4, colours.muted, colours.dark);
    label(context, `local, ${zone(offset)}`, at(this.from) + 2, top + 12, colours.muted, colours.dark);
  }

  band(ms) {
    let before = this.sun[0];
    for (const place of this.sun) {
      if (place[0] > ms) {
        const altitude = before[1] + ((place[1] - before[1]) * (ms - before[0])) / (place[0] - before[0] || 1);
        return BANDS.find(([least]) => altitude >= least)[1];
      }
      before = place;
    }
    return BANDS.find(([least]) => before[1] >= least)[1];
  }

  describe(row, selected) {
    const words = row ? `${row.id}, ${selected + 1} of ${this.rows.length}, ${row.flag.verdict}${row.start == null ? "" : ", " + hour(row.start) + " UTC"}` : "none";
    this.canvas.setAttribute("aria-valuemax", this.rows.length);
    this.canvas.setAttribute("aria-valuenow", selected + 1);
    this.canvas.setAttribute("aria-valuetext", words);
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
  heights.textContent = "high bars: avoid, half-high: streaked, low: clear; tick: brighter than the limit";
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
