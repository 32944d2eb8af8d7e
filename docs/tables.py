"""What docs/tables.sh measured, as Markdown on standard output: `tables.py accuracy FIGURES`, `tables.py speed FOLDER`."""

import os
import platform
import re
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


def machine():
    """What it was measured on."""
    name = platform.processor() or platform.machine()
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            name = line.partition(":")[2].strip()
            break
    return f"{os.cpu_count()} cores of {name}"


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


def benches(text):
    """Rows of divan's trees: name with its parents, fastest, median."""
    parents = []
    for line in text.splitlines():
        if found := re.match(r"^(\S+)\s+fastest", line):
            parents = [found[1]]
            continue
        found = re.match(r"^([│ ]*)[├╰]─ (.+?)(?:\s{2,}|\s+│)(.*)$", line)
        if not found:
            continue
        depth = len(found[1]) // 3 + 1
        parents = parents[:depth] + [found[2].strip()]
        times = [cell.strip() for cell in f"{found[3]}".split("│")]
        if times and re.match(r"^[\d.]+ (ns|µs|ms|s)$", times[0]):
            yield " / ".join(parents), times[0], times[2]


def speed(folder):
    folder = Path(folder)
    print(f"<!-- Made by docs/tables.sh on {date.today()}; do not edit. -->\n")
    print(f"{date.today()}, {machine()}.\n")
    print("| bench | fastest | median |\n|---|---|---|")
    for name, fastest, median in benches((folder / "benches").read_text()):
        print(f"| {name} | {fastest} | {median} |")
    for peer in ("photometry", "fit", "streaks"):
        print(f"\n`tests/benches/peers/{peer}.py`, ours and the others in turn:\n\n```text\n{(folder / peer).read_text().rstrip()}\n```")


if __name__ == "__main__":
    {"accuracy": accuracy, "speed": speed}[sys.argv[1]](sys.argv[2])
