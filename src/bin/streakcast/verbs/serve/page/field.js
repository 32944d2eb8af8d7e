// Field on the tangent plane: north up, east left, streaks with times and magnitudes.

import { css, theme } from "./colours.js";
import { label, path, labelSpace, prepare } from "./canvas.js";
import { closest, hover } from "./hover.js";
import { clock, fixed, moment } from "./words.js";

const DEG = Math.PI / 180;

/** Returns the position of a direction on the tangent plane, degrees, east and north of a centre; null behind it. */
function project(ra, dec, centre) {
  const difference = (ra - centre.ra) * DEG;
  const [sin, cos] = [Math.sin(dec * DEG), Math.cos(dec * DEG)];
  const [sin0, cos0] = [Math.sin(centre.dec * DEG), Math.cos(centre.dec * DEG)];
  const depth = sin * sin0 + cos * cos0 * Math.cos(difference);
  if (depth <= 0.01) return null;
  // ξ = cos δ sin Δα / d, η = (sin δ cos δ₀ - cos δ sin δ₀ cos Δα) / d
  return [(cos * Math.sin(difference)) / depth / DEG, (sin * cos0 - cos * sin0 * Math.cos(difference)) / depth / DEG];
}

/** Returns the size of a field in words: the diameter of a circle, width and height of a rectangle. */
export function size(field) {
  if (field.outlines_deg.length > 1) return `${field.outlines_deg.length} shapes`;
  const degrees = (number) => String(Number(number.toFixed(2)));
  const [outline] = field.outlines_deg;
  const [width, height] = [0, 1].map((axis) => Math.max(...outline.map((place) => place[axis])) - Math.min(...outline.map((place) => place[axis])));
  // A circle has many corners.
  return outline.length > 12 ? `${degrees(2 * field.radius_deg)}° across` : `${degrees(width)}° × ${degrees(height)}°`;
}

export class Field {
  constructor(canvas, choose) {
    this.canvas = canvas;
    this.lines = [];
    canvas.addEventListener("click", (event) => {
      const box = canvas.getBoundingClientRect();
      const [x, y] = [event.clientX - box.left, event.clientY - box.top];
      const line = closest(this.lines, x, y, 24);
      if (line) choose(line.norad);
    });
    hover(canvas, (x, y) => {
      const pass = closest(this.lines, x, y, 12)?.pass;
      const at = (end) => clock(moment(pass[`${end}_utc`]), 0, 1);
      return pass && `${pass.name || pass.norad_id}: ${fixed(pass.magnitude_peak, 1)} ± ${fixed(pass.magnitude_peak_sigma, 1)} mag, ${at("enter")} to ${at("exit")} UTC`;
    });
  }

  /** Draws the field of the night, the exposure and its passes; `exposure` and `passes` may be undefined. */
  draw(field, exposure, passes, { selected, corridors }) {
    const { context, width, height } = prepare(this.canvas);
    const colours = theme();
    const reach = Math.tan(Math.min(80, field.radius_deg) * DEG) / DEG;
    const scale = Math.min(width, height) / 2 / (reach * 1.22);
    const centre = { ra: exposure?.ra_deg, dec: exposure?.dec_deg };
    const rotation = (exposure?.rotation_deg ?? 0) * DEG;
    // East is left.
    const at = (place) => place && [width / 2 - place[0] * scale, height / 2 - place[1] * scale];
    context.fillStyle = colours.dark;
    context.fillRect(0, 0, width, height);

    const [sin, cos] = [Math.sin(rotation), Math.cos(rotation)];
    context.strokeStyle = colours.muted;
    context.lineWidth = 1.5;
    for (const outline of field.outlines_deg) {
      // The field's y axis is at the position angle of the rotation, from north through east.
      const points = outline.map(([x, y]) => at([x * cos + y * sin, y * cos - x * sin]));
      path(context, [...points, points[0]]);
      context.stroke();
    }
    this.compass(context, width, height, colours);
    this.ruler(context, height, scale, reach, colours);

    this.lines = (passes ?? []).map((pass) => {
      const samples = pass.samples?.length ? pass.samples : ["enter", "mid", "exit"].map((end) => ({ ra_deg: pass[`${end}_ra_deg`], dec_deg: pass[`${end}_dec_deg`] }));
      return { pass, norad: pass.norad_id, points: samples.map((sample) => at(project(sample.ra_deg, sample.dec_deg, centre))) };
    });
    if (corridors) {
      for (const line of this.lines) {
        context.lineCap = "butt";
        context.lineWidth = Math.max(1, 2 * line.pass.cross_track_sigma_deg * scale);
        context.strokeStyle = css(line.pass.magnitude_peak, 0.28);
        path(context, line.points);
        context.stroke();
      }
    }
    context.lineCap = "round";
    for (const line of this.lines) {
      const isChosen = line.norad === selected;
      context.lineWidth = isChosen ? 4 : 2.5;
      context.strokeStyle = css(line.pass.magnitude_peak);
      path(context, line.points);
      context.stroke();
      this.arrow(context, line.points);
    }
    const isFree = labelSpace();
    const byBrightness = [...this.lines].sort((a, b) => (b.norad === selected) - (a.norad === selected) || (a.pass.magnitude_peak ?? 99) - (b.pass.magnitude_peak ?? 99));
    for (const line of byBrightness) this.words(context, line, isFree, width, colours, line.norad === selected);
    if (!this.lines.length) {
      context.textAlign = "center";
      label(context, passes ? "no lit satellite crosses" : "no result", width / 2, height / 2, colours.muted, colours.dark);
    }
    this.canvas.setAttribute("aria-label", `Field chart, ${this.lines.length} tracks`);
  }

  words(context, line, isFree, width, colours, isChosen) {
    const ends = [line.points.find(Boolean), line.points.findLast(Boolean)];
    const { pass } = line;
    const texts = [`${clock(moment(pass.enter_utc), 0, 1)}`, `${clock(moment(pass.exit_utc), 0, 1)} · ${fixed(pass.magnitude_peak, 1)} mag`];
    ends.forEach((end, which) => {
      if (!end) return;
      const isLeft = end[0] > width / 2;
      context.textAlign = isLeft ? "right" : "left";
      const x = Math.min(width - 4, Math.max(4, end[0] + (isLeft ? -7 : 7)));
      const y = Math.max(14, end[1] + (which ? 14 : -6));
      if (isFree(context, texts[which], x, y)) label(context, texts[which], x, y, isChosen ? colours.mark : colours.text, colours.dark);
    });
  }

  arrow(context, points) {
    const seen = points.filter(Boolean);
    if (seen.length < 2) return;
    const [tip, before] = [seen[seen.length - 1], seen[Math.max(0, seen.length - 3)]];
    const angle = Math.atan2(tip[1] - before[1], tip[0] - before[0]);
    path(context, [2.6, -2.6].flatMap((turn) => [[tip[0] + 9 * Math.cos(angle + turn), tip[1] + 9 * Math.sin(angle + turn)], tip, null]));
    context.stroke();
  }

  compass(context, width, height, colours) {
    const [x, y, long] = [width - 24, height - 22, 30];
    context.strokeStyle = context.fillStyle = colours.muted;
    context.lineWidth = 1.5;
    path(context, [[x, y - long], [x, y], [x - long, y]]);
    context.stroke();
    context.textAlign = "center";
    context.fillText("N", x, y - long - 4);
    context.fillText("E", x - long - 8, y + 4);
  }

  ruler(context, height, scale, reach, colours) {
    const length = [10, 5, 2, 1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01].find((one) => one < reach * 0.7) ?? 0.005;
    context.strokeStyle = context.fillStyle = colours.muted;
    context.lineWidth = 1.5;
    path(context, [[14, height - 22], [14 + length * scale, height - 22]]);
    context.stroke();
    context.textAlign = "left";
    context.fillText(length >= 1 ? `${length}°` : `${Math.round(length * 60 * 10) / 10}′`, 14, height - 8);
  }
}
