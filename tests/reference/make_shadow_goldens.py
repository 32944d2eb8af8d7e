"""Writes tests/data/shadow_golden.csv: penumbra and umbra times of real satellites, by Skyfield and by rays.

    pip install skyfield==1.55 sgp4==2.27 numpy
    STREAKCAST_DATA=... python tests/reference/make_shadow_goldens.py tests/data/shadow_golden.csv

Satellites are from tle/active/active_2026-04-25.txt, one for each cell of mean motion and inclination. They are
followed from 2026-04-26T00:00 for two revolutions (geosynchronous ones from 2026-03-20, near the equinox, with the same
elements). Skyfield computes the satellite (GCRS) and the Sun (DE421, geometric: the difference of their barycentric
positions). Two shadows are computed:

cone       Earth and Sun are spheres with radii of 6378.137 km and 695700 km. In the umbra, the angle between their
           centres seen from the satellite is less than asin(R/r) - asin(Rs/d); in the penumbra, less than the sum.
ellipsoid  WGS84 (axis along z of GCRS), with straight lines from the satellite to 720 points of the Sun's limb. In the
           umbra all of them hit the ellipsoid, in the penumbra any. Each intersection is a quadratic equation.

Times are bisected to 1e-4 s. Columns: satellite, event, reference time (UTC), and seconds after it for cone and
ellipsoid.
"""

import os
import sys
from pathlib import Path

import numpy as np
from sgp4.api import WGS72, Satrec
from skyfield.api import EarthSatellite, load, load_file

DATA = Path(os.environ["STREAKCAST_DATA"])
A_KM, F, SUN_KM = 6378.137, 1 / 298.257223563, 695_700.0


def chosen(elements):
    """Selects satellites.

    These are the first of each cell of mean motion (revolutions per day) and inclination, the five geosynchronous ones
    with the lowest inclination, and sixteen more with two revolutions per day.
    """
    cells = {}
    for norad, (_, second) in sorted(elements.items()):
        motion, inclination = float(second[52:63]), float(second[8:16])
        cells.setdefault((round(motion), int(inclination // 15)), []).append(norad)
    lowest_inclination = sorted(cells[(1, 0)], key=lambda norad: float(elements[norad][1][8:16]))
    # Navigation satellites in different planes: some are in their eclipse season.
    medium = [norad for (motion, _), cell in sorted(cells.items()) if motion == 2 for norad in cell[1::7]][:16]
    return list(dict.fromkeys([cell[0] for key, cell in sorted(cells.items())] + lowest_inclination[:5] + medium))


def catalogue():
    lines = [line.rstrip() for line in (DATA / "tle/active/active_2026-04-25.txt").read_text().splitlines()]
    return {int(a[2:7]): (a, b) for a, b in zip(lines, lines[1:]) if a.startswith("1 ") and b.startswith("2 ") and a[2:7].isdigit()}


def cone(sat, sun):
    to_sun = sun - sat
    r, d = np.linalg.norm(sat, axis=-1), np.linalg.norm(to_sun, axis=-1)
    cosine = np.sum(-sat * to_sun, axis=-1) / (r * d)
    angle, earth, disk = np.arccos(np.clip(cosine, -1, 1)), np.arcsin(A_KM / r), np.arcsin(SUN_KM / d)
    return angle - earth - disk, angle - earth + disk


def ellipsoid(sat, sun):
    """Returns the smallest and largest clearance of the rays to the Sun's limb; negative for a hit."""
    to_sun = sun - sat
    d = np.linalg.norm(to_sun, axis=-1, keepdims=True)
    axis = to_sun / d
    side = np.cross(axis, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    up = np.cross(axis, side)
    turn = np.linspace(0, 2 * np.pi, 720, endpoint=False)[:, None, None]
    rays = axis + np.tan(np.arcsin(SUN_KM / d)) * (np.cos(turn) * side + np.sin(turn) * up)
    inverse = 1 / np.array([A_KM, A_KM, A_KM * (1 - F)]) ** 2
    qa, qb = np.sum(rays * rays * inverse, -1), np.sum(rays * sat * inverse, -1)
    qc = np.sum(sat * sat * inverse, -1) - 1
    miss = np.where(qb >= 0, 1.0, qa * qc - qb * qb)
    return miss.min(axis=0), miss.max(axis=0)


def main(target):
    load_dir = load.timescale(builtin=True)
    planets = load_file(str(DATA / "aux/de421.bsp"))
    elements = catalogue()
    rows = []
    used = 0
    for norad in chosen(elements):
        first, second = elements[norad]
        satellite = EarthSatellite(first, second, ts=load_dir)
        improved = satellite.model
        afspc = Satrec()
        afspc.sgp4init(WGS72, "a", improved.satnum, improved.jdsatepoch - 2433281.5 + improved.jdsatepochF, improved.bstar, improved.ndot,
                       improved.nddot, improved.ecco, improved.argpo, improved.inclo, improved.mo, improved.no_kozai, improved.nodeo)  # fmt: skip
        afspc.jdsatepoch, afspc.jdsatepochF = improved.jdsatepoch, improved.jdsatepochF
        satellite.model = afspc
        period_s = 2 * np.pi / improved.no_kozai * 60
        high = period_s > 40_000
        date = (2026, 3, 20) if high else (2026, 4, 26)
        span_s = 2.05 * period_s

        def positions_at(seconds):
            t = load_dir.utc(*date, 0, 0, np.atleast_1d(seconds))
            sun = (planets["sun"] - planets["earth"]).at(t).position.km.T
            return satellite.at(t).position.km.T, sun

        found = {}
        for name, model in (("cone", cone), ("ellipsoid", ellipsoid)):
            coarse = np.arange(0.0, span_s, 60.0 if high else 10.0)
            values = [np.concatenate(parts) for parts in zip(*[model(*positions_at(block)) for block in np.array_split(coarse, len(coarse) // 200 + 1)])]
            for which, value in zip(("penumbra", "umbra"), values):
                for i in np.flatnonzero((value[:-1] > 0) != (value[1:] > 0)):
                    low, high_s = coarse[i], coarse[i + 1]
                    entering = value[i] > 0
                    while high_s - low > 1e-4:
                        middle = 0.5 * (low + high_s)
                        now = model(*positions_at(middle))[0 if which == "penumbra" else 1][0]
                        low, high_s = (middle, high_s) if (now > 0) == entering else (low, middle)
                    found.setdefault((which, "entry" if entering else "exit"), {}).setdefault(name, []).append(0.5 * (low + high_s))
        any_row = False
        for (which, way), by in found.items():
            if len(by.get("cone", [])) != len(by.get("ellipsoid", [])):
                continue
            for by_cone, by_ellipsoid in zip(by["cone"], by["ellipsoid"]):
                utc = [load_dir.utc(*date, 0, 0, s).utc_strftime("%Y-%m-%dT%H:%M:%S") for s in (0,)][0]
                rows.append(f"{norad},{which},{way},{utc},{by_cone:.4f},{by_ellipsoid:.4f}")
                any_row = True
        used += any_row
    with open(target, "w") as out:
        out.write("# skyfield 1.55, sgp4 2.27 (WGS72, AFSPC), DE421; elements of active_2026-04-25.txt; python tests/reference/make_shadow_goldens.py; 2026-11-21\n")
        out.write("norad_id,shadow,way,reference_utc,cone_s,ellipsoid_s\n")
        out.write("\n".join(rows) + "\n")
    print(f"{used} satellites, {len(rows)} moments")


if __name__ == "__main__":
    main(sys.argv[1])
