"""Compares verdicts on Rubin visits with old and with current element sets: writes `docs/tables/verdicts.md`.

    STREAKCAST_DATA=... STREAKCAST_BIN=... python tests/reference/verdicts_by_age.py docs/tables/verdicts.md

The visits are those of the first 13 nights of schedules/baseline_10klines_2.0.db, a simulated survey in October 2023,
most of them of 30 s. Daily catalogues exist only for June 2026, so each night is moved to one of June 2026. A visit
keeps its altitude and azimuth, and its time after sunset (before local midnight, 25 min earlier) or before sunrise
(after midnight, 85 min later); its right ascension increases by the difference of the sidereal times. The current
elements of a satellite are the set closest to the middle of the night among the files of that day and the next two,
with the published drag for all rows of the table. Elements N days older are those in the file of N days before the
night; their epochs are up to two days older than the file. A second file, of 7 days before these, is used in a third
row. Verdicts are computed by `flag` with a field of 3.5 deg and a limit of V = 7 mag.

"changed" is the fraction of visits with another verdict (clear, streaked, avoid). "expected" is the fraction that
`flag` computes only from the elements of that age: the mean of p_crossing over clear visits and of 1 - p_crossing over
all others. It includes only changes between clear and not clear, and is compared with the column of these changes.
Takes about two minutes.
"""

import argparse
import json
import os
import sqlite3
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("STREAKCAST_DATA") or ROOT.parent / "shared/data")
BINARY = os.environ.get("STREAKCAST_BIN") or ROOT / "target/release/streakcast"
AGES_DAY = (1, 3, 7)
# Drag, and days from the elements of each age back to those of a second file.
MODELS = {"published": ("published", ()), "station-keeping": ("station-keeping", ()), "station-keeping, and elements of 7 days before": ("station-keeping", (7,))}
# The nights of the survey are moved to successive nights, of which the first ends on this day of June.
FIRST_NIGHT = 15
MJD_2026_05_31 = 61191
# Local midnight in days after 0 h UTC of the date of the evening, and the time shifts of the two halves of the night,
# min.
MIDNIGHT, EVENING_MIN, MORNING_MIN = 1.197, -25, 85
# Mean sidereal days in a day, IAU 2006 to first order.
SIDEREAL_RATE = 1.00273781191135


def elements(day):
    return DATA / f"tle/daily_2026-06/starlink_2026-06-{day:02d}.tle.gz"


def nights():
    """Returns the visits of the survey, by night."""
    columns = "observationStartMJD, fieldRA, fieldDec, rotSkyPos, visitExposureTime"
    found = {}
    for visit in sqlite3.connect(DATA / "schedules/baseline_10klines_2.0.db").execute(f"SELECT {columns} FROM observations ORDER BY 1"):
        # The evening is before 0 h UTC.
        found.setdefault(int(visit[0] - 0.5), []).append(visit)
    return found


def schedule(folder, evening, visits, night):
    """Writes the visits, moved to the night that ends on a day of June 2026, to a file, and returns its path."""
    path = Path(folder) / f"{night}.csv"
    with path.open("w") as file:
        file.write("id,start_mjd_utc,ra_deg,dec_deg,rotation_deg,duration_s\n")
        for number, (mjd, ra_deg, dec_deg, rotation_deg, exposure_s) in enumerate(visits):
            minutes = EVENING_MIN if mjd < evening + MIDNIGHT else MORNING_MIN
            days = MJD_2026_05_31 + night - 1 - evening + minutes / 1440
            ra_deg = (ra_deg + 360 * days * SIDEREAL_RATE) % 360
            file.write(f"{number},{mjd + days:.9f},{ra_deg:.6f},{dec_deg:.6f},{rotation_deg:.4f},{exposure_s}\n")
    return path


def verdicts(visits, files, drag):
    command = [BINARY, "flag", "--schedule", visits, "--mpc", "X05", "--fov", "3.5deg", "--limit-mag", "7", "--max-delay", "1s"]
    run = subprocess.run([*command, "--drag", drag, "--format", "json", "--quiet", "--elements", *files], capture_output=True, text=True, check=True)
    return [(one["verdict"], one["p_crossing"]) for one in json.loads(run.stdout)["flags"]]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output")
    output = parser.parse_args().output
    cells = {(age, model): [0, 0, 0.0] for age in AGES_DAY for model in MODELS}
    total, kinds = 0, {}
    with tempfile.TemporaryDirectory() as folder:
        for night, (evening, visits) in enumerate(nights().items(), FIRST_NIGHT):
            visits = schedule(folder, evening, visits, night)
            truth = verdicts(visits, [elements(night + days) for days in range(3)], "published")
            total += len(truth)
            for verdict, _ in truth:
                kinds[verdict] = kinds.get(verdict, 0) + 1
            for age, model in cells:
                drag, before = MODELS[model]
                old = verdicts(visits, [elements(night - age - days) for days in (0, *before)], drag)
                cell = cells[age, model]
                cell[0] += sum(a != b for (a, _), (b, _) in zip(truth, old))
                cell[1] += sum((a == "clear") != (b == "clear") for (a, _), (b, _) in zip(truth, old))
                cell[2] += sum(p if kind == "clear" else 1 - p for kind, p in old)
    with open(output, "w") as file:
        numbers = ", ".join(f"{number:,} {verdict}" for verdict, number in kinds.items())
        file.write(f"Verdicts of the {total:,} visits with the elements of the night: {numbers}.\n\n")
        file.write("| elements older by | drag | verdict changed | changed between clear and not clear | expected |\n|---|---|---|---|---|\n")
        for (age, model), (changed, clear, expected) in cells.items():
            share = lambda count: f"{100 * count / total:.1f} %"
            file.write(f"| {age} d | {model} | {share(changed)} ({changed}) | {share(clear)} ({clear}) | {share(expected)} |\n")


if __name__ == "__main__":
    main()
