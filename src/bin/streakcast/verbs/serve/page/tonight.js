// Panel of tonight's visible passes, each with its track on the sky, a countdown to its beginning and a calendar file.

import { css, theme } from "./colours.js";
import { path, prepare } from "./canvas.js";
import { fixed, known, moment, offsetAt, save, span } from "./words.js";

const DEG = Math.PI / 180;
/** Number of passes that are shown at first, and with each click on the button for more. */
const STEP = 12;
const COMPASS = ["N", "NE", "E", "SE", "S", "SW", "W", "NW"];
const ENDS = { set: "sets", shadow: "enters the Earth's shadow", dawn: "ends at dawn", end: "ends at the end of the night" };

const compass = (azimuth) => COMPASS[Math.round(azimuth / 45) % 8];

/** Creates an element with a text, and a class if one is given. */
function element(name, text, style = "") {
  const one = document.createElement(name);
  one.textContent = text;
  if (style) one.className = style;
  return one;
}

export class Tonight {
  /** `list` takes the passes, `more` is the button that shows more of them. */
  constructor(list, more) {
    this.list = list;
    this.more = more;
    this.cards = [];
    more.addEventListener("click", () => {
      const shown = this.cards.length;
      this.count += STEP;
      this.fill();
      this.cards[shown]?.item.querySelector("button").focus();
    });
  }

  /** Shows a forecast of the server. */
  show(forecast) {
    // The events of the calendar are those of the visible passes, in the same order.
    const [head, ...events] = (forecast.calendar ?? "").split(/(?=^BEGIN:VEVENT\r?$)/m);
    this.calendar = forecast.calendar;
    this.passes = forecast.passes
      .filter((pass) => pass.begin_utc)
      .map((pass, place) => ({ ...pass, begin: moment(pass.begin_utc), end: moment(pass.end_utc), calendar: `${head}${events[place]?.replace(/END:VCALENDAR\s*$/, "")}END:VCALENDAR\r\n` }));
    this.night = forecast.date;
    // End of darkness, after which the night is over at some time.
    this.until = moment(forecast.night?.dark_until_utc ?? forecast.night?.end_utc ?? NaN);
    this.offsets = forecast.utc_offsets;
    this.count = STEP;
    this.fill();
  }

  /** Orders the passes: by `time`, or as in the response, the most probably visible first. */
  sort(order) {
    this.order = order;
    if (this.passes) this.fill();
  }

  fill() {
    const sorted = this.order === "time" ? this.passes.toSorted((a, b) => a.begin - b.begin) : this.passes;
    this.cards = sorted.slice(0, this.count).map((pass) => this.card(pass));
    this.list.replaceChildren(...this.cards.map((card) => card.item));
    this.more.hidden = this.cards.length === sorted.length;
    this.more.textContent = `Show more (${this.cards.length} of ${sorted.length} shown)`;
    this.tick();
    this.draw();
  }

  card(pass) {
    const item = document.createElement("li");
    const canvas = document.createElement("canvas");
    const name = pass.name || String(pass.norad_id);
    const at = (utc) => known(moment(utc), pass.along_track_sigma_s, offsetAt(this.offsets, moment(utc)));
    const where = (of) => `${fixed(pass[`${of}_altitude_deg`], 0)}° high in the ${compass(pass[`${of}_azimuth_deg`])}`;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `Track of ${name} on the sky, from ${where("begin")} to ${where("end")}`);
    const countdown = element("strong", "");
    const when = element("p", `${at(pass.begin_utc)} to ${at(pass.end_utc)} · `);
    when.append(countdown);
    const chance = pass.p_brighter == null ? "unknown probability" : pass.p_brighter > 0.99 ? ">99 %" : `${Math.round(100 * pass.p_brighter)} %`;
    const button = element("button", "Calendar");
    button.type = "button";
    button.setAttribute("aria-label", `Calendar file of ${name}, ${at(pass.begin_utc)}`);
    button.addEventListener("click", () => this.download(pass.calendar, `pass-${pass.norad_id}-${pass.begin_utc.slice(0, 16).replace(/[-:]/g, "")}Z`));
    const words = document.createElement("div");
    const bright = pass.peak_magnitude == null ? "magnitude unknown" : `mag ${fixed(pass.peak_magnitude, 1)} ± ${fixed(pass.peak_magnitude_sigma, 1)} at ${at(pass.peak_utc)}, ${where("peak")}`;
    words.append(
      element("h3", name),
      when,
      element("p", bright),
      element("p", `visible with ${chance} · ${ENDS[pass.ends_by] ?? "end unknown"} · elements ${fixed(pass.element_age_days, 1)} days old, times ± ${fixed(pass.along_track_sigma_s, 1)} s`, "muted"),
      button,
    );
    item.append(canvas, words);
    return { pass, item, canvas, countdown };
  }

  /** Saves a calendar as a file. */
  download(text, name) {
    save(text, `${name}.ics`, "text/calendar");
  }

  /** Updates the countdowns. */
  tick(now = Date.now()) {
    for (const { pass, item, countdown } of this.cards) {
      const [before, left] = [(pass.begin - now) / 1e3, (pass.end - now) / 1e3];
      const text = before > 0 ? `in ${span(before)}` : left > 0 ? `now, for ${span(left)}` : "over";
      if (countdown.textContent !== text) countdown.textContent = text;
      item.dataset.is = before > 0 ? "later" : left > 0 ? "now" : "over";
    }
  }

  draw() {
    for (const { pass, canvas } of this.cards) this.chart(pass, canvas);
  }

  /** Draws the track: zenith in the centre, north up, east left; the visible part is thick. */
  chart(pass, canvas) {
    const { context, width, height } = prepare(canvas);
    const colours = theme();
    const radius = Math.min(width, height) / 2 - 14;
    if (radius <= 0) return;
    const [x0, y0] = [width / 2, height / 2];
    const at = (sample) => {
      const reach = ((90 - Math.max(0, sample.altitude_deg)) / 90) * radius;
      return [x0 - reach * Math.sin(sample.azimuth_deg * DEG), y0 - reach * Math.cos(sample.azimuth_deg * DEG)];
    };
    context.fillStyle = colours.dark;
    context.strokeStyle = colours.line;
    for (const share of [1, 2 / 3, 1 / 3]) {
      context.beginPath();
      context.arc(x0, y0, share * radius, 0, 2 * Math.PI);
      if (share === 1) context.fill();
      context.stroke();
    }
    context.font = "11px system-ui, sans-serif";
    context.fillStyle = colours.muted;
    context.textAlign = "center";
    for (const [name, azimuth] of [["N", 0], ["E", 90], ["S", 180], ["W", 270]]) {
      context.fillText(name, x0 - (radius + 8) * Math.sin(azimuth * DEG), y0 - (radius + 8) * Math.cos(azimuth * DEG) + 4);
    }
    const end = (of) => ({ altitude_deg: pass[`${of}_altitude_deg`], azimuth_deg: pass[`${of}_azimuth_deg`] });
    const isSeen = (sample) => moment(sample.utc) > pass.begin && moment(sample.utc) < pass.end;
    context.strokeStyle = colours.muted;
    path(context, pass.samples.map(at));
    context.stroke();
    const seen = [end("begin"), ...pass.samples.filter(isSeen), end("end")].map(at);
    context.strokeStyle = context.fillStyle = css(pass.peak_magnitude);
    context.lineWidth = 3;
    path(context, seen);
    context.stroke();
    // Arrow at the end, and a dot at the brightest point.
    const [tip, before] = [seen.at(-1), seen.at(-2)];
    const angle = Math.atan2(tip[1] - before[1], tip[0] - before[0]);
    context.lineWidth = 2;
    path(context, [2.6, -2.6].flatMap((turn) => [[tip[0] + 8 * Math.cos(angle + turn), tip[1] + 8 * Math.sin(angle + turn)], tip, null]));
    context.stroke();
    if (pass.peak_utc) {
      context.fillStyle = colours.mark;
      context.beginPath();
      context.arc(...at(end("peak")), 4, 0, 2 * Math.PI);
      context.fill();
    }
  }
}

/** Well-known objects, with right ascension and declination [deg]. */
const EXAMPLES = [
  ["M31", 10.7, 41.3], ["NGC 104", 6, -72.1], ["M45", 56.8, 24.1], ["M42", 83.8, -5.4], ["NGC 2070", 84.7, -69.1],
  ["M44", 130.1, 19.7], ["M81", 148.9, 69.1], ["M104", 190, -11.6], ["NGC 5139", 201.7, -47.5], ["M51", 202.5, 47.2],
  ["M13", 250.4, 36.5], ["M8", 270.9, -24.4], ["M57", 283.4, 33], ["M27", 299.9, 22.7], ["M15", 322.5, 12.2],
];

/** Returns the names of the highest well-known objects over a site at a time, the highest first. */
export function examples({ latitude_deg: latitude, longitude_deg: longitude }, ms, count) {
  // Greenwich mean sidereal time [deg], by days since 2000-01-01 12:00 UT.
  const sidereal = 280.46 + 360.985647 * (ms / 86400e3 - 10957.5);
  const height = (ra, dec) => Math.sin(latitude * DEG) * Math.sin(dec * DEG) + Math.cos(latitude * DEG) * Math.cos(dec * DEG) * Math.cos((sidereal + longitude - ra) * DEG);
  return EXAMPLES.map(([name, ra, dec]) => [name, height(ra, dec)])
    .sort((a, b) => b[1] - a[1])
    .slice(0, count)
    .map(([name]) => name);
}
