// Chart of the magnitude along one track, with a band of one sigma; brighter is higher.

import { css, theme } from "./colours.js";
import { label, path, prepare, step } from "./canvas.js";
import { hover } from "./hover.js";
import { clock, fixed, moment } from "./words.js";

const MARGIN = { left: 44, right: 14, top: 12, bottom: 34 };

export class Curve {
  constructor(canvas) {
    this.canvas = canvas;
    /** Points of the drawn curve, with their position `x`, CSS pixels. */
    this.points = [];
    hover(canvas, (x) => {
      const point = this.points.reduce((best, one) => (Math.abs(one.x - x) < Math.abs((best?.x ?? Infinity) - x) ? one : best), null);
      return point && `${clock(point.ms, 0, 1)} UTC: ${fixed(point.magnitude, 2)} ± ${fixed(point.magnitude_sigma, 2)} mag`;
    });
  }

  draw(pass, limit) {
    const { context, width, height } = prepare(this.canvas);
    const colours = theme();
    const samples = (pass?.samples ?? []).map((sample) => ({ ...sample, ms: moment(sample.utc) }));
    const lit = samples.filter((sample) => sample.magnitude != null);
    const left = MARGIN.left, right = width - MARGIN.right, top = MARGIN.top, bottom = height - MARGIN.bottom;
    context.fillStyle = colours.dark;
    context.fillRect(left, top, right - left, bottom - top);
    if (!lit.length) {
      const words = pass ? "no magnitude along this track" : "no track selected";
      context.textAlign = "center";
      label(context, words, (left + right) / 2, (top + bottom) / 2, colours.muted, colours.dark);
      this.points = [];
      this.canvas.setAttribute("aria-label", `Light curve: ${words}`);
      return;
    }
    this.canvas.setAttribute("aria-label", `Light curve of ${pass.name || pass.norad_id}`);
    const [from, to] = [samples[0].ms, Math.max(samples[samples.length - 1].ms, samples[0].ms + 200)];
    const ends = lit.flatMap((sample) => [sample.magnitude - sample.magnitude_sigma, sample.magnitude + sample.magnitude_sigma]);
    const [bright, faint] = [Math.min(...ends) - 0.1, Math.max(...ends) + 0.1];
    const x = (ms) => left + ((ms - from) / (to - from)) * (right - left);
    this.points = lit.map((sample) => ({ ...sample, x: x(sample.ms) }));
    const y = (magnitude) => top + ((magnitude - bright) / (faint - bright)) * (bottom - top);

    context.textAlign = "right";
    const rise = step(faint - bright, (bottom - top) / 32, [0.1, 0.2, 0.5, 1, 2, 5]);
    for (let tick = Math.ceil(bright / rise); tick * rise <= faint; tick += 1) {
      const place = y(tick * rise);
      context.fillStyle = colours.line;
      context.fillRect(left, place - 0.5, right - left, 1);
      context.fillStyle = colours.muted;
      context.fillText((tick * rise).toFixed(rise < 1 ? 1 : 0), left - 6, place + 4);
    }
    const seconds = step((to - from) / 1e3, (right - left) / 84, [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 60, 120, 300, 600]);
    context.textAlign = "center";
    for (let tick = Math.ceil(from / 1e3 / seconds); tick * seconds * 1e3 <= to; tick += 1) {
      const place = x(tick * seconds * 1e3);
      context.fillStyle = colours.line;
      context.fillRect(place - 0.5, top, 1, bottom - top);
      context.fillStyle = colours.muted;
      if (place > left + 24 && place < right - 24) context.fillText(clock(tick * seconds * 1e3, 0, seconds < 1 ? 1 : 0), place, bottom + 15);
    }
    context.fillText("UTC", (left + right) / 2, height - 4);

    const upper = lit.map((sample) => [x(sample.ms), y(sample.magnitude - sample.magnitude_sigma)]);
    const lower = lit.map((sample) => [x(sample.ms), y(sample.magnitude + sample.magnitude_sigma)]);
    context.fillStyle = css(pass.magnitude_peak, 0.25);
    path(context, [...upper, ...lower.reverse()]);
    context.fill();
    context.strokeStyle = css(pass.magnitude_peak);
    context.lineWidth = 2.5;
    path(context, samples.map((sample) => (sample.magnitude == null ? null : [x(sample.ms), y(sample.magnitude)])));
    context.stroke();
    if (limit != null && limit > bright && limit < faint) {
      context.strokeStyle = colours.text;
      context.lineWidth = 1;
      context.setLineDash([6, 5]);
      path(context, [[left, y(limit)], [right, y(limit)]]);
      context.stroke();
      context.setLineDash([]);
      context.textAlign = "right";
      label(context, "limit", right - 4, y(limit) - 4, colours.text, colours.dark);
    }
    context.textAlign = "left";
    label(context, "entry", left + 4, bottom - 5, colours.muted, colours.dark);
    context.textAlign = "right";
    label(context, "exit", right - 4, bottom - 5, colours.muted, colours.dark);
  }
}
