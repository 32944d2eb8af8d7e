// Text at the pointer, in the colours of the page, because the browser's own tooltips would be white under red light.

const box = document.getElementById("hover");

/**
 * Shows `textAt(x, y)` while the mouse is over an element; x and y are CSS pixels from its top left corner. An empty
 * text is not shown.
 */
export function hover(element, textAt) {
  const hide = () => (box.hidden = true);
  element.addEventListener("pointermove", (event) => {
    if (event.buttons || event.pointerType !== "mouse") return;
    const { left, top } = element.getBoundingClientRect();
    const text = textAt(event.clientX - left, event.clientY - top);
    box.hidden = !text;
    if (!text) return;
    box.textContent = text;
    const { width, height } = box.getBoundingClientRect();
    const isLow = event.clientY + 20 + height > innerHeight;
    box.style.left = `${Math.max(4, Math.min(event.clientX + 12, innerWidth - width - 4))}px`;
    box.style.top = `${event.clientY + (isLow ? -height - 8 : 20)}px`;
  });
  for (const end of ["pointerleave", "pointerdown"]) element.addEventListener(end, hide);
}

/** Returns the closest of `items` with `points` within `reach` pixels of a position; undefined without one. */
export function closest(items, x, y, reach) {
  let best = [reach, undefined];
  for (const item of items) {
    for (const point of item.points) {
      const distance = point ? Math.hypot(point[0] - x, point[1] - y) : Infinity;
      if (distance < best[0]) best = [distance, item];
    }
  }
  return best[1];
}
