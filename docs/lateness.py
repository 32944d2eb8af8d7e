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
AGES_DAY = (1, 3, 7, 14)
SECONDS = (0.3, 3000.0)
PUBLISHED, ONE_SET, TWO_SETS = "#c8501e", "#1f6fb4", "#2a8f4d"
CLASSES = ("V1.5", "VisorSat, V2 Mini", "V2 Mini, strong drag", "Direct-to-Cell")


def read(path):
    """Class -> rows of (age in days, half widths of 68 %: published, then observed and stated with one and with two sets)."""
    classes = {}
    for line in Path(path).read_text().splitlines()[2:]:
        name, age, _, published, one, two, _ = [cell.strip() for cell in line.strip("|\n").split("|")]
        numbers = lambda cell: [float(part) for part in cell.split(", ")[:2]]
        if name in CLASSES:
            classes.setdefault(name, []).append((float(age), float(published), *numbers(one), *numbers(two)))
    return classes


def panel(name, rows, left, top, width, height):
    """One panel: logarithmic axes, stated half widths as lines, observed ones as points."""
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
    for color, of_row in ((ONE_SET, 3), (TWO_SETS, 5)):
        line = " ".join(f"{x(row[0]):.1f},{y(row[of_row]):.1f}" for row in rows)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{color}" stroke-width="2"/>')
    for age, published, one, _, two, _ in rows:
        parts.append(f'<path d="M{x(age):.1f} {y(published) - 5:.1f} l5 9 h-10 z" fill="{PUBLISHED}"/>')
        parts.append(f'<circle cx="{x(age):.1f}" cy="{y(one):.1f}" r="4" fill="{ONE_SET}" stroke="white"/>')
        parts.append(f'<rect x="{x(age) - 3.5:.1f}" y="{y(two) - 3.5:.1f}" width="7" height="7" fill="{TWO_SETS}" stroke="white"/>')
    return parts


def main(table, picture):
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12" fill="#222222">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        f'<path d="M70 13 l5 9 h-10 z" fill="{PUBLISHED}"/><text x="82" y="22">published drag</text>',
        f'<circle cx="200" cy="18" r="4" fill="{ONE_SET}"/><text x="212" y="22">one element set</text>',
        f'<rect x="336" y="14.5" width="7" height="7" fill="{TWO_SETS}"/><text x="350" y="22">and one of 7 days before</text>',
        f'<line x1="528" x2="556" y1="18" y2="18" stroke="#444444" stroke-width="2"/><text x="564" y="22">lines: stated (median)</text>',
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
