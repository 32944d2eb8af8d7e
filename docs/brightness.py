"""Chart of observed against stated probabilities: `brightness.py TABLE PICTURE.svg`.

TABLE is docs/tables/brightness.md; docs/build.sh calls this script.
"""

import sys
from pathlib import Path

WIDTH, HEIGHT = 460, 440
LEFT, TOP, SIDE = 70, 50, 330
CORE_AND_WING, OTHERS, NORMAL = "#1f6fb4", "#4d9a5b", "#c8501e"


def read(path):
    """Pairs (stated, observed) of each tenth, for three distributions: core and wing, of the other models, normal."""
    rows = [line.strip("|").split("|")[1:] for line in Path(path).read_text().splitlines()[2:]]
    share = lambda cell: tuple(float(part.strip(" %")) / 100.0 for part in cell.split(","))
    return [[share(row[column]) for row in rows] for column in range(3)]


def main(table, picture):
    core_and_wing, others, normal = read(table)
    x = lambda share: LEFT + SIDE * share
    y = lambda share: TOP + SIDE * (1.0 - share)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12" fill="#222222">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        f'<polygon points="{x(0)},{y(0.05)} {x(0.95)},{y(1)} {x(1)},{y(1)} {x(1)},{y(0.95)} {x(0.05)},{y(0)} {x(0)},{y(0)}" fill="#eeeeee"/>',
    ]
    for tenth in range(0, 11, 2):
        share = tenth / 10
        parts.append(f'<line x1="{x(0)}" x2="{x(1)}" y1="{y(share)}" y2="{y(share)}" stroke="#dddddd"/>')
        parts.append(f'<text x="{x(0) - 8}" y="{y(share) + 4}" text-anchor="end">{100 * share:.0f} %</text>')
        parts.append(f'<text x="{x(share)}" y="{y(0) + 18}" text-anchor="middle">{100 * share:.0f} %</text>')
    parts.append(f'<line x1="{x(0)}" y1="{y(0)}" x2="{x(1)}" y2="{y(1)}" stroke="#888888"/>')
    parts.append(f'<rect x="{x(0)}" y="{y(1)}" width="{SIDE}" height="{SIDE}" fill="none" stroke="#444444"/>')
    for stated, observed in normal:
        parts.append(f'<path d="M{x(stated):.1f} {y(observed) - 5:.1f} l5 9 h-10 z" fill="{NORMAL}"/>')
    for stated, observed in others:
        parts.append(f'<rect x="{x(stated) - 3.5:.1f}" y="{y(observed) - 3.5:.1f}" width="7" height="7" fill="none" stroke="{OTHERS}" stroke-width="1.5"/>')
    for stated, observed in core_and_wing:
        parts.append(f'<circle cx="{x(stated):.1f}" cy="{y(observed):.1f}" r="4" fill="{CORE_AND_WING}" stroke="white"/>')
    parts.append(f'<circle cx="76" cy="22" r="4" fill="{CORE_AND_WING}"/><text x="86" y="26">core and wing</text>')
    parts.append(f'<rect x="184.5" y="18.5" width="7" height="7" fill="none" stroke="{OTHERS}" stroke-width="1.5"/><text x="198" y="26">of the other models</text>')
    parts.append(f'<path d="M336 17 l5 9 h-10 z" fill="{NORMAL}"/><text x="348" y="26">normal</text>')
    middle = TOP + SIDE / 2
    parts.append(f'<text x="20" y="{middle}" text-anchor="middle" transform="rotate(-90 20 {middle})">observed share brighter than a limit</text>')
    parts.append(f'<text x="{LEFT + SIDE / 2}" y="{HEIGHT - 14}" text-anchor="middle">stated probability</text>')
    Path(picture).parent.mkdir(parents=True, exist_ok=True)
    Path(picture).write_text("\n".join([*parts, "</svg>", ""]))


if __name__ == "__main__":
    main(*sys.argv[1:])
