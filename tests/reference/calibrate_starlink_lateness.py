"""Fits the growth of the lateness with age: cores of shells and of raising satellites in src/orbit/starlink_lateness.rs.

    cargo test --workspace --test library lateness_of_even_numbers -- --ignored --nocapture > lateness.csv
    python tests/reference/calibrate_starlink_lateness.py lateness.csv

The data are even catalogue numbers, with element sets of 8 to 29 June 2026 and those of 7 days before. They are divided
into cells by age, and by start day: before 15 June, and from it on. In each cell 68 % of the residuals should be within the
stated sigma. The sum of the squares of log(68 % half width of the residuals / sigma) over the cells is minimised. Both
halves of the month thus have the same weight; the satellites of a day have a common error, and from 15 June on only two
days have element sets of 14 days later. The ratio of the core's widths and the weights of the Gaussians are given.

In strong drag, a is 8 % larger in the library, so that sigma contains at least 63 % in the cells of 0.7 to 4.5 days from 15 June on.

Requires numpy and scipy.
"""

import argparse
import csv

import numpy as np
from scipy.optimize import brentq, minimize
from scipy.special import erf

# Limits of the ages, and first day of the second half.
AGES_DAY, SECOND_HALF = ((0.2, 0.7), (0.7, 2), (2, 4.5), (5.5, 8.5), (12.5, 16)), 15
# Ratio r of the core's widths and share m₀ + m₁ t of manoeuvres, with a width of 90 s per day.
SHELLS = {"V15": (3.2, 0.005, 0.0096), "Station": (2.9, 0.010, 0.0004), "StrongDrag": (2.05, 0.009, 0.001), "DirectToCell": (2.2, 0.003, 0.0)}
ARRIVED_V15 = (10.0, 0.14, 0.0)
# r, m, and coefficient and power of the wide part.
RAISING = (1.0, 0.30, 88.0, 2.06)
# Time in which the noise between two sets rises: of 1, 1.5 and 2 days the one that suits all four classes.
RISE_DAY = 1.5
# Smallest width, largest width, and least number of residuals in a cell.
FLOOR_S, CAP_S = 0.13, 0.3413 * 5700
LEAST = 20


def one_sigma(parts):
    """Returns the half width with 68 % of a sum of Gaussians, each given by its weight and width."""
    share = lambda x: sum(weight * erf(x / width / np.sqrt(2)) for weight, width in parts) - 0.6827
    return brentq(share, 0.0, 10 * max(width for _, width in parts))


def mixture(core_s, ratio, share, wide_s):
    outer_s = ratio * core_s
    return one_sigma([((1 - share) * 0.7, core_s), ((1 - share) * 0.3, outer_s), (share, min(max(wide_s, outer_s), CAP_S))])


def norm3(x, y, z):
    return np.sqrt(x**2 + y**2 + z**2)


def in_shell(shape, t, parameters):
    ratio, m0, m1 = shape
    s0, a, b = parameters
    return mixture(np.hypot(norm3(FLOOR_S, s0, b * np.sqrt(t)), a * np.sqrt(1 - np.exp(-t / RISE_DAY))), ratio, m0 + m1 * t, 90 * t)


def growing(shape, t, parameters):
    ratio, m0, m1 = shape
    coefficient, power = parameters
    return mixture(np.hypot(FLOOR_S, coefficient * t**power), ratio, m0 + m1 * t, 90 * t)


def raising(shape, t, parameters):
    ratio, share, wide, wide_power = shape
    core, power = parameters
    return mixture(np.hypot(FLOOR_S, core * t**power), ratio, share, wide * t**wide_power)


def cells(rows, between_days):
    """Returns limits of the age, half of the month, mean age, residuals and stated sigmas of each cell."""
    column = lambda name: np.array([float(row[name]) for row in rows])
    start, t, late_s, sigma_s = column("start"), column("age_days"), np.abs(column("late_s")), column("sigma_s")
    for low, high in (limits for limits in AGES_DAY if between_days[0] <= limits[0] < between_days[1]):
        for is_second in (False, True):
            found = (t >= low) & (t < high) & ((start >= SECOND_HALF) == is_second)
            if found.sum() >= LEAST:
                yield (low, high), is_second, np.mean(t[found]), late_s[found], sigma_s[found]


def fit(name, sigma_of, start, rows, between_days=(0, 20)):
    groups = list(cells(rows, between_days))
    widths = [np.quantile(late_s, 0.6827) for *_, late_s, _ in groups]

    def cost(logs):
        stated = [sigma_of(t, np.exp(logs)) for _, _, t, _, _ in groups]
        return np.sum(np.log(np.array(widths) / stated) ** 2) + 1e-6 * np.sum((logs - np.log(start)) ** 2)

    options = {"maxiter": 5000, "maxfev": 5000, "xatol": 1e-4, "fatol": 1e-7}
    best = minimize(cost, np.log(start), method="Nelder-Mead", options=options).x
    print(f"\n{name} (cost {cost(best):.4f}): " + ", ".join(f"{value:.3g}" for value in np.exp(best)))
    for ((low, high), late, t, late_s, sigma), width in zip(groups, widths):
        stated = sigma_of(t, np.exp(best))
        print(f"  {low:4.1f} to {high:4.1f} d, {'from' if late else 'before'} 15 June: {len(late_s):6d} residuals, 68 % {width:8.2f} s, stated {stated:8.2f} s, inside {100 * np.mean(late_s <= stated):.0f} % (library: {100 * np.mean(late_s <= sigma):.0f} %)")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("residuals")
    with open(parser.parse_args().residuals) as file:
        lines = [line for line in file if line.count(",") == 6]
    rows = list(csv.DictReader(lines))
    of = lambda its, motion: [row for row in rows if row["class"] == its and row["mean_motion"] == motion]
    for its, shape in SHELLS.items():
        fit(f"{its}, shell: s0, a, b", lambda t, p: in_shell(shape, t, p), (0.2, 0.3, 0.1), of(its, "Shell"))
    fit("V15, arrived: coefficient, power", lambda t, p: growing(ARRIVED_V15, t, p), (0.3, 0.5), of("V15", "Arrived"))
    fit("Raising: core, power", lambda t, p: raising(RAISING, t, p), (9.0, 2.8), of("Raising", "OneSet"), (0.7, 5))


if __name__ == "__main__":
    main()
