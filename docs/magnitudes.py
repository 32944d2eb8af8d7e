"""Charts of held-out magnitudes before and after the present recipe: `magnitudes.py MEANS PHASES PICTURE.svg`.

MEANS is docs/tables/before-after.md and PHASES docs/tables/before-after-phase.md; docs/build.sh calls this script.
"""

import sys
from pathlib import Path

WIDTH, HEIGHT = 860, 400
TOP, UP = 50, 280
BEFORE, AFTER = "#c8501e", "#1f6fb4"
#: Left and width of the two charts, and the ranges of their vertical axes.
MEDIANS, GAINS = (70, 330), (510, 330)
MOST_MEDIAN_MAG, GAIN_RANGE = 0.6, (-0.15, 0.35)
KIND = "starlink-visorsat"


def cells(path):
    """Rows of a table as lists of text; an empty first cell is that of the row above."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in Path(path).read_text().splitlines()[2:]]
    for above, row in zip(rows, rows[1:]):
        row[0] = row[0] or above[0]
    return rows


def main(means, phases, picture):
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12" fill="#222222">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
    ]
    signed = lambda value, digits: f"{value:+.{digits}f}".replace("-", "−") if value else "0"

    def frame(left, across, low, high, step, digits, label):
        """Axes; returns the function of vertical positions."""
        y = lambda value: TOP + UP * (high - value) / (high - low)
        for tick in range(round(low / step), round(high / step) + 1):
            at, is_zero = y(tick * step), tick == 0
            parts.append(f'<line x1="{left}" x2="{left + across}" y1="{at:.1f}" y2="{at:.1f}" stroke="{"#888888" if is_zero else "#d4d4d4"}"/>')
            parts.append(f'<text x="{left - 8}" y="{at + 4:.1f}" text-anchor="end">{signed(tick * step, digits)}</text>')
        parts.append(f'<rect x="{left}" y="{TOP}" width="{across}" height="{UP}" fill="none" stroke="#444444"/>')
        middle = TOP + UP / 2
        parts.append(f'<text x="{left - 50}" y="{middle}" text-anchor="middle" transform="rotate(-90 {left - 50} {middle})">{label}</text>')
        return y

    # Median residual of one kind by phase angle.
    left, across = MEDIANS
    y = frame(left, across, -MOST_MEDIAN_MAG, MOST_MEDIAN_MAG, 0.2, 1, "median residual, mag")
    x = lambda phase_deg: left + across * (phase_deg - 20.0) / 130.0
    for phase_deg in range(20, 151, 20):
        parts.append(f'<text x="{x(phase_deg):.1f}" y="{TOP + UP + 18}" text-anchor="middle">{phase_deg}°</text>')
    for column, colour in ((3, BEFORE), (4, AFTER)):
        points = []
        for row in cells(phases):
            if row[0] == KIND:
                low, _, high, _ = row[1].split()
                value = float(row[column])
                assert abs(value) < MOST_MEDIAN_MAG, f"{value} is outside the chart"
                points.append((x(0.5 * (float(low) + float(high))), y(value)))
        parts.append(f'<path d="M{" L".join(f"{a:.1f} {b:.1f}" for a, b in points)}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
        parts.extend(f'<circle cx="{a:.1f}" cy="{b:.1f}" r="4" fill="{colour}" stroke="white"/>' for a, b in points)
    parts.append(f'<text x="{left + across / 2}" y="{HEIGHT - 24}" text-anchor="middle">phase angle (VisorSat)</text>')
    parts.append(f'<circle cx="{left + 6}" cy="30" r="4" fill="{BEFORE}"/><text x="{left + 16}" y="34">before</text>')
    parts.append(f'<circle cx="{left + 86}" cy="30" r="4" fill="{AFTER}"/><text x="{left + 96}" y="34">after</text>')

    # Gain of the log score of each kind, with its error.
    left, across = GAINS
    y = frame(left, across, *GAIN_RANGE, 0.05, 2, "gain of the log score")
    gains = [(row[0], *map(float, row[8].split("+-"))) for row in cells(means) if row[1] == "after"]
    for place, (name, gain, error) in enumerate(gains):
        at = left + across * (place + 0.5) / len(gains)
        ends = [min(max(end, GAIN_RANGE[0]), GAIN_RANGE[1]) for end in (gain - error, gain + error)]
        parts.append(f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{y(ends[0]):.1f}" y2="{y(ends[1]):.1f}" stroke="{AFTER}" stroke-width="1.5"/>')
        parts.append(f'<circle cx="{at:.1f}" cy="{y(gain):.1f}" r="4" fill="{AFTER}" stroke="white"/>')
        label = name.replace("starlink-", "").replace("mean of the kinds", "mean").replace("-next", "")
        parts.append(f'<text x="{at:.1f}" y="{TOP + UP + 18}" text-anchor="middle">{label}</text>')
    parts.append(f'<text x="{left + across / 2}" y="{HEIGHT - 24}" text-anchor="middle">kind of satellite</text>')
    Path(picture).write_text("\n".join([*parts, "</svg>", ""]))


if __name__ == "__main__":
    main(*sys.argv[1:])
