"""Tables of the documentation as Markdown on standard output, for docs/tables.sh.

    tables.py FIGURES           differences that tests measured; FIGURES has one line per comparison, written by
                                tests/common/agreement.rs: subject, quantity, authority, number, largest difference,
                                bound, unit
    tables.py --lu2024 TABLE    numbers of `streakcast reproduce lu2024`, from its table.csv
"""

import csv
import sys
import textwrap
from datetime import date
from pathlib import Path

#: Smaller units for numbers below 0.1: unit, and factor to it.
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

#: Tables: title, text, and the subjects (names of test files).
TABLES = [
    (
        "Frames, Earth orientation, Sun",
        "With the same Earth orientation, frames and sites agree with astropy to micrometres. The built-in Earth orientation "
        "moves a site by less than 0.25 m. The Sun is within 11 km of its position in JPL DE421, which is 0.015 arcsec.",
        ["frames"],
    ),
    (
        "Positions of satellites",
        "SGP4 agrees with the reference code within a millimetre, and directions agree with JPL Horizons within an arcsecond. "
        "The errors of the element sets, which are a kilometre or more, are not included.",
        ["ephemeris", "horizons", "operator_ephemerides", "sgp4_verification", "space_observers"],
    ),
    (
        "Crossings, passes, shadow",
        "Times of the shadow agree within 20 ms, and passes within 0.1 s of STK; Heavens-Above rounds to 1 s and 1 deg. Times of "
        "entry into the field and exit from it are compared with a bound of 2 ms plus the time in which the satellite moves by "
        "0.2 arcsec.",
        ["crossings", "passes_reference", "shadow"],
    ),
    (
        "Magnitudes",
        "The differences are below 0.01 mag. Real satellites scatter about the models by 0.25 to 1.7 mag.",
        ["earthshine", "maps", "photometry_model", "photometry_panels"],
    ),
    (
        "Images",
        "Streaks agree with GalSim within a thousandth of the peak, world coordinates with astropy within a millionth of a pixel.",
        ["streaks", "wcs"],
    ),
    (
        "Statistics and fits",
        "Fits and statistics agree with SciPy, numpy and emcee within the rounding or the tolerance of the method.",
        ["fit_two_panel", "measured"],
    ),
]


def in_unit(value, unit):
    """A number with its unit, in the largest unit in which it is at least 0.1."""
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


def largest_differences(path):
    """(subject, quantity, authority) -> (number, largest difference, bound, unit); of several runs the largest."""
    largest = {}
    for line in Path(path).read_text().splitlines():
        subject, quantity, authority, number, measured, allowed, unit = line.split("\t")
        key = (subject, quantity, authority)
        if key not in largest or float(measured) > largest[key][1]:
            largest[key] = (int(number), float(measured), float(allowed), unit)
    return largest


def accuracy(path):
    largest = largest_differences(path)
    unlisted = {subject for subject, _, _ in largest} - {subject for _, _, subjects in TABLES for subject in subjects}
    if unlisted:
        raise SystemExit(f"docs/tables.py: TABLES does not list the files of tests {', '.join(sorted(unlisted))}")
    print(f"<!-- Made by docs/tables.sh on {date.today()}; do not edit. -->\n")
    print(f"{len(largest)} comparisons, measured on {date.today()}.")
    for title, text, subjects in TABLES:
        print(f"\n### {title}\n\n{textwrap.fill(text, 120)}\n")
        print("| quantity | compared with | largest difference | bound |\n|---|---|---|---|")
        rows = [(quantity, authority, row) for (subject, quantity, authority), row in largest.items() if subject in subjects]
        for quantity, authority, (number, measured, allowed, unit) in sorted(rows):
            numbers = "1 value" if number == 1 else f"{number:,} values"
            print(f"| {quantity} | {authority}, {numbers} | {in_unit(measured, unit)} | {in_unit(allowed, unit)} |")


def lu2024(path):
    def text(number):
        if not number:
            return ""
        value = float(number)
        if abs(value) >= 1000 or value == int(value):
            return f"{value:.0f}"
        return f"{value:.5g}" if abs(value) >= 0.001 else f"{value:.6f}".rstrip("0")

    print("| section | quantity | unit | paper | ours | +- |\n|---|---|---|---:|---:|---:|")
    lines = [line for line in Path(path).read_text().splitlines() if not line.startswith("#")]
    for row in csv.DictReader(lines):
        numbers = [text(row[column]) for column in ("paper", "ours", "ours_sigma")]
        print("| " + " | ".join([row["section"], row["quantity"], row["unit"], *numbers]) + " |")


if __name__ == "__main__":
    if sys.argv[1] == "--lu2024":
        lu2024(sys.argv[2])
    else:
        accuracy(sys.argv[1])
