// Canvases with the resolution of the screen, drawn in CSS pixels.

/** Returns a cleared drawing context with width and height in CSS pixels. */
export function prepare(canvas) {
  const box = canvas.getBoundingClientRect();
  const width = Math.max(1, Math.round(box.width));
  const height = Math.max(1, Math.round(box.height));
  const ratio = window.devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "12px system-ui, sans-serif";
  context.lineWidth = 1;
  context.lineCap = "butt";
  context.lineJoin = "miter";
  context.setLineDash([]);
  return { context, width, height };
}

/** Cached background of a chart: a drag redraws only the moving parts. */
export class Backdrop {
  /**
   * Draws the cached picture of `paint(context)`. The picture is painted again if the canvas or a value in `of`, on
   * which it depends, has changed.
   */
  show(context, of, paint) {
    const { canvas } = context;
    const shown = [canvas.width, canvas.height, context.getTransform().a, ...of];
    if (!this.shown || shown.some((one, place) => one !== this.shown[place])) {
      this.shown = null;
      this.picture = document.createElement("canvas");
      this.picture.width = canvas.width;
      this.picture.height = canvas.height;
      const own = this.picture.getContext("2d");
      own.setTransform(context.getTransform());
      own.font = context.font;
      paint(own);
      this.shown = shown;
    }
    context.save();
    context.resetTransform();
    context.drawImage(this.picture, 0, 0);
    context.restore();
  }
}

/** Traces a line through points [x, y], interrupted at null. */
export function path(context, points) {
  context.beginPath();
  let isOpen = false;
  for (const point of points) {
    if (!point) isOpen = false;
    else if (isOpen) context.lineTo(...point);
    else {
      context.moveTo(...point);
      isOpen = true;
    }
  }
}

/** Draws text with a border in the colour of the background, for legibility. */
export function label(context, text, x, y, colour, ground) {
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = ground;
  context.strokeText(text, x, y);
  context.fillStyle = colour;
  context.fillText(text, x, y);
  context.lineWidth = 1;
}

/** Returns a function that reserves the space of a label, and returns false if it is occupied. */
export function labelSpace() {
  const taken = [];
  return (context, text, x, y) => {
    const width = context.measureText(text).width;
    const left = context.textAlign === "right" ? x - width : context.textAlign === "center" ? x - width / 2 : x;
    const box = [left - 3, y - 12, left + width + 3, y + 4];
    if (taken.some((other) => box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3])) return false;
    taken.push(box);
    return true;
  };
}

/** Returns the shortest step of an axis with at most `count` steps. */
export function step(span, count, steps) {
  return steps.find((one) => span / one <= count) ?? steps[steps.length - 1];
}
