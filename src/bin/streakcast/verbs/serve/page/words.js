// Formats of numbers and times.

/** Returns the milliseconds since 1970 of a time of the API (without microseconds). */
export const moment = (text) => Date.parse(text);

const two = (number) => String(number).padStart(2, "0");

/** Returns a time like 23:29:05 in UTC, or in a time zone `hours` ahead of it, with decimals of the second. */
export function clock(ms, hours = 0, decimals = 0) {
  const step = 10 ** (3 - decimals);
  const date = new Date(Math.round((ms + hours * 3600e3) / step) * step);
  const fraction = decimals ? "." + String(date.getUTCMilliseconds()).padStart(3, "0").slice(0, decimals) : "";
  return `${two(date.getUTCHours())}:${two(date.getUTCMinutes())}:${two(date.getUTCSeconds())}${fraction}`;
}

/** Returns a time of day with the digits that an error of the time allows: to 1 s, 10 s, 1 min or 10 min. */
export function known(ms, sigma_s, hours = 0, decimals = 0) {
  const sigma = sigma_s ?? Infinity;
  if (sigma > 60 && sigma < Infinity) return clock(Math.round(ms / 600e3) * 600e3, hours).slice(0, 5);
  if (sigma > 10) return clock(Math.round(ms / 60e3) * 60e3, hours).slice(0, 5);
  return clock(sigma > 1 ? Math.round(ms / 10e3) * 10e3 : ms, hours, sigma > 0.1 ? 0 : decimals);
}

/** Returns a length of time like 1 h 05 min, 12 min, or 4 min 05 s. */
export function span(seconds) {
  const whole = Math.max(0, Math.ceil(seconds));
  const [h, min, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  if (h) return `${h} h ${two(min)} min`;
  return min >= 10 ? `${min} min` : min ? `${min} min ${two(s)} s` : `${s} s`;
}

/** Returns a time of day like 23:30. */
export const hour = (ms, hours = 0) => clock(ms, hours).slice(0, 5);

/** Returns UTC in the format of the API, with milliseconds only if there are any. */
export const iso = (ms) => new Date(ms).toISOString().replace(".000Z", "Z");

/**
 * Returns the time that a text means, ms since 1970 as of a clock: `23:30`, `23:30:05` or `2026-08-14 23:30`; NaN for
 * another text. A time of day is in the night whose evening has the date `evening`, from noon to noon.
 */
export function typed(text, evening) {
  const [, date, hour, minute, second = "0"] = /^(?:(\d{4}-\d\d-\d\d)[ T]+)?(\d{1,2}):(\d\d)(?::(\d\d(?:\.\d+)?))?$/.exec(text) ?? [];
  if (!hour || hour > 23 || minute > 59 || second >= 60) return NaN;
  const day = Date.parse(`${date ?? evening}T00:00:00Z`);
  // 30 February would be 2 March.
  if (Number.isNaN(day) || (date && !iso(day).startsWith(date))) return NaN;
  const isMorning = !date && hour < 12;
  return day + (isMorning ? 86400e3 : 0) + hour * 3600e3 + minute * 60e3 + Math.round(second * 1e3);
}

/** Returns local time minus UTC at a time, hours; `offsets` are the values of the API with the times from which they hold. */
export const offsetAt = (offsets, ms) => (offsets.findLast((one) => moment(one.from_utc) <= ms) ?? offsets[0]).utc_offset_h;

/**
 * Returns the time, ms since 1970, at which local clocks show a time (ms since 1970 as of a clock). A time that occurs
 * twice is the first one; a time that clocks skip is as much later.
 */
export function fromLocal(offsets, ms) {
  const times = offsets.map((one) => ms - one.utc_offset_h * 3600e3);
  return times.find((utc, place) => offsetAt(offsets, utc) === offsets[place].utc_offset_h) ?? times[0];
}

/** Returns the names of all time zones of a night. */
export const zones = (offsets) => [...new Set(offsets.map((one) => zone(one.utc_offset_h)))].join(", then ");

/** Returns the name of a time zone like UTC−5 or UTC+5:30. */
export function zone(hours) {
  const sign = hours < 0 ? "−" : "+";
  const minutes = Math.round(Math.abs(hours) * 60);
  return `UTC${sign}${Math.floor(minutes / 60)}${minutes % 60 ? ":" + two(minutes % 60) : ""}`;
}

/** Formats a number with decimals; a dash without a number. */
export const fixed = (number, decimals) => (number == null ? "–" : number.toFixed(decimals).replace("-", "−"));

/** Formats a delay in tenths of a second, rounded up. */
export const delay = (seconds) => `+${(Math.ceil(seconds * 10 - 1e-6) / 10).toFixed(1)} s`;

/** Returns a right ascension like 12h34m56s. */
export function hours(degrees) {
  const seconds = Math.round(degrees * 240) % 86400;
  return `${two(Math.floor(seconds / 3600))}h${two(Math.floor(seconds / 60) % 60)}m${two(seconds % 60)}s`;
}

/** Returns a declination like −30°12′. */
export function sexagesimal(degrees) {
  const minutes = Math.round(Math.abs(degrees) * 60);
  return `${degrees < 0 ? "−" : "+"}${two(Math.floor(minutes / 60))}°${two(minutes % 60)}′`;
}

/** Saves text as a file of the browser's downloads. */
export function save(text, name, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Copies text to the clipboard, with a fallback for pages that are not on loopback. Returns whether that succeeded. */
export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = document.createElement("textarea");
    area.value = text;
    document.body.append(area);
    area.select();
    const isCopied = document.execCommand("copy");
    area.remove();
    return isCopied;
  }
}
