"""Lateness of Starlinks by class and age of the elements, as the command line predicts it: writes docs/tables/lateness.md.

    STREAKCAST_DATA=... STREAKCAST_BIN=... python tests/reference/positions_by_age.py docs/tables/lateness.md

The data are the daily Starlink catalogues of June 2026, odd catalogue numbers, and element sets of 15 to 29 June; the coefficients of src/orbit/station_keeping.rs and src/orbit/starlink_lateness.rs were fitted to even numbers.
`streakcast ephemeris` predicts each satellite at the epoch of a later element set, to 1.5 hours, with four selections of
older elements:

    published    the newest set with its published drag
    one          the newest set
    two          the newest set and that of 7 days before
    four         the newest set and those of 3, 7 and 14 days before

The truth is the later element set at its own epoch. The lateness is the distance along the track to the truth, as an
angle about the Earth's centre, in seconds of the period. Only satellites that have all these sets are counted, except in
the first 14 days of the month. "inside" is the share of satellites with a stated sigma whose lateness is at most
`along_track_sigma_s`.

Requires numpy. Takes about half an hour.
"""

import argparse
import csv
import datetime
import gzip
import os
import re
import subprocess
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("STREAKCAST_DATA") or ROOT.parent / "shared/data")
BINARY = os.environ.get("STREAKCAST_BIN") or ROOT / "target/release/streakcast"
# The file of 22 June has the elements of 21 June.
STARTS, AGES_DAY = (15, 16, 17, 18, 19, 20, 21, 23, 24, 25, 26, 27, 28, 29), (1, 3, 7, 14)
# Fewer satellites have no share inside their sigmas.
LEAST_STATED = 20
SELECTIONS = {"published": (), "one": (), "two": (7,), "four": (3, 7, 14)}
CLASSES = ("V1.5", "VisorSat, V2 Mini", "V2 Mini, strong drag", "Direct-to-Cell", "V2 Mini, parked", "V2 Mini, raising", "V1.5, moving", "V1.0, descending")
# Acceptance: largest half width with 68 % at 1 and 7 days with one older set, s, and the range of the share inside, %.
LIMITS_S = {"V1.5": (0.55, 1.7), "VisorSat, V2 Mini": (0.70, 1.6), "V2 Mini, strong drag": (1.6, 4.0), "Direct-to-Cell": (0.75, 1.4)}
MU_KM3_S2, EARTH_RADIUS_KM = 398600.8, 6378.135
STEP_S, BIN_HOURS = 10.0, 3
SITE_LATITUDE_DEG, SITE_LONGITUDE_DEG = -30.2446, -70.7494
UTC = datetime.timezone.utc


def launches():
    table = {}
    for line in (ROOT / "src/elements/launches.txt").read_text().splitlines():
        if match := re.match(r"starlink-(\S+):(.*)", line):
            table |= dict.fromkeys(match[2].split(), match[1])
    return table


def path(day):
    return DATA / f"tle/daily_2026-06/starlink_2026-06-{day:02d}.tle.gz"


def read(day):
    """Returns name, epoch, mean motion (rev/day), half of its derivative and launch by catalogue number, for odd numbers."""
    found = {}
    lines = gzip.open(path(day), "rt").read().splitlines()
    for name, first, second in zip(lines[0::3], lines[1::3], lines[2::3]):
        if first[2:7].isdigit() and int(first[2:7]) % 2:
            epoch = datetime.datetime(2026, 1, 1, tzinfo=UTC) + datetime.timedelta(days=float(first[20:32]) - 1)
            year = int(first[9:11]) + (2000 if int(first[9:11]) < 57 else 1900) if first[9:11].strip() else 0
            found[int(first[2:7])] = (name.strip(), epoch, float(second[52:63]), float(first[33:43]), f"{year}-{first[11:14]}")
    return found


def class_of(record, table):
    """Returns the class by the rules of src/orbit/station_keeping.rs."""
    name, _, n, change, launch = record
    number = re.match(r"STARLINK-(\d+)", name)
    height_km = (MU_KM3_S2 / (n * 2 * np.pi / 86400) ** 2) ** (1 / 3) - EARTH_RADIUS_KM
    if "[DTC]" in name or (number and 11_000 <= int(number[1]) <= 11_999):
        return "V2 Mini, raising" if change <= -1e-3 else "Direct-to-Cell"
    kind = "visorsat" if number and int(number[1]) == 1436 else table.get(launch, "v2mini")
    if kind == "v1.5":
        return "V1.5" if abs(change) <= 1e-4 else "V1.5, moving"
    if kind == "visorsat" and abs(change) <= 3e-4:
        return "VisorSat, V2 Mini"
    if kind != "v2mini":
        return "V1.0, descending"
    if change <= -1e-3:
        return "V2 Mini, raising"
    if height_km < 450:
        return "V2 Mini, parked"
    if abs(change) <= 3e-4:
        return "VisorSat, V2 Mini"
    return "V2 Mini, strong drag" if change <= 2e-3 else "V2 Mini, raising"


def predicted(numbers, days, drag, times):
    """Returns topocentric positions (km, ICRS), one for each time, and the stated sigma, by catalogue number."""
    # Angles and distances with all digits are in the table as CSV.
    command = [BINARY, "ephemeris", "--quiet", "--format", "csv", "--mpc", "X05", "--drag", drag, "--times", *times]
    command += ["--elements", *(path(day) for day in days), "--norad", *map(str, sorted(numbers))]
    run = subprocess.run(command, capture_output=True, text=True)
    # 1: none of the satellites can be propagated.
    if run.returncode not in (0, 1):
        raise SystemExit(run.stderr)
    text = run.stdout
    found = defaultdict(list)
    for row in csv.DictReader(line for line in text.splitlines() if not line.startswith("#")):
        ra, dec, distance = np.radians(float(row["ra_deg"])), np.radians(float(row["dec_deg"])), float(row["range_km"])
        unit = np.array([np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)])
        # Without a sigma, every position along the orbit is equally likely.
        found[int(row["norad_id"])].append((distance * unit, float(row["along_track_sigma_s"] or "nan")))
    return found


def site_velocity(time):
    """Returns the velocity of the site by the rotation of the Earth, km/s."""
    days = (time - datetime.datetime(2000, 1, 1, 12, tzinfo=UTC)).total_seconds() / 86400
    sidereal = np.radians(280.46 + 360.98564737 * days + SITE_LONGITUDE_DEG)
    return 7.2921e-5 * 6378.137 * np.cos(np.radians(SITE_LATITUDE_DEG)) * np.array([-np.sin(sidereal), np.cos(sidereal), 0.0])


def lateness(start, age, catalogues):
    """Returns rows of class, selection, lateness and stated sigma."""
    table = launches()
    newest, later = catalogues[start], catalogues[start + age]
    bins = defaultdict(list)
    for number, record in newest.items():
        truth = later.get(number)
        others = all(number in catalogues[start - days] for days in (3, 7, 14) if start - days > 0)
        if truth and others and (truth[1] - record[1]).total_seconds() > 0.2 * 86400:
            middle = truth[1] + datetime.timedelta(hours=BIN_HOURS / 2)
            bins[middle.replace(hour=middle.hour // BIN_HOURS * BIN_HOURS, minute=0, second=0, microsecond=0)].append(number)
    for time, numbers in bins.items():
        times = [(time + datetime.timedelta(seconds=s)).strftime("%Y-%m-%dT%H:%M:%SZ") for s in (0, STEP_S)]
        truths = predicted(numbers, [start + age], "published", times)
        for selection, before in SELECTIONS.items():
            days = [start, *(start - days for days in before if start - days > 0)]
            ours = predicted(numbers, days, "published" if selection == "published" else "station-keeping", times[:1])
            for number in numbers:
                if len(truths[number]) < 2 or not ours[number]:
                    continue
                (here, _), (next_, _) = truths[number]
                velocity = (next_ - here) / STEP_S + site_velocity(time)
                (there, sigma_s), = ours[number]
                ahead_km = there - here
                along_km = ahead_km @ velocity / np.linalg.norm(velocity)
                # The chord as an angle about the Earth's centre; it is along the track if it is long.
                n = newest[number][2]
                radius_km = (MU_KM3_S2 / (n * 2 * np.pi / 86400) ** 2) ** (1 / 3)
                chord_km = along_km if abs(along_km) < 100 else np.copysign(np.linalg.norm(ahead_km), along_km)
                turns = np.arcsin(np.clip(chord_km / (2 * radius_km), -1, 1)) / np.pi
                yield class_of(newest[number], table), selection, turns * 86400 / n, sigma_s


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output")
    parser.add_argument("--starts", type=int, nargs="+", default=STARTS)
    given = parser.parse_args()
    catalogues = {day: read(day) for day in range(1, 31)}
    cells = defaultdict(list)
    pairs = [(start, age) for start in given.starts for age in AGES_DAY if start + age <= 30]
    # The work is done by other processes.
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for (start, age), found in zip(pairs, pool.map(lambda pair: list(lateness(*pair, catalogues)), pairs)):
            for its, selection, late_s, sigma_s in found:
                cells[its, age, selection].append((late_s, sigma_s))
            print("element sets of", start, "June,", age, "d later", flush=True)
    rows = []
    for its in CLASSES:
        for age in AGES_DAY:
            cell = f"| {its} | {age} | {len(cells[its, age, 'one']):,} |"
            for selection in SELECTIONS:
                values = np.array(cells[its, age, selection]).reshape(-1, 2)
                half_width = np.quantile(np.abs(values[:, 0]), 0.6827)
                stated = values[np.isfinite(values[:, 1])]
                if selection == "published":
                    cell += f" {half_width:.2f} |"
                elif len(stated) < LEAST_STATED:
                    cell += f" {half_width:.2f}, unknown |"
                else:
                    inside = 100 * np.mean(np.abs(stated[:, 0]) <= stated[:, 1])
                    cell += f" {half_width:.2f}, {np.median(stated[:, 1]):.2f}, {inside:.0f} % |"
                if selection == "two" and its in LIMITS_S and age in (1, 7):
                    limit_s = LIMITS_S[its][age == 7]
                    print(f"{its}, {age} d: {half_width:.2f} s, allowed {limit_s} s: {'met' if half_width <= limit_s else 'NOT MET'}")
            rows.append(cell)
    with open(given.output, "w") as file:
        file.write("| class | age, days | satellites | published: 68 % | one set: 68 %, stated, inside | two sets | four sets |\n|---|---|---|---|---|---|---|\n")
        file.writelines(row + "\n" for row in rows)


if __name__ == "__main__":
    main()
