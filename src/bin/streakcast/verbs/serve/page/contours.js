// Lines of equal value on a grid, by marching squares.

/**
 * Returns the segments [[x, y], [x, y]], in grid coordinates, on which `values[y][x]` equals `level`. Cells with gaps
 * have no segments.
 */
export function contour(values, level) {
  const segments = [];
  for (let y = 0; y + 1 < values.length; y += 1) {
    for (let x = 0; x + 1 < values[y].length; x += 1) {
      const corners = [values[y][x], values[y][x + 1], values[y + 1][x + 1], values[y + 1][x]];
      if (corners.some((value) => value == null)) continue;
      const cuts = [];
      const between = (a, b, from, to) => {
        const [low, high] = [corners[a] - level, corners[b] - level];
        if (low < 0 === high < 0) return;
        const share = low / (low - high);
        cuts.push([x + from[0] + (to[0] - from[0]) * share, y + from[1] + (to[1] - from[1]) * share]);
      };
      between(0, 1, [0, 0], [1, 0]);
      between(1, 2, [1, 0], [1, 1]);
      between(2, 3, [1, 1], [0, 1]);
      between(3, 0, [0, 1], [0, 0]);
      for (let pair = 0; pair + 1 < cuts.length; pair += 2) segments.push([cuts[pair], cuts[pair + 1]]);
    }
  }
  return segments;
}

/** Interpolates a value of a grid; null if a neighbour is a gap. */
export function between(values, x, y) {
  const [left, low] = [Math.floor(x), Math.min(values.length - 2, Math.floor(y))];
  const [u, v] = [x - left, y - low];
  const [a, b, c, d] = [values[low][left], values[low][left + 1], values[low + 1][left], values[low + 1][left + 1]];
  if (a == null || b == null || c == null || d == null) return null;
  return a * (1 - u) * (1 - v) + b * u * (1 - v) + c * (1 - u) * v + d * u * v;
}
