"""Fits the errors of element sets as a function of age: coefficients of src/orbit/uncertainty.rs, and a check of them.

An element set is propagated by SGP4 to the epoch of another one of the same object and compared with it: time
difference along the track (s), and distance across it, normal to the orbital plane and in radius (km). Objects with an
even catalogue number are fitted; those with an odd number are used for the check. "68 %" is the 68.27 % quantile of the
absolute residual, which is an appropriate one-sigma half width also for long tails; 1.4826 MAD is printed for
comparison.

    along² = floor² + (k1 age)² + (k2 age²)² + (c drag age²)² + (f drag^q age^p)²    s
    cross² = floor² + (kx age^px)² + (cx shift age)²                                 km

with the age in days, drag = |ndot/2| P in s/day², shift = 4/3 a |ndot/2| / n in km/day. Along is at most 0.3413 P (all
positions along the orbit equally probable), cross at most 1,000 km.

    STREAKCAST_DATA=... python tests/reference/calibrate_orbit_uncertainty.py tests/data/orbit_residuals.csv

Requires numpy, scipy and sgp4. Takes about five minutes.
"""

import argparse
import collections
import csv
import datetime
import io
import json
import os
import re
from pathlib import Path

import numpy as np
import sgp4
from scipy.optimize import minimize
from sgp4 import omm
from sgp4.api import WGS72, Satrec

DATA = Path(os.environ.get("STREAKCAST_DATA") or Path(__file__).resolve().parents[3] / "shared/data")
SOURCES = {
    "72 Starlink, daily, 2026": ["derived/starlink_tle_history_2026-05-29_2026-08-21_sel.tle"],
    "Starlink 2026-05-29, 08-21": ["tle/daily/starlink_2026-05-29.tle", "tle/daily/starlink_2026-08-21.tle"],
    "histories": [f"tle/history/{name}" for name in (
        "50001.txt", "Sentinel-6A.tle", "starlink_44238.txt", "starlink_44249.txt", "starlink_44278.txt",
        "starlink_44713.txt", "starlink_44714.txt", "starlink_44724.txt")],
    "supplemental 2020-02": ["tle/supgp/starlink_supgp_2020-02-23.tle", "tle/supgp/starlink_supgp_2020-02-25.tle"],
    "winter 2020/21": ["tle/frames_2020/starlink_2020-11-16.txt", "tle/mmt_2021/active_2020-12-01.txt"] + [
        f"tle/mmt_2021/starlink_{day}.txt" for day in ("2020-12-27", "2020-12-29", "2021-01-01", "2021-01-07", "2021-02-19", "2021-03-15")],
    "2022": ["tle/pomenis_2022/active_2022-01-06.tle", "tle/pomenis_2022/20220505-174625.csv", "tle/pomenis_2022/starlink_2022-08-31.txt",
             "tle/pomenis_2022/starlink_2022-10-25.txt", "tle/pomenis_2022/active_2022-11-03.txt", "tle/pomenis_2022/starlink_2022-12-02.txt"],
    "2023": ["tle/fullcat/TLE3_2023-04-07.txt", "tle/messy/active_gp_2023-06-21_dups.txt", "tle/omm/starlink_satellites_2023-07-17.omm.json"],
    "Swift and its visitor, 2026": ["tle/omm/2004-047A.csv", "tle/omm/2026-152A.csv"],
}  # fmt: skip
AGES_DAY = (0.3, 0.5, 0.75, 1, 1.5, 2, 3, 4, 5, 7, 10, 14, 20, 30, 45, 60, 90, 120, 180, 250, 365)
CAP_OF_PERIOD = 0.3413
CROSS_CAP_KM = 1000.0
# About 1 km along the track at epoch: it is not visible in differences of sets that share observations. Across the
# track: streaks of known satellites differ from their element sets by 50 arcsec in the median on frames of the Plaskett
# telescope (photometry/boley2021_plaskett), which corresponds to a sigma of 74 arcsec, 0.3 km at 800 km.
ALONG_FLOOR_KM, CROSS_FLOOR_KM = 1.0, 0.3
KINDS = ("OnStation", "Manoeuvring", "LowEarth", "MediumEarth", "Geosynchronous", "Eccentric")
CONSTELLATIONS = ("STARLINK", "ONEWEB", "KUIPER", "QIANFAN", "HULIANWANG")
# Inclinations (deg) and mean altitudes (km) of constellations, for element sets without a name.
SHELLS = (
    ((43.0, 53.05, 53.16, 70.0, 97.3, 97.65), 200.0, 620.0),
    ((87.9,), 450.0, 1250.0),
    ((33.0, 42.0, 51.9), 380.0, 660.0),
    ((89.0,), 380.0, 1180.0),
    ((50.0, 86.5), 500.0, 1200.0),
)
MANOEUVRING_REV_DAY2 = 3e-4


class Elements:
    """One element set, with the quantities from which its class is determined."""

    def __init__(self, name, satellite):
        self.name, self.satellite, self.norad = name.upper(), satellite, satellite.satnum
        self.epoch = satellite.jdsatepoch + satellite.jdsatepochF
        self.rev_day = satellite.no_kozai * 1440 / (2 * np.pi)
        self.period_s = 86400 / self.rev_day
        self.axis_km = (398600.8 / (satellite.no_kozai / 60) ** 2) ** (1 / 3)
        self.half_ndot = satellite.ndot / (2 * np.pi) * 1440**2

    def kind(self):
        s = self.satellite
        if s.ecco > 0.1:
            return "Eccentric"
        if self.period_s > 128 * 60:
            return "Geosynchronous" if self.period_s > 1200 * 60 else "MediumEarth"
        if abs(self.half_ndot) > MANOEUVRING_REV_DAY2 and self.constellation():
            return "Manoeuvring"
        return "OnStation" if self.constellation() else "LowEarth"

    def constellation(self):
        if self.name and not re.match("OBJECT|TBA|[0-9]", self.name):
            return self.name.startswith(CONSTELLATIONS)
        inclination, altitude = np.degrees(self.satellite.inclo), self.axis_km - 6378.135
        return self.satellite.ecco < 0.003 and any(
            low < altitude < high and min(abs(inclination - i) for i in shell) < 0.25 for shell, low, high in SHELLS
        )


def read(path):
    text = (DATA / path).read_text(errors="replace").lstrip("\ufeff")
    if "/omm/" in path:
        rows = json.loads(text) if path.endswith("json") else csv.DictReader(io.StringIO(text))
        for row in rows:
            row = {key: str(value) for key, value in row.items()} | {"EPHEMERIS_TYPE": "0"}
            for key in ("NORAD_CAT_ID", "REV_AT_EPOCH", "ELEMENT_SET_NO"):
                row[key] = str(int(float(row[key])))
            row["EPOCH"] += "" if "." in row["EPOCH"] else ".0"
            satellite = Satrec()
            omm.initialize(satellite, row)
            yield Elements(row["OBJECT_NAME"], satellite)
        return
    if path.endswith("csv"):
        triples = [(row["ObjectName"], row["Line1"], row["Line2"]) for row in csv.DictReader(io.StringIO(text))]
    else:
        lines, triples, name = [line.rstrip() for line in text.splitlines()], [], ""
        for first, second in zip(lines, lines[1:] + [""]):
            if first.startswith("1 ") and second.startswith("2 "):
                triples.append((name, first, second))
                name = ""
            elif not first.startswith("2 "):
                name = first.removeprefix("0 ").strip()
    for name, first, second in triples:
        if len(first) >= 68 and len(second) >= 68:
            try:
                yield Elements(name, Satrec.twoline2rv(first, second, WGS72))
            except ValueError:
                continue


def compare(old, true):
    """Returns the error of `old` at the epoch of `true`: s along the track, km out of plane and in radius, or None."""
    error, predicted, _ = old.sgp4(true.jdsatepoch, true.jdsatepochF)
    if error:
        return None
    predicted, shift_s = np.array(predicted), 0.0
    for _ in range(8):
        error, r, v = true.sgp4_tsince(shift_s / 60)
        if error:
            return None
        r, v = np.array(r), np.array(v)
        normal = np.cross(r, v) / np.linalg.norm(np.cross(r, v))
        forward = np.cross(normal, r) / np.linalg.norm(r)
        step = np.arctan2(predicted @ forward, predicted @ r / np.linalg.norm(r)) * np.linalg.norm(r) / (v @ forward)
        shift_s += step
        if abs(step) < 1e-6:
            break
    answer = shift_s, predicted @ normal, np.linalg.norm(predicted) - np.linalg.norm(true.sgp4_tsince(shift_s / 60)[1])
    return answer if np.isfinite(answer).all() else None


Residual = collections.namedtuple("Residual", "source norad kind half_ndot period_s axis_km age along plane radius")


def residuals(source, paths, random):
    objects = collections.defaultdict(dict)
    for path in paths:
        for elements in read(path):
            objects[elements.norad][round(elements.epoch, 6)] = elements
    for norad, sets in objects.items():
        sets = [sets[epoch] for epoch in sorted(sets)]
        epochs = np.array([elements.epoch for elements in sets])
        chosen = range(len(sets)) if len(sets) <= 120 else random.choice(len(sets), 120, replace=False)
        for i in chosen:
            done = {i}
            for age in AGES_DAY:
                for sign in (1, -1):
                    j = int(np.argmin(np.abs(epochs - epochs[i] - sign * age)))
                    span = epochs[j] - epochs[i]
                    if j in done or not 0.8 < sign * span / age < 1.25:
                        continue
                    done.add(j)
                    answer = compare(sets[i].satellite, sets[j].satellite)
                    if answer:
                        old = sets[i]
                        yield Residual(source, norad, old.kind(), old.half_ndot, old.period_s, old.axis_km, span, *answer)


def columns(rows):
    return {name: np.array([getattr(row, name) for row in rows]) for name in Residual._fields[3:]}


def drag_s_day2(c):
    return np.abs(c["half_ndot"]) * c["period_s"]


def shift_km_day(c):
    return 4 / 3 * c["axis_km"] * np.abs(c["half_ndot"]) * c["period_s"] / 86400


def along_sigma(c, k1, k2, drag=0.0, short=0.0, power=2.0, drag_power=1.0):
    age = np.abs(c["age"])
    speed_km_s = 2 * np.pi * c["axis_km"] / c["period_s"]
    square = (ALONG_FLOOR_KM / speed_km_s) ** 2 + (k1 * age) ** 2 + (k2 * age**2) ** 2
    square = square + (drag * drag_s_day2(c) * age**2) ** 2 + (short * drag_s_day2(c) ** drag_power * age**power) ** 2
    return np.minimum(np.sqrt(square), CAP_OF_PERIOD * c["period_s"])


def cross_sigma(c, k, power, drag=0.0):
    age = np.abs(c["age"])
    square = CROSS_FLOOR_KM**2 + (k * age**power) ** 2 + (drag * shift_km_day(c) * age) ** 2
    return np.minimum(np.sqrt(square), CROSS_CAP_KM)


def cells(c, deep):
    """Returns groups of unsaturated residuals by age (six per decade) and, near the Earth, by drag (half decades)."""
    age = np.round(np.log10(np.abs(c["age"])) * 6)
    drag = np.zeros_like(age) if deep else np.clip(np.round(np.log10(np.abs(c["half_ndot"]) + 1e-12) * 2), -14, -4)
    _, index = np.unique(age * 1000 + drag, return_inverse=True)
    groups = [g for g in (np.flatnonzero(index == i) for i in range(index.max() + 1)) if len(g) >= 12]
    # If any position along the orbit is possible, the cell contains no information on growth (nor across the track).
    lost = lambda g: not deep and np.quantile(np.abs(c["along"][g]), 0.6827) > 0.3 * np.median(c["period_s"][g])
    return [g for g in groups if not lost(g)]


# Bounds of the fitted coefficients and exponents.
LEAST, MOST = 1e-4, 1e3
EXPONENTS = (0.3, 2.5)


def fit(c, sigma, value, starts, exponents, groups):
    """Fits coefficients so that the 68 % quantile of |residual| / sigma is 1 in every cell (in logarithms)."""
    # Cells with an age of days have a larger weight than cells with months, as in typical use.
    weight = np.array([np.sqrt(min(len(g), 400)) * (1.0 if np.median(np.abs(c["age"][g])) < 30 else 0.5) for g in groups])
    bounds = np.log([EXPONENTS if i in exponents else (LEAST, MOST) for i in range(len(starts[0]))])

    def cost(logs):
        inside = np.clip(logs, bounds[:, 0], bounds[:, 1])
        ratio = np.abs(value) / sigma(c, *np.exp(inside))
        misfit = np.log(np.array([np.quantile(ratio[g], 0.6827) for g in groups]) + 1e-3)
        return np.sum(weight * misfit**2) + 1e3 * np.sum((logs - inside) ** 2)

    options = {"xatol": 1e-3, "fatol": 1e-3, "maxiter": 4000, "maxfev": 3000}
    best = min((minimize(cost, np.log(start), method="Nelder-Mead", options=options) for start in starts), key=lambda r: r.fun)
    return np.exp(np.clip(best.x, bounds[:, 0], bounds[:, 1]))


def both_axes(c):
    """Returns every residual twice, for each of the two axes across the track, which have the same sigma."""
    twice = {name: np.concatenate([values, values]) for name, values in c.items()}
    return twice, np.concatenate([c["plane"], c["radius"]])


def coverage(value, sigma):
    return np.mean(np.abs(value) <= sigma)


def table(title, c, parameters_along, parameters_cross):
    print(f"\n{title}\n   age, days       n  along 68 %  1.4826 MAD   sigma     inside | back: n  68 %   inside | plane 68 %  radius 68 %   sigma  inside")
    edges = (0.2, 0.6, 1.4, 2.5, 4.5, 8.5, 12, 17, 25, 40, 70, 100, 150, 220, 400)
    for low, high in zip(edges, edges[1:]):
        f = (c["age"] >= low) & (c["age"] < high)
        b = (-c["age"] >= low) & (-c["age"] < high)
        if f.sum() < 20:
            continue
        part = {name: values[f] for name, values in c.items()}
        back = {name: values[b] for name, values in c.items()}
        sigma, backward, across = along_sigma(part, *parameters_along), along_sigma(back, *parameters_along), cross_sigma(part, *parameters_cross)
        q = lambda x: np.quantile(np.abs(x), 0.6827) if len(x) else np.nan
        mad = 1.4826 * np.median(np.abs(part["along"] - np.median(part["along"])))
        print(f"  {low:5.1f} ..{high:5.1f}  {f.sum():6d} {q(part['along']):10.2f} {mad:10.2f} {np.median(sigma):10.2f}   {100 * coverage(part['along'], sigma):5.0f} %"
              f" | {b.sum():6d} {q(back['along']):8.2f} {100 * coverage(back['along'], backward) if b.sum() else np.nan:5.0f} %"
              f" | {q(part['plane']):8.2f} {q(part['radius']):8.2f} {np.median(across):8.2f}  {50 * (coverage(part['plane'], across) + coverage(part['radius'], across)):5.0f} %")  # fmt: skip


def on_station_truth():
    """Tests the rule for on-station satellites: |da/dt| < 100 m/day over three sets, without the height limit."""
    objects = collections.defaultdict(list)
    for elements in read(SOURCES["72 Starlink, daily, 2026"][0]):
        objects[elements.norad].append(elements)
    called, true = [], []
    for sets in objects.values():
        sets.sort(key=lambda e: e.epoch)
        for before, here, after in zip(sets, sets[1:], sets[2:]):
            rates = [(b.axis_km - a.axis_km) / (b.epoch - a.epoch) for a, b in ((before, here), (here, after)) if b.epoch > a.epoch]
            if rates:
                true.append(max(map(abs, rates)) < 0.1)
                called.append(here.kind() == "OnStation")
    called, true = np.array(called), np.array(true)
    print(f"\nOne set of the 72 satellites against three (|da/dt| < 100 m/day): n {len(true)}, on station {true.mean():.3f}; right {np.mean(called == true):.3f};"
          f" correct among those on station {called[true].mean():.3f}; correct among those that manoeuvre {1 - called[~true].mean():.3f}")  # fmt: skip
    worst = true != called
    print(f"  disagreements: {np.sum(worst & called)} classified as on station but moving, {np.sum(worst & ~called)} the other way")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output")
    output = parser.parse_args().output
    random = np.random.default_rng(12)
    rows = []
    for source, paths in SOURCES.items():
        new = list(residuals(source, paths, random))
        rows += new
        print(f"{source}: {len({r.norad for r in new})} objects, {len(new)} residuals", dict(collections.Counter(r.kind for r in new)), flush=True)
    on_station_truth()
    lines = []
    for kind in KINDS:
        mine = [r for r in rows if r.kind == kind and abs(r.age) < 400]
        # Sentinel-6A and the geostationary history are the only objects of their classes: one part of each is fitted,
        # the other is used for the check.
        even = [r for i, r in enumerate(mine) if (r.norad % 2 == 0 if r.norad not in (46984, 50001) else i // 40 % 2 == 0)]
        held = [r for i, r in enumerate(mine) if (r.norad % 2 == 1 if r.norad not in (46984, 50001) else i // 40 % 2 == 1)]
        forward = columns([r for r in even if r.age > 0])
        deep = kind in ("MediumEarth", "Geosynchronous", "Eccentric")
        if deep:  # their published ndot is caused by Sun and Moon
            starts, exponents = [(1.0, 0.1), (0.1, 0.01)], ()
        elif kind == "LowEarth":  # an error of the drag: p = 2, q = 1; too few objects for more parameters
            starts, exponents = [(0.02, 0.002, 0.3), (0.1, 0.01, 0.3)], ()
        else:
            starts, exponents = [(0.4, 0.02, 1.5, 2.0, 1.2, 0.4), (0.4, 0.02, 0.5, 2.0, 1.7, 0.7), (0.4, 0.1, 1.0, 1.5, 2.2, 0.6)], (4, 5)
        along = fit(forward, along_sigma, forward["along"], starts, exponents, cells(forward, deep))
        twice, value = both_axes(forward)
        starts = [(3.0, 0.8), (0.2, 0.8)] if deep else [(0.15, 1.0, 1.0), (0.15, 1.5, 0.5)]
        cross = fit(twice, cross_sigma, value, starts, (1,), cells(twice, deep))
        print(f"\n{kind}: along " + ", ".join(f"{n} {x:.3g}" for n, x in zip(("k1", "k2", "c", "f", "p", "q"), along))
              + "; cross " + ", ".join(f"{n} {x:.3g}" for n, x in zip(("kx", "px", "cx"), cross)))  # fmt: skip
        c = columns(held)
        table(f"{kind}, held out ({len({r.norad for r in held})} objects)", c, along, cross)
        ahead = [r for r in held if r.age > 0]
        chosen = random.permutation(len(ahead))
        # Equal numbers from every octave of age, and a limited number per object.
        octave, often = collections.defaultdict(list), collections.Counter()
        for i in chosen:
            r, key = ahead[i], int(np.floor(np.log2(ahead[i].age)))
            if len(octave[key]) < 40 and often[key, r.norad] < 12:
                octave[key].append(r)
                often[key, r.norad] += 1
        for members in octave.values():
            for r in members:
                lines.append((kind, f"{r.half_ndot:.3e}", f"{r.period_s / 60:.3f}", f"{r.age:.3f}", f"{r.along:.3f}", f"{r.plane:.3f}", f"{r.radius:.3f}"))
    with open(output, "w") as file:
        file.write(
            f"# origin: tests/reference/calibrate_orbit_uncertainty.py, {datetime.date(2026, 11, 21)}; python-sgp4 {sgp4.__version__}, WGS72\n"
            "# an element set propagated to the epoch of a newer one of the same object, objects held out of the fit, at most 40 an octave of age and 12 an object in it\n"
            "kind,mean_motion_dot_rev_day2,period_min,age_days,along_track_s,out_of_plane_km,radial_km\n"
        )
        for line in sorted(lines, key=lambda line: (KINDS.index(line[0]), float(line[3]))):
            file.write(",".join(line) + "\n")
    print(f"\n{len(lines)} held-out residuals written")


if __name__ == "__main__":
    main()
