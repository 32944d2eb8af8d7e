"""Histogram of the position angles of trails: `position_angles.py TABLE PICTURE.svg`.

TABLE is docs/tables/position-angles.md; docs/build.sh calls this script.
"""

import sys
from pathlib import Path

WIDTH, HEIGHT = 620, 400
LEFT, TOP, ACROSS, UP = 70, 50, 520, 285
#: Largest drawn share, percent.
LARGEST = 20.0
#: Position angles that the published histogram marks, degrees: 90 less the mean inclination of 53.16.
PUBLISHED = (-36.84, 36.84)
OURS, LINES = "#1f6fb4", "#c8501e"


def read(path):
    """Rows of (first angle, last angle, share in percent)."""
    rows = [line.strip("|\n ").split("|") for line in Path(path).read_text().splitlines()[2:]]
    return [(*map(float, angles.split(" to ")), float(share.strip(" %"))) for angles, _, share in rows]


def main(table, picture):
    rows = read(table)
    assert max(share for *_, share in rows) < LARGEST, "a bar is outside the chart"
    x = lambda angle: LEFT + ACROSS * (angle + 90.0) / 180.0
    y = lambda share: TOP + UP * (1.0 - share / LARGEST)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12" fill="#222222">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        f'<rect x="{LEFT}" y="14" width="12" height="12" fill="{OURS}"/><text x="{LEFT + 18}" y="24">computed</text>',
        f'<line x1="{LEFT + 110}" x2="{LEFT + 138}" y1="20" y2="20" stroke="{LINES}" stroke-width="2" stroke-dasharray="6 4"/>',
        f'<text x="{LEFT + 146}" y="24">angles marked in the published histogram (inclination 53.16 deg)</text>',
    ]
    for share in (0, 5, 10, 15, 20):
        parts.append(f'<line x1="{LEFT}" x2="{LEFT + ACROSS}" y1="{y(share):.1f}" y2="{y(share):.1f}" stroke="#dddddd"/>')
        parts.append(f'<text x="{LEFT - 6}" y="{y(share) + 4:.1f}" text-anchor="end">{share} %</text>')
    for first, last, share in rows:
        height = y(0.0) - y(share)
        parts.append(f'<rect x="{x(first) + 1:.1f}" y="{y(share):.1f}" width="{x(last) - x(first) - 2:.1f}" height="{height:.1f}" fill="{OURS}"/>')
    for angle in range(-90, 91, 30):
        parts.append(f'<text x="{x(angle):.1f}" y="{TOP + UP + 18}" text-anchor="middle">{angle}</text>')
    for angle in PUBLISHED:
        parts.append(f'<line x1="{x(angle):.1f}" x2="{x(angle):.1f}" y1="{TOP}" y2="{TOP + UP}" stroke="{LINES}" stroke-width="2" stroke-dasharray="6 4"/>')
    parts.append(f'<rect x="{LEFT}" y="{TOP}" width="{ACROSS}" height="{UP}" fill="none" stroke="#444444"/>')
    parts.append(f'<text x="{LEFT + ACROSS / 2}" y="{HEIGHT - 18}" text-anchor="middle">position angle of the trail, from north through east, deg</text>')
    parts.append(f'<text x="18" y="{TOP + UP / 2}" text-anchor="middle" transform="rotate(-90 18 {TOP + UP / 2})">share of the trails</text>')
    Path(picture).parent.mkdir(parents=True, exist_ok=True)
    Path(picture).write_text("\n".join([*parts, "</svg>", ""]))


if __name__ == "__main__":
    main(*sys.argv[1:])
