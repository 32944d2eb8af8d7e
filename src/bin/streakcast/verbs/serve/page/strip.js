// Strip of the minutes around an exposure, with the crossings of its field and a bar for the exposure that can be
// dragged and resized.

import { css, theme } from "./colours.js";
import { label, labelSpace, prepare, step } from "./canvas.js";
import { hover } from "./hover.js";
import { clock, fixed } from "./words.js";

const TOP = 22;
const BOTTOM = 24;
/** Longest exposure of the API, seconds. */
const LONGEST_S = 3600;

export class Strip {
  /** `change(shift_s, duration_s, isDone)` is called for every press and move; shifts are relative to the scheduled opening. */
  constructor(box, change) {
    this.box = box;
    this.canvas = box.querySelector("canvas");
    this.bar = box.querySelector("#bar");
    this.handle = box.querySelector("#stretch");
    this.change = change;
    this.shift = 0;
    this.duration = 30;
    this.forget();
    this.grab(this.bar, (seconds, begun) => ({ shift: begun.shift + seconds }));
    this.grab(this.handle, (seconds, begun) => ({ duration: begun.duration + seconds }));
    this.keys(this.bar, (seconds) => ({ shift: this.shift + seconds }));
    this.keys(this.handle, (seconds) => ({ duration: this.duration + seconds }));
    // A click next to the bar moves the start of the bar to that position.
    this.canvas.addEventListener("click", (event) => {
      const x = event.clientX - this.canvas.getBoundingClientRect().left;
      this.move({ shift: this.from + x / this.scale() }, true);
    });
    hover(box, (x) => this.describe(x));
  }

  /** Returns the time at a position, CSS pixels, with the crossing there. */
  describe(x) {
    const at = (seconds, decimals) => clock(this.base + seconds * 1e3, 0, decimals);
    const seconds = this.from + x / this.scale();
    const near = 3 / this.scale();
    const one = this.crossings.find(({ enter, exit }) => enter - near <= seconds && seconds <= exit + near);
    if (!one) return `${at(seconds, 0)} UTC`;
    const limit = one.exceeds == null ? "" : one.exceeds ? ", exceeds the limit" : ", within the limit";
    return `${one.name}: ${fixed(one.magnitude, 1)} mag, ${at(one.enter, 1)} to ${at(one.exit, 1)} UTC${limit}`;
  }

  /** Shows an exposure: scheduled opening (ms), shift and duration. */
  show(base, shift, duration) {
    this.base = base;
    this.shift = shift;
    this.duration = duration;
    this.forget();
    this.centre();
    this.draw();
  }

  forget() {
    this.crossings = [];
    /** Interval in which all crossings are known, seconds after the scheduled opening. */
    this.known = null;
  }

  /** Returns the length of the strip of an exposure, seconds. */
  span(duration = this.duration) {
    return Math.min(1800, Math.max(240, Math.ceil(duration / 30) * 30 * 10));
  }

  centre() {
    this.from = this.shift - 0.25 * this.span();
  }

  /** Returns whether the crossings of the whole strip are available. */
  isKnown() {
    return this.known !== null && this.known.from <= this.from && this.from + this.span() <= this.known.to;
  }

  /** Shows the crossings of the interval `known`, seconds after the scheduled opening; without `known` the shown ones are kept. */
  answer(crossings, known, nextShift) {
    if (known) {
      this.crossings = crossings;
      this.known = known;
    }
    this.next = nextShift;
    this.draw();
  }

  scale() {
    return this.box.getBoundingClientRect().width / this.span();
  }

  grab(element, moved) {
    element.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      element.focus({ preventScroll: true });
      element.setPointerCapture(event.pointerId);
      this.begun = { x: event.clientX, shift: this.shift, duration: this.duration };
      // A request at the press opens the connection before the first move.
      this.change(this.shift, this.duration, false);
    });
    element.addEventListener("pointermove", (event) => {
      if (!this.begun || !element.hasPointerCapture(event.pointerId)) return;
      this.move(moved((event.clientX - this.begun.x) / this.scale(), this.begun), false);
    });
    const done = () => {
      if (!this.begun) return;
      this.begun = null;
      this.move({}, true);
    };
    element.addEventListener("pointerup", done);
    element.addEventListener("pointercancel", done);
  }

  keys(element, moved) {
    element.addEventListener("keydown", (event) => {
      const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 };
      if (!(event.key in steps) || event.altKey || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      this.move(moved(steps[event.key] * (event.shiftKey ? 10 : 1)), true);
    });
  }

  /** Moves the bar by whole seconds, which keeps fractions of the start and the length. The strip follows the bar. */
  move(to, isDone) {
    const near = (now, target) => now + Math.round(target - now);
    const shift = "shift" in to ? near(this.shift, to.shift) : this.shift;
    const duration = "duration" in to ? Math.min(LONGEST_S, Math.max(1, near(this.duration, to.duration))) : this.duration;
    // A hidden strip has no scale.
    if (!Number.isFinite(shift + duration)) return;
    if (!isDone && shift === this.shift && duration === this.duration) return;
    this.shift = shift;
    this.duration = duration;
    const place = (this.shift - this.from) / this.span();
    if (isDone && (place < 0.05 || place + this.duration / this.span() > 0.95)) this.centre();
    this.change(shift, duration, isDone);
    // During a drag only the bar is moved, and the response redraws the strip. The strip is redrawn now if its scale
    // has changed.
    if (isDone || this.span() !== this.drawnSpan) this.draw();
    else this.place();
  }

  draw() {
    if (this.base == null) return;
    const { context, width, height } = prepare(this.canvas);
    const colours = theme();
    this.drawnSpan = this.span();
    const scale = width / this.drawnSpan;
    const at = (seconds) => (seconds - this.from) * scale;
    const top = TOP, bottom = height - BOTTOM;
    context.fillStyle = colours.dark;
    context.fillRect(0, top, width, bottom - top);
    const every = step(this.span(), width / 84, [5, 10, 20, 30, 60, 120, 300, 600]);
    context.textAlign = "center";
    const first = Math.ceil((this.base / 1e3 + this.from) / every) * every;
    for (let seconds = first; seconds <= this.base / 1e3 + this.from + this.span(); seconds += every) {
      const x = at(seconds - this.base / 1e3);
      context.fillStyle = colours.line;
      context.fillRect(x - 0.5, top, 1, bottom - top);
      context.fillStyle = colours.muted;
      if (x > 30 && x < width - 30) context.fillText(clock(seconds * 1e3), x, height - 7);
    }
    context.textAlign = "left";
    const isFree = labelSpace();
    for (const one of [...this.crossings].sort((a, b) => (a.magnitude ?? 99) - (b.magnitude ?? 99))) {
      const isFaint = one.exceeds === false;
      const x = at(one.enter), wide = Math.max(2, at(one.exit) - x);
      if (x > width || x + wide < 0) continue;
      context.fillStyle = css(one.magnitude, isFaint ? 0.55 : 1);
      context.fillRect(x, isFaint ? (top + bottom) / 2 : top + 4, wide, (isFaint ? (bottom - top) / 2 : bottom - top) - 8);
      const words = fixed(one.magnitude, 1);
      const left = Math.min(Math.max(2, x + 2), width - 24);
      if (isFree(context, words, left, top - 6)) label(context, words, left, top - 6, colours.text, colours.panel);
    }
    if (this.next != null && this.next > this.shift) {
      context.setLineDash([5, 4]);
      context.lineWidth = 2;
      context.strokeStyle = colours.good;
      context.strokeRect(at(this.next), top + 2, this.duration * scale, bottom - top - 4);
      context.setLineDash([]);
    }
    this.place();
  }

  /** Positions the bar. */
  place() {
    const scale = this.scale();
    const x = (this.shift - this.from) * scale, end = x + this.duration * scale;
    this.bar.style.left = `${x}px`;
    this.bar.style.width = `${Math.max(4, end - x)}px`;
    this.handle.style.left = `${end}px`;
    const opening = clock(this.base + this.shift * 1e3);
    this.bar.setAttribute("aria-valuenow", this.shift);
    this.bar.setAttribute("aria-valuemin", -86400);
    this.bar.setAttribute("aria-valuemax", 86400);
    this.bar.setAttribute("aria-valuetext", `opens ${opening} UTC, moved by ${this.shift} s`);
    this.handle.setAttribute("aria-valuenow", this.duration);
    this.handle.setAttribute("aria-valuemin", 1);
    this.handle.setAttribute("aria-valuemax", LONGEST_S);
    this.handle.setAttribute("aria-valuetext", `${this.duration} s long`);
  }
}
