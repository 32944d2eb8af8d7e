"""What the tests measured against authorities, as Markdown on standard output: `tables.py FIGURES`; docs/tables.sh calls it."""

import sys
from datetime import date
from pathlib import Path

#: Units that read better in smaller ones: from, to, factor, below which.
SMALLER = {
    "km": [("m", 1e3), ("mm", 1e6), ("µm", 1e9)],
    "km/s": [("m/s", 1e3), ("mm/s", 1e6), ("µm/s", 1e9), ("nm/s", 1e12)],
    "s": [("ms", 1e3), ("µs", 1e6)],
    "rad": [("mas", 206_264_806.247)],
    "deg": [("arcsec", 3600.0), ("mas", 3.6e6)],
    "arcsec": [("mas", 1e3)],
    "mag": [("mmag", 1e3)],
}


#: Digits of an exponent.
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def in_unit(value, unit):
    """A number with its unit, in the one that leaves no zeros in front."""
    scaled, name = value, unit
    for smaller, factor in SMALLER.get(unit, []):
        if abs(scaled) >= 0.1 or value == 0.0:
            break
        scaled, name = value * factor, smaller
    text = f"{scaled:.2g}"
    if "e" in text and 1e-3 <= abs(scaled) < 1e5:
        text = f"{scaled:.0f}"
    mantissa, _, exponent = text.partition("e")
    if exponent:
        text = f"{mantissa}·10{str(int(exponent)).translate(RAISED)}"
    return f"{text} {name}".strip()


def accuracy(path):
    rows = [line.split("\t") for line in Path(path).read_text().splitlines()]
    worst = {}
    for what, authority, compared, measured, allowed, unit in rows:
        key = (what, authority)
        seen = worst.get(key)
        # Tests that run more than once: the worst counts.
        if seen is None or float(measured) > seen[1]:
            worst[key] = (int(compared), float(measured), float(allowed), unit)
    print(f"<!-- Made by docs/tables.sh on {date.today()}; do not edit. -->\n")
    print(f"{len(worst)} comparisons, {date.today()}; `worst` is the largest difference seen, `allowed` what the test would fail at.\n")
    print("| what | against | compared | worst | allowed |\n|---|---|---|---|---|")
    for (what, authority), (compared, measured, allowed, unit) in sorted(worst.items(), key=lambda row: (row[0][1].lower(), row[0][0])):
        print(f"| {what} | {authority} | {compared:,} | {in_unit(measured, unit)} | {in_unit(allowed, unit)} |")


if __name__ == "__main__":
    accuracy(sys.argv[1])
