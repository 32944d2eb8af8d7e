// Sharp canvases: sized to the pixels of the screen, drawn in the page's own.

/** A context to draw in, cleared, with width and height in pixels of the page. */
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
  context.setLineDash([]);
  return { context, width, height };
}

/** What lies behind in a chart, kept while it stays the same: a drag redraws alone what it moves. */
export class Backdrop {
  /** Puts on the canvas what `paint(context)` draws; that is drawn anew where `of` (what it shows) or the canvas is another. */
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

/** A line through points [x, y]; a point that is null breaks it. */
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

/** Text with a border of the ground's colour, so that it can be read over anything. */
export function label(context, text, x, y, colour, ground) {
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = ground;
  context.strokeText(text, x, y);
  context.fillStyle = colour;
  context.fillText(text, x, y);
  context.lineWidth = 1;
}

/** Remembers where text stands, and says whether there is room for more. */
export function places() {
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

/** Round steps for an axis: so long that about `wanted` of them fit. */
export function step(span, wanted, steps) {
  return steps.find((one) => span / one <= wanted) ?? steps[steps.length - 1];
}
