"""Chart of the share of streaks that are found against signal to noise: `completeness.py TABLE PICTURE.svg`.

TABLE is docs/tables/completeness.md, the output of the ignored test `completeness_of_many`.
"""

import math
import re
import sys
from pathlib import Path

WIDTH, HEIGHT = 720, 400
LEFT, TOP, ACROSS, DOWN = 62, 40, 630, 290
#: Ends of the logarithmic axis of the signal to noise.
ENDS = (2.7, 55.0)
COLOURS = ["#1f6fb4", "#c8501e", "#3a7d44"]


def read(path):
    """Names of the columns, and rows of (signal to noise, [(found, elsewhere), ...]).

    `found` is the percentage of streaks that are found, `elsewhere` that with a detection at another place.
    """
    lines = Path(path).read_text().splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    names = [name.split(": ")[1] for name in cells[0][1:]]
    number = lambda cell: tuple(float(part) for part in re.findall(r"[\d.]+(?= %)", cell))
    return names, [(float(row[0]), [number(cell) for cell in row[1:]]) for row in cells[2:]]


def main(table, picture):
    names, rows = read(table)
    low, high = (math.log10(end) for end in ENDS)
    x = lambda value: LEFT + ACROSS * (math.log10(value) - low) / (high - low)
    y = lambda percent: TOP + DOWN * (1.0 - percent / 100.0)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12" fill="#222222">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
    ]
    for percent in range(0, 101, 20):
        parts.append(f'<line x1="{LEFT}" x2="{LEFT + ACROSS}" y1="{y(percent):.1f}" y2="{y(percent):.1f}" stroke="#dddddd"/>')
        parts.append(f'<text x="{LEFT - 6}" y="{y(percent) + 4:.1f}" text-anchor="end">{percent}</text>')
    for value in (3, 5, 10, 20, 50):
        parts.append(f'<line x1="{x(value):.1f}" x2="{x(value):.1f}" y1="{TOP + DOWN}" y2="{TOP + DOWN + 5}" stroke="#444444"/>')
        parts.append(f'<text x="{x(value):.1f}" y="{TOP + DOWN + 18}" text-anchor="middle">{value}</text>')
    parts.append(f'<rect x="{LEFT}" y="{TOP}" width="{ACROSS}" height="{DOWN}" fill="none" stroke="#444444"/>')
    # The row without a streak has the signal to noise 0, which a logarithmic axis does not have.
    seen = [row for row in rows if row[0] > 0.0]
    for index, (name, colour) in enumerate(zip(names, COLOURS, strict=True)):
        for which, dashes in ((0, ""), (1, ' stroke-dasharray="5 4"')):
            line = " ".join(f"{x(value):.1f},{y(cells[index][which]):.1f}" for value, cells in seen)
            parts.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"{dashes}/>')
        for value, cells in seen:
            parts.append(f'<circle cx="{x(value):.1f}" cy="{y(cells[index][0]):.1f}" r="3.5" fill="{colour}" stroke="white"/>')
        at = LEFT + 10 + 210 * index
        parts.append(f'<circle cx="{at}" cy="{TOP - 18}" r="4" fill="{colour}"/><text x="{at + 9}" y="{TOP - 14}">{name} per megapixel</text>')
    parts.append(f'<text x="18" y="{TOP + DOWN / 2}" text-anchor="middle" transform="rotate(-90 18 {TOP + DOWN / 2})">share of streaks, %</text>')
    parts.append(f'<text x="{LEFT + ACROSS / 2}" y="{HEIGHT - 32}" text-anchor="middle">signal to noise of the streak without stars</text>')
    parts.append(f'<text x="{LEFT + ACROSS / 2}" y="{HEIGHT - 12}" text-anchor="middle">solid: found; dashed: detections at another place of the corridor</text>')
    Path(picture).parent.mkdir(parents=True, exist_ok=True)
    Path(picture).write_text("\n".join([*parts, "</svg>", ""]))


if __name__ == "__main__":
    main(*sys.argv[1:])
