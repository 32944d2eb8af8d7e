"""Chart of lateness against age by class: `lateness.py TABLE PICTURE.svg`.

TABLE is docs/tables/lateness.md; docs/build.sh calls this script.
"""

import math
import re
import sys
from pathlib import Path

WIDTH, HEIGHT = 760, 560
#: Left, top, width and height of the four panels, in the order of the table.
PANELS = [(62, 54, 310, 190), (430, 54, 310, 190), (62, 306, 310, 190), (430, 306, 310, 190)]
AGES_DAY = (1, 2, 3, 5, 7, 10, 14, 21)
SECONDS = (0.3, 3000.0)
STREAKCAST, PUBLISHED = "#1f6fb4", "#c8501e"


def read(path):
    """Class -> rows of (age in days, published, used and stated lateness in seconds: half widths of 68 %)."""
    classes = {}
    for line in Path(path).read_text().splitlines()[2:]:
        name, age, _, published, _, used, stated, _ = [cell.strip() for cell in line.strip("|").split("|")]
        half_width = lambda cell: float(re.split(r", ", cell)[1])
        classes.setdefault(name, []).append((float(age), half_width(published), half_width(used), float(stated)))
    return classes


def panel(name, rows, left, top, width, height):
    """One panel: logarithmic axes, the stated lateness as a line, observed ones as points."""
    low, high = math.log10(AGES_DAY[0] * 0.85), math.log10(AGES_DAY[-1] * 1.18)
    x = lambda age: left + width * (math.log10(age) - low) / (high - low)
    bottom, top_s = (math.log10(value) for value in SECONDS)
    y = lambda seconds: top + height * (top_s - math.log10(seconds)) / (top_s - bottom)
    parts = [f'<text x="{left + 6}" y="{top - 8}" font-weight="bold">{name}</text>']
    for seconds in (1, 10, 100, 1000):
        parts.append(f'<line x1="{left}" x2="{left + width}" y1="{y(seconds):.1f}" y2="{y(seconds):.1f}" stroke="#dddddd"/>')
        parts.append(f'<text x="{left - 6}" y="{y(seconds) + 4:.1f}" text-anchor="end">{seconds:,}</text>')
    for age in AGES_DAY:
        parts.append(f'<line x1="{x(age):.1f}" x2="{x(age):.1f}" y1="{top + height}" y2="{top + height + 5}" stroke="#444444"/>')
        parts.append(f'<text x="{x(age):.1f}" y="{top + height + 18}" text-anchor="middle">{age}</text>')
    parts.append(f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#444444"/>')
    line = " ".join(f"{x(age):.1f},{y(stated):.1f}" for age, _, _, stated in rows)
    parts.append(f'<polyline points="{line}" fill="none" stroke="{STREAKCAST}" stroke-width="2"/>')
    for age, published, used, _ in rows:
        parts.append(f'<path d="M{x(age):.1f} {y(published) - 5:.1f} l5 9 h-10 z" fill="{PUBLISHED}"/>')
        parts.append(f'<circle cx="{x(age):.1f}" cy="{y(used):.1f}" r="4" fill="{STREAKCAST}" stroke="white"/>')
    return parts


def main(table, picture):
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12" fill="#222222">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        f'<path d="M70 13 l5 9 h-10 z" fill="{PUBLISHED}"/><text x="82" y="22">observed, published drag</text>',
        f'<circle cx="270" cy="18" r="4" fill="{STREAKCAST}"/><text x="282" y="22">observed, without drag</text>',
        f'<line x1="456" x2="484" y1="18" y2="18" stroke="{STREAKCAST}" stroke-width="2"/><text x="492" y="22">stated, without drag (median)</text>',
    ]
    for (name, rows), place in zip(read(table).items(), PANELS, strict=True):
        parts += panel(name, rows, *place)
    middle = HEIGHT / 2 - 5
    parts.append(f'<text x="18" y="{middle}" text-anchor="middle" transform="rotate(-90 18 {middle})">half width that contains 68 % of the lateness, s</text>')
    parts.append(f'<text x="{WIDTH / 2}" y="{HEIGHT - 18}" text-anchor="middle">age of the elements, days</text>')
    Path(picture).parent.mkdir(parents=True, exist_ok=True)
    Path(picture).write_text("\n".join([*parts, "</svg>", ""]))


if __name__ == "__main__":
    main(*sys.argv[1:])
