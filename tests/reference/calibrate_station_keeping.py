"""Fits the lags of Starlinks that hold their orbits, and the growth of their errors across the track
(src/orbit/station_keeping.rs, uncertainty.rs).

An element set is propagated to the epoch of a later element set of the same satellite. Its lateness is the time along
the track by which the satellite is behind the prediction (negative: ahead of it). "published" uses the element set as
it is, "plain" B* = 0, and "used" B* = 0 and the mean motion n - 2 tau (ndot/2), where tau is the lag of a class in
days. The fit uses even catalogue numbers and elements of 2, 9, 16 and 23 June 2026; the report also has odd numbers and
elements of 5, 12, 19 and 26 June. The distributions of the lateness are compared by positions_by_age.py.

    STREAKCAST_DATA=... python tests/reference/calibrate_station_keeping.py

Lateness and distances out of plane and in radius are computed by calibrate_orbit_uncertainty.compare. Requires numpy,
scipy and sgp4. Takes about ten minutes.
"""

import datetime
import gzip

import numpy as np
from scipy.optimize import minimize
from sgp4.api import WGS72, Satrec

from calibrate_orbit_uncertainty import compare
from positions_by_age import class_of, launches, path

EVEN_STARTS, ODD_STARTS = (2, 9, 16, 23), (5, 12, 19, 26)
AGES_DAY = (1, 2, 3, 5, 7, 10, 14, 21)
# Twice the lag, days, rounded: between the value with the smallest half width and that with the median 0 (both are
# printed).
LAG2_DAY = {"V1.5": 0.75, "VisorSat, V2 Mini": 0.75, "V2 Mini, strong drag": 0.45, "Direct-to-Cell": 0.33, "V2 Mini, parked": 0.30}


def read(day):
    """Returns the element sets of a day: catalogue number -> (name, line 1, line 2)."""
    lines = gzip.open(path(day), "rt").read().splitlines()
    triples = zip(lines[0::3], lines[1::3], lines[2::3])
    return {int(first[2:7]): (name.strip(), first, second) for name, first, second in triples if first[2:7].strip().isdigit()}


def without_drag(s):
    """Returns the same elements with B* = 0."""
    other = Satrec()
    epoch = s.jdsatepoch + s.jdsatepochF - 2433281.5
    other.sgp4init(WGS72, "a", s.satnum, epoch, 0.0, s.ndot, s.nddot, s.ecco, s.argpo, s.inclo, s.mo, s.no_kozai, s.nodeo)
    return other


FIELDS = ("class", "nominal", "age", "drag", "published", "plain", "plane", "radius")


def pairs(starts, parity):
    table, days, rows = launches(), {}, []
    get = lambda day: days.setdefault(day, read(day))
    names = list(LAG2_DAY)
    for start in starts:
        for age in (age for age in AGES_DAY if start + age <= 30):
            later = get(start + age)
            for norad, (name, first, second) in get(start).items():
                if norad % 2 != parity or norad not in later or later[norad][1] == first:
                    continue
                s, truth = Satrec.twoline2rv(first, second, WGS72), Satrec.twoline2rv(*later[norad][1:], WGS72)
                year = int(first[9:11] or 0) + (2000 if int(first[9:11] or 0) < 57 else 1900) if first[9:11].strip() else 0
                n, half_ndot = float(second[52:63]), float(first[33:43])
                its = class_of((name, datetime.datetime.min, n, half_ndot, f"{year}-{first[11:14]}"), table)
                days_between = truth.jdsatepoch - s.jdsatepoch + truth.jdsatepochF - s.jdsatepochF
                if its not in LAG2_DAY or days_between < 0.2:
                    continue
                published, plain = compare(s, truth), compare(without_drag(s), truth)
                if published and plain:
                    rows.append((names.index(its), age, days_between, half_ndot * 86400 / n, published[0], *plain))
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
    fitted, held = pairs(EVEN_STARTS, 0), pairs(ODD_STARTS, 1)
    print(len(fitted["age"]), "pairs fitted,", len(held["age"]), "held out", flush=True)
    pick = lambda c, mask: {name: values[mask] for name, values in c.items()}
    for index, (name, lag2) in enumerate(LAG2_DAY.items()):
        c, h = pick(fitted, fitted["class"] == index), pick(held, held["class"] == index)
        (narrowest, centred), cross = best_lags2(c), cross_growth(c)
        print(f"\n{name}: twice lag {narrowest:.2f} (narrowest), {centred:.2f} (centred), {lag2} (used) d; cross {cross[0]:.3g} t^{cross[1]:.3g}")
        for age in AGES_DAY:
            a = h["nominal"] == age
            if a.sum() >= 30:
                used = (h["plain"] - lag2 * h["drag"] * h["age"])[a]
                print(f"  held out, {age:2d} d {a.sum():6d} pairs, 68 %: published {q(h['published'][a]):8.2f}, plain {q(h['plain'][a]):8.2f}, used {q(used):7.2f} s; plane {q(h['plane'][a]):5.2f}, radius {q(h['radius'][a]):5.2f} km")


if __name__ == "__main__":
    main()
