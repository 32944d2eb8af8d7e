"""Chart of observed shares less stated probabilities: `brightness.py TABLE PICTURE.svg`.

TABLE is docs/tables/brightness.md; docs/build.sh calls this script.
"""

import sys
from pathlib import Path

WIDTH, HEIGHT = 560, 400
LEFT, TOP, ACROSS, UP = 70, 50, 460, 290
#: Largest drawn difference, and largest difference in the grey band, as fractions.
LARGEST, BAND = 0.07, 0.05
COMMON, NORMAL = "#1f6fb4", "#c8501e"


def read(path):
    """Pairs (stated, observed) of each tenth, for two distributions: shape of the other kinds, normal."""
    rows = [line.strip("|").split("|")[1:] for line in Path(path).read_text().splitlines()[2:]]
    share = lambda cell: tuple(float(part.strip(" %")) / 100.0 for part in cell.split(","))
    return [[share(row[column]) for row in rows] for column in range(2)]


def main(table, picture):
    common, normal = read(table)
    x = lambda stated: LEFT + ACROSS * stated
    y = lambda difference: TOP + UP * 0.5 * (1.0 - difference / LARGEST)
    largest = max(abs(observed - stated) for points in (common, normal) for stated, observed in points)
    assert largest < LARGEST, f"a difference of {largest} is outside the chart"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12" fill="#222222">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        f'<rect x="{x(0)}" y="{y(BAND):.1f}" width="{ACROSS}" height="{y(-BAND) - y(BAND):.1f}" fill="#ececec"/>',
    ]
    for tenth in range(0, 11, 2):
        parts.append(f'<line x1="{x(tenth / 10)}" x2="{x(tenth / 10)}" y1="{TOP}" y2="{TOP + UP}" stroke="#d4d4d4"/>')
        parts.append(f'<text x="{x(tenth / 10)}" y="{TOP + UP + 18}" text-anchor="middle">{10 * tenth} %</text>')
    for percent in (-5, 0, 5):
        at = y(percent / 100)
        parts.append(f'<line x1="{x(0)}" x2="{x(1)}" y1="{at:.1f}" y2="{at:.1f}" stroke="{"#888888" if percent == 0 else "#d4d4d4"}"/>')
        parts.append(f'<text x="{x(0) - 8}" y="{at + 4:.1f}" text-anchor="end">{f"{percent:+} %".replace("-", "−") if percent else "0 %"}</text>')
    parts.append(f'<rect x="{x(0)}" y="{TOP}" width="{ACROSS}" height="{UP}" fill="none" stroke="#444444"/>')
    for stated, observed in normal:
        parts.append(f'<path d="M{x(stated):.1f} {y(observed - stated) - 5:.1f} l5 9 h-10 z" fill="{NORMAL}"/>')
    for stated, observed in common:
        parts.append(f'<circle cx="{x(stated):.1f}" cy="{y(observed - stated):.1f}" r="4" fill="{COMMON}" stroke="white"/>')
    parts.append(f'<circle cx="76" cy="22" r="4" fill="{COMMON}"/><text x="86" y="26">common shape, fitted to the other kinds</text>')
    parts.append(f'<path d="M436 17 l5 9 h-10 z" fill="{NORMAL}"/><text x="448" y="26">normal</text>')
    middle = TOP + UP / 2
    parts.append(f'<text x="20" y="{middle}" text-anchor="middle" transform="rotate(-90 20 {middle})">observed share less stated probability</text>')
    parts.append(f'<text x="{LEFT + ACROSS / 2}" y="{HEIGHT - 14}" text-anchor="middle">stated probability of being brighter than the limit</text>')
    Path(picture).parent.mkdir(parents=True, exist_ok=True)
    Path(picture).write_text("\n".join([*parts, "</svg>", ""]))


if __name__ == "__main__":
    main(*sys.argv[1:])
