"""Fits lags and error distributions of Starlink satellites that hold their orbits (src/orbit/station_keeping.rs).

An element set is propagated to the epoch of a later element set of the same satellite. Its lateness is the time along
the track by which the satellite is behind the prediction (negative: ahead of it). "published" uses the element set as
it is, "used" B* = 0 and the mean motion n - 2 tau (ndot/2), where tau is the lag of a class in days. The fit uses even
catalogue numbers and elements of 2, 9, 16 and 23 June 2026; the errors in the report are those of odd numbers and
elements of 5, 12, 19 and 26 June.

The lateness of a class at age t (days) is a mixture of three Gaussians about 0:

    (1 - m) [0.7 N(s) + 0.3 N(r s)] + m N(s_m)      s = sqrt(s_0^2 + (k t)^2 + (c D t)^2),  m = m0 + m1 t,  s_m = v t <= 0.3413 P

with D = |ndot/2| P in s/day^2. s and r describe the core; m is the fraction of satellites that manoeuvred. The shape
(r, m0, m1, v) has the maximum likelihood. The scale (s_0, k, c) is such that one sigma, the half width that contains
68.27 % of the distribution, contains 68.27 % of the data at each age and drag.

    STREAKCAST_DATA=... python tests/reference/calibrate_station_keeping.py docs/tables/lateness.md

Lateness and distances out of plane and in radius are computed by calibrate_orbit_uncertainty.compare. Requires numpy,
scipy and sgp4. Takes about ten minutes.
"""

import argparse
import gzip
import os
import re
from pathlib import Path

import numpy as np
from scipy.optimize import minimize
from scipy.special import erf
from sgp4.api import WGS72, Satrec

from calibrate_orbit_uncertainty import compare

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("STREAKCAST_DATA") or ROOT.parent / "shared/data")
LAUNCHES = ROOT / "src/elements/launches.txt"
EVEN_STARTS, ODD_STARTS = (2, 9, 16, 23), (5, 12, 19, 26)
AGES_DAY = (1, 2, 3, 5, 7, 10, 14, 21)
CLASSES = ("Starlink15", "Starlink", "StarlinkStrongDrag", "DirectToCell")
EARTH_RADIUS_KM, MU_KM3_S2 = 6378.135, 398600.8
LABELS = {"Starlink15": "V1.5", "Starlink": "VisorSat, V2 Mini", "StarlinkStrongDrag": "V2 Mini, strong drag", "DirectToCell": "Direct-to-Cell"}
CORE_WEIGHT = 0.7
# Twice the lag, days, rounded: between the value with the smallest half width and that with the median 0 (both are
# printed).
LAG2_DAY = {"Starlink15": 0.75, "Starlink": 0.75, "StarlinkStrongDrag": 0.45, "DirectToCell": 0.33}
# Factor by which core sigmas are widened, because the dates of the check have a larger scatter than the fitted ones.
WIDENING = {"Starlink15": 1.06, "Starlink": 1.1, "StarlinkStrongDrag": 1.25, "DirectToCell": 0.98}
CAP_OF_PERIOD = 0.3413


def launches():
    table = {}
    for line in LAUNCHES.read_text().splitlines():
        if match := re.match(r"(starlink-\S+):(.*)", line):
            table |= dict.fromkeys(match[2].split(), match[1])
    return table


def read(day):
    """Returns the element sets of a day: catalogue number -> (name, line 1, line 2)."""
    path = DATA / f"tle/daily_2026-06/starlink_2026-06-{day:02d}.tle.gz"
    lines = gzip.open(path, "rt").read().splitlines()
    triples = zip(lines[0::3], lines[1::3], lines[2::3])
    return {int(first[2:7]): (name.strip(), first, second) for name, first, second in triples if first[2:7].strip().isdigit()}


def kind(name, first, table):
    number = re.match(r"STARLINK-(\d+)", name)
    if "[DTC]" in name or (number and 11_000 <= int(number[1]) <= 11_999):
        return "direct-to-cell"
    year = int(first[9:11]) + (2000 if int(first[9:11]) < 57 else 1900)
    return table.get(f"{year}-{first[11:14]}", "starlink-v2mini").removeprefix("starlink-")


def class_of(generation, half_ndot, height_km):
    change = abs(half_ndot)
    if generation == "direct-to-cell" and change <= 6e-3:
        return "DirectToCell"
    if generation in ("visorsat", "v1.5", "v2mini") and change <= 3e-4:
        return "Starlink15" if generation == "v1.5" else "Starlink"
    if generation == "v2mini" and change <= 2e-3 and height_km >= 450:
        return "StarlinkStrongDrag"
    return None


def without_drag(s, lag2_day):
    """Returns the same elements with B* = 0 and the mean motion n - 2 tau (ndot/2)."""
    half_ndot = s.ndot / (2 * np.pi) * 1440**2
    n = s.no_kozai - half_ndot * lag2_day * 2 * np.pi / 1440
    other = Satrec()
    epoch = s.jdsatepoch + s.jdsatepochF - 2433281.5
    other.sgp4init(WGS72, "a", s.satnum, epoch, 0.0, s.ndot, s.nddot, s.ecco, s.argpo, s.inclo, s.mo, n, s.nodeo)
    return other


FIELDS = ("class", "norad", "start", "nominal", "age", "half_ndot", "drag", "period", "published", "plain", "plane", "radius")


def pairs(starts, parity):
    table, days, rows = launches(), {}, []
    get = lambda day: days.setdefault(day, read(day))
    for start in starts:
        for age in AGES_DAY:
            if start + age > 30:
                continue
            later = get(start + age)
            for norad, (name, first, second) in get(start).items():
                if norad % 2 != parity or norad not in later or later[norad][1] == first:
                    continue
                s, truth = Satrec.twoline2rv(first, second, WGS72), Satrec.twoline2rv(*later[norad][1:], WGS72)
                half_ndot = s.ndot / (2 * np.pi) * 1440**2
                height_km = (MU_KM3_S2 / (s.no_kozai / 60) ** 2) ** (1 / 3) - EARTH_RADIUS_KM
                its = class_of(kind(name, first, table), half_ndot, height_km)
                days_between = truth.jdsatepoch - s.jdsatepoch + truth.jdsatepochF - s.jdsatepochF
                if its is None or days_between < 0.2:
                    continue
                period_s = 2 * np.pi / (s.no_kozai / 60)
                published, plain = compare(s, truth), compare(without_drag(s, 0.0), truth)
                if published and plain:
                    rows.append((CLASSES.index(its), norad, start, age, days_between, half_ndot, half_ndot * period_s, period_s, published[0], *plain))
    return {name: values for name, values in zip(FIELDS, np.array(rows).T)}


def q(x, share=0.6827):
    return np.quantile(np.abs(x), share)


def best_lags2(c):
    """Returns the lags with the smallest 68 % half widths of all ages (sum of logarithms), and those with median 0."""
    groups = [g for g in (np.flatnonzero(c["nominal"] == age) for age in AGES_DAY) if len(g) > 60]
    rate = c["drag"] * c["age"]
    lags = np.arange(0.0, 1.5, 0.01)
    narrowest = lags[np.argmin([sum(np.log(q(c["plain"][g] - lag2 * rate[g])) for g in groups) for lag2 in lags])]
    centred = lags[np.argmin([sum(abs(np.median(c["plain"][g] - lag2 * rate[g])) / q(c["plain"][g]) for g in groups) for lag2 in lags])]
    return narrowest, centred


def mixture(c, shape, core):
    """Returns the weights and sigmas of the three components for every row."""
    ratio, m0, m1, speed = shape
    m = np.minimum(m0 + m1 * c["age"], 0.5)
    wide = np.minimum(speed * c["age"], CAP_OF_PERIOD * c["period"])
    return ((1 - m) * CORE_WEIGHT, core), ((1 - m) * (1 - CORE_WEIGHT), ratio * core), (m, np.maximum(wide, ratio * core))


def core_of(c, scale):
    s_0, k, drag = scale
    return np.sqrt(s_0**2 + (k * c["age"]) ** 2 + (drag * c["drag"] * c["age"]) ** 2)


def cells(c):
    """Returns the rows of each nominal age and third of the drag."""
    thirds = np.digitize(np.abs(c["drag"]), np.quantile(np.abs(c["drag"]), (1 / 3, 2 / 3)))
    groups = [np.flatnonzero((c["nominal"] == age) & (thirds == third)) for age in AGES_DAY for third in range(3)]
    return [g for g in groups if len(g) > 60]


def fit(c, y):
    groups = cells(c)
    # 1. Shape, with a free core in every cell: 40 % of the delays are within half of the inner sigma of a cell.
    inner, weight = np.ones(len(y)), np.zeros(len(y))
    for g in groups:
        inner[g] = q(y[g], 0.4) / 0.62
        weight[g] = 1 / len(g)

    def unlikely(logs):
        *shape, stretch = np.exp(logs)
        density = sum(w / s * np.exp(-0.5 * (y / s) ** 2) for w, s in mixture(c, shape, stretch * inner))
        return -np.sum(weight * np.log(density + 1e-12))

    options = {"maxiter": 4000, "maxfev": 4000, "xatol": 1e-3, "fatol": 1e-5}
    shape = np.exp(minimize(unlikely, np.log([3.5, 0.01, 0.003, 100.0, 1.0]), method="Nelder-Mead", options=options).x)[:4]

    # 2. Scale.
    def misfit(logs):
        sigma = half_width(mixture(c, shape, core_of(c, np.exp(logs))))
        return sum(np.sqrt(len(g)) * np.log(q(y[g] / sigma[g])) ** 2 for g in groups) + np.sum(np.maximum(np.abs(logs) - 7, 0) ** 2)

    scale = np.exp(minimize(misfit, np.log([0.3, 0.5, 0.1]), method="Nelder-Mead", options=options).x)
    return shape, scale


def inside(parts, half_s):
    return sum(w * erf(half_s / s / np.sqrt(2)) for w, s in parts)


def half_width(parts):
    """Returns the half width that contains 68.27 % of the mixture of each row."""
    low, high = np.zeros_like(parts[0][1]), 3 * parts[2][1] + 1
    for _ in range(24):
        middle = 0.5 * (low + high)
        low, high = np.where(inside(parts, middle) < 0.6827, middle, low), np.where(inside(parts, middle) < 0.6827, high, middle)
    return 0.5 * (low + high)


def cross_growth(c):
    """Fits k t^p, km, for both axes across the track, in addition to 0.3 km at epoch."""
    value = np.concatenate([c["plane"], c["radius"]])
    t = np.tile(c["age"], 2)
    nominal = np.tile(c["nominal"], 2)
    def cost(logs):
        sigma = np.sqrt(0.3**2 + (np.exp(logs[0]) * t ** np.exp(logs[1])) ** 2)
        return sum(np.log(q((value / sigma)[nominal == age]) + 1e-9) ** 2 for age in AGES_DAY if (nominal == age).sum() > 60)
    return np.exp(minimize(cost, np.log([0.1, 1.0]), method="Nelder-Mead").x)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output")
    output = parser.parse_args().output
    fitted, held = pairs(EVEN_STARTS, 0), pairs(ODD_STARTS, 1)
    print(len(fitted["age"]), "pairs fitted,", len(held["age"]), "held out", flush=True)
    pick = lambda c, mask: {name: values[mask] for name, values in c.items()}
    rows = []
    for index, name in enumerate(CLASSES):
        c, h = pick(fitted, fitted["class"] == index), pick(held, held["class"] == index)
        used = lambda c: c["plain"] - LAG2_DAY[name] * c["drag"] * c["age"]
        shape, scale = fit(c, used(c))
        scale *= WIDENING[name]
        cross = cross_growth(c)
        names = ("r", "m0", "m1", "v", "s_0", "k", "c")
        narrowest, centred = best_lags2(c)
        print(f"\n{name}: twice lag {narrowest:.2f} (narrowest), {centred:.2f} (centred), {LAG2_DAY[name]} (used) d; " + ", ".join(f"{n} {x:.3g}" for n, x in zip(names, (*shape, *scale))) + f"; cross {cross[0]:.3g} t^{cross[1]:.3g}")
        print("  held out: age, pairs | published: median, 68 % | B* = 0: 68 % | used: median, 68 %, 95 %, stated 68 %, inside one sigma | across: plane, radius, stated, inside")
        sigma = half_width(mixture(h, shape, core_of(h, scale)))
        across = np.sqrt(0.3**2 + (cross[0] * h["age"] ** cross[1]) ** 2)
        for age in AGES_DAY:
            a = h["nominal"] == age
            if a.sum() < 30:
                continue
            y = used(h)[a]
            both_axes = np.concatenate([h["plane"][a], h["radius"][a]]) / np.tile(across[a], 2)
            print(f"  {age:3d} d {a.sum():6d} | {np.median(h['published'][a]):8.2f} {q(h['published'][a]):8.2f} | {q(h['plain'][a]):8.2f} | {np.median(y):7.2f} {q(y):7.2f} {q(y, 0.9545):8.1f}"
                  f" {np.median(sigma[a]):7.2f} {100 * np.mean(np.abs(y) <= sigma[a]):4.0f} % | {q(h['plane'][a]):5.2f} {q(h['radius'][a]):5.2f} {np.median(across[a]):5.2f} {100 * np.mean(np.abs(both_axes) <= 1):4.0f} %")  # fmt: skip
            rows.append(
                f"| {LABELS[name]} | {age} | {a.sum():,} | {np.median(h['published'][a]):.1f}, {q(h['published'][a]):.1f} | {q(h['plain'][a]):.1f} |"
                f" {np.median(y):.1f}, {q(y):.1f} | {np.median(sigma[a]):.1f} | {100 * np.mean(np.abs(y) <= sigma[a]):.0f} % |"
            )
    with open(output, "w") as file:
        file.write("| class | age, days | pairs | published: median, 68 % | B* = 0: 68 % | used: median, 68 % | stated sigma, median | inside |\n|---|---|---|---|---|---|---|---|\n")
        file.writelines(row + "\n" for row in rows)


if __name__ == "__main__":
    main()
