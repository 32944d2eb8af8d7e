// Sky over the site: zenith in the centre, north up, east left.

import { css, ofMagnitude, scheme, theme } from "./colours.js";
import { between, contour } from "./contours.js";
import { Backdrop, label, path, prepare } from "./canvas.js";
import { closest, hover } from "./hover.js";
import { fixed } from "./words.js";

const DEG = Math.PI / 180;
/** Size of the magnitude map, pixels. It is drawn enlarged, because it is smooth. */
const FINE = 220;
/** Number of grid cells by which the map is extrapolated into the shadow. The shadow is drawn over them, so that the map has a smooth edge. */
const BEYOND = 3;

/** Returns the grid with gaps filled from neighbouring cells. */
function filled(rows) {
  let values = rows;
  for (let turn = 0; turn < BEYOND; turn += 1) {
    const before = values;
    values = before.map((row, y) =>
      row.map((value, x) => {
        if (value != null) return value;
        const beside = [row[(x + 1) % row.length], row.at(x - 1), before[y - 1]?.[x], before[y + 1]?.[x]].filter((one) => one != null);
        return beside.length ? beside.reduce((sum, one) => sum + one, 0) / beside.length : null;
      }),
    );
  }
  return values;
}

export class Dome {
  constructor(canvas) {
    this.canvas = canvas;
    this.backdrop = new Backdrop();
    /** Satellites with their tracks, CSS pixels. */
    this.lines = [];
    hover(canvas, (x, y) => {
      const one = this.dome && closest(this.lines, x, y, 12)?.satellite;
      if (!one) return "";
      const [azimuth, altitude] = one.track_deg.at(-1);
      return `${one.name || one.norad_id}: ${fixed(one.magnitude, 1)} ± ${fixed(one.magnitude_sigma, 1)} mag, altitude ${fixed(altitude, 0)}°, azimuth ${fixed(azimuth, 0)}°`;
    });
  }

  /** Shows a response of the server; null clears the chart. */
  show(dome) {
    this.dome = dome;
    if (!dome) return;
    // Azimuths are periodic: the first column is repeated after the last.
    this.isZenithDark = dome.map.magnitudes.at(-1)[0] == null;
    this.values = filled(dome.map.magnitudes).map((row) => [...row, row[0]]);
    this.image = null;
  }

  /** Draws the sky; `background` adds the map of magnitudes and the Earth's shadow. */
  draw({ pointing, selected, passes, limit, background }) {
    const { context, width, height } = prepare(this.canvas);
    const colours = theme();
    const radius = Math.min(width, height) / 2 - 26;
    // The window is very narrow, or the page is hidden.
    if (radius <= 0) return;
    const [x0, y0] = [width / 2, height / 2];
    const at = (azimuth, altitude) => {
      const reach = ((90 - altitude) / 90) * radius;
      return [x0 - reach * Math.sin(azimuth * DEG), y0 - reach * Math.cos(azimuth * DEG)];
    };
    const up = ([azimuth, altitude]) => (altitude >= 0 ? at(azimuth, altitude) : null);
    this.backdrop.show(context, [this.dome, limit, selected, background, scheme()], (behind) => {
      behind.save();
      behind.beginPath();
      behind.arc(x0, y0, radius, 0, 2 * Math.PI);
      behind.fillStyle = colours.shadow;
      behind.fill();
      behind.clip();
      if (this.dome && background) {
        behind.drawImage(this.map(), x0 - radius, y0 - radius, 2 * radius, 2 * radius);
        this.contours(behind, at, colours);
        this.shadow(behind, at, x0, y0, radius, colours);
      }
      behind.restore();
      this.grid(behind, x0, y0, radius, at, colours);
      if (this.dome) {
        this.tracks(behind, up, limit, selected, colours);
        this.sun(behind, x0, y0, radius, colours);
      }
    });
    for (const pass of passes ?? []) {
      if (pass.norad_id !== selected || !pass.samples) continue;
      context.lineWidth = 4;
      context.strokeStyle = colours.mark;
      path(context, pass.samples.map((sample) => up([sample.azimuth_deg, sample.altitude_deg])));
      context.stroke();
    }
    if (pointing && pointing.altitude_deg > 0) {
      const [x, y] = at(pointing.azimuth_deg, pointing.altitude_deg);
      context.strokeStyle = colours.ground;
      context.lineWidth = 5;
      context.beginPath();
      context.arc(x, y, 8, 0, 2 * Math.PI);
      context.stroke();
      context.strokeStyle = colours.mark;
      context.lineWidth = 2.5;
      context.stroke();
    }
  }

  /** Returns the picture of the model's magnitudes, drawn once per response and colour scheme. */
  map() {
    const light = scheme();
    if (this.image && this.image.light === light) return this.image;
    const image = document.createElement("canvas");
    image.width = image.height = FINE;
    image.light = light;
    const context = image.getContext("2d");
    const pixels = context.createImageData(FINE, FINE);
    const step = this.dome.map.step_deg;
    for (let row = 0; row < FINE; row += 1) {
      for (let column = 0; column < FINE; column += 1) {
        const [east, north] = [1 - (2 * (column + 0.5)) / FINE, 1 - (2 * (row + 0.5)) / FINE];
        const altitude = 90 - 90 * Math.hypot(east, north);
        if (altitude < -2) continue;
        const azimuth = (Math.atan2(east, north) / DEG + 360) % 360;
        const magnitude = between(this.values, azimuth / step, Math.max(0, altitude) / step);
        if (magnitude == null) continue;
        const [red, green, blue] = ofMagnitude(magnitude);
        pixels.data.set([red, green, blue, 120], 4 * (row * FINE + column));
      }
    }
    context.putImageData(pixels, 0, 0);
    this.image = image;
    return image;
  }

  contours(context, at, colours) {
    const step = this.dome.map.step_deg;
    const numbers = this.values.flat().filter((value) => value != null);
    const [least, greatest] = [Math.min(...numbers), Math.max(...numbers)];
    for (let level = Math.ceil(least); level <= greatest; level += 1) {
      const segments = contour(this.values, level).map((ends) => ends.map(([x, y]) => at(x * step, y * step)));
      context.strokeStyle = css(level);
      context.lineWidth = 1.2;
      path(context, segments.flatMap((ends) => [...ends, null]));
      context.stroke();
      const place = segments[Math.floor(segments.length / 2)]?.[0];
      if (place && segments.length > 3) {
        context.textAlign = "center";
        label(context, String(level), place[0], place[1] + 4, colours.text, colours.shadow);
      }
    }
  }

  /** Draws the Earth's shadow dark, with a dashed edge. */
  shadow(context, at, x0, y0, radius, colours) {
    const edge = this.dome.shadow_edge_deg;
    const outline = new Path2D();
    edge.forEach((point, place) => outline[place ? "lineTo" : "moveTo"](...at(...point)));
    outline.closePath();
    // The zenith determines whether the inside or the outside of the line is dark.
    const area = new Path2D(outline);
    const isInside = edge.length > 0 && context.isPointInPath(outline, x0 * (window.devicePixelRatio || 1), y0 * (window.devicePixelRatio || 1));
    if (isInside !== this.isZenithDark) area.rect(x0 - 3 * radius, y0 - 3 * radius, 6 * radius, 6 * radius);
    context.fillStyle = colours.shadow;
    context.fill(area, "evenodd");
    context.strokeStyle = colours.text;
    context.lineWidth = 2;
    context.setLineDash([8, 5]);
    context.stroke(outline);
    context.setLineDash([]);
    const highest = edge.reduce((best, point) => (point[1] > (best?.[1] ?? -90) ? point : best), null);
    if (highest?.[1] > 3) {
      const [x, y] = at(...highest);
      context.textAlign = "center";
      label(context, "shadow", Math.min(x0 + radius - 40, Math.max(x0 - radius + 40, x)), y - 6, colours.text, colours.shadow);
    }
  }

  grid(context, x0, y0, radius, at, colours) {
    context.strokeStyle = colours.line;
    context.lineWidth = 1;
    for (const altitude of [0, 30, 60]) {
      context.beginPath();
      context.arc(x0, y0, ((90 - altitude) / 90) * radius, 0, 2 * Math.PI);
      context.stroke();
      if (altitude) {
        context.textAlign = "left";
        label(context, `${altitude}°`, ...at(215, altitude), colours.muted, colours.shadow);
      }
    }
    context.fillStyle = colours.muted;
    context.textAlign = "center";
    for (const [name, azimuth] of [["N", 0], ["E", 90], ["S", 180], ["W", 270]]) {
      const [x, y] = [x0 - (radius + 13) * Math.sin(azimuth * DEG), y0 - (radius + 13) * Math.cos(azimuth * DEG)];
      context.fillText(name, x, y + 4);
    }
  }

  /** Draws satellites that are brighter than the limit as tracks, and the others as dots; without a limit all as tracks. */
  tracks(context, up, limit, selected, colours) {
    this.lines = this.dome.satellites.map((satellite) => {
      const isBright = limit == null || (satellite.magnitude != null && satellite.magnitude < limit) || satellite.norad_id === selected;
      const points = satellite.track_deg.map(up);
      return { satellite, isBright, points: isBright ? points : [points.findLast(Boolean)] };
    });
    // Hundreds of tracks are drawn thin.
    const isCrowded = this.lines.filter((line) => line.isBright).length > 300;
    // Tracks are drawn over dots.
    for (const { satellite, isBright, points } of this.lines.toSorted((a, b) => a.isBright - b.isBright)) {
      const isChosen = satellite.norad_id === selected;
      context.globalAlpha = isChosen ? 1 : isBright ? (isCrowded ? 0.8 : 1) : 0.6;
      context.strokeStyle = context.fillStyle = isChosen ? colours.mark : css(satellite.magnitude);
      context.lineWidth = isChosen ? 4 : isCrowded ? 1.3 : 2.2;
      path(context, points);
      context.stroke();
      const head = points.findLast(Boolean);
      if (head) {
        context.beginPath();
        context.arc(...head, isBright ? 2.6 : 1.4, 0, 2 * Math.PI);
        context.fill();
      }
    }
    context.globalAlpha = 1;
  }

  sun(context, x0, y0, radius, colours) {
    const { azimuth_deg: azimuth } = this.dome.sun;
    const [sin, cos] = [Math.sin(azimuth * DEG), Math.cos(azimuth * DEG)];
    const [x, y] = [x0 - (radius + 12) * sin, y0 - (radius + 12) * cos];
    context.fillStyle = context.strokeStyle = colours.mark;
    context.lineWidth = 1.5;
    context.beginPath();
    context.arc(x, y, 6, 0, 2 * Math.PI);
    context.stroke();
    context.beginPath();
    context.arc(x, y, 1.8, 0, 2 * Math.PI);
    context.fill();
    path(context, [[x0 - radius * sin, y0 - radius * cos], [x0 - (radius - 10) * sin, y0 - (radius - 10) * cos]]);
    context.stroke();
  }
}
