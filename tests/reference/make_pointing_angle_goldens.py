"""Writes tests/data/pointing_angles_golden.csv: angles of pointings from zenith, Sun and limb of telescopes, by Skyfield.

    pip install skyfield==1.55 sgp4==2.27 numpy
    STREAKCAST_DATA=... python tests/reference/make_pointing_angle_goldens.py tests/data/pointing_angles_golden.csv

The zenith angle is the separation of the pointing from the geocentric position of the telescope, the Sun angle that from
the astrometric direction `observer.at(t).observe(sun)`. The limb angle is the smallest separation from 20,000 rays that
touch the WGS84 ellipsoid, with the axis of the Earth along that of date; negative for a pointing at the Earth. SGP4 is in
AFSPC mode with WGS72, as in streakcast.
"""

import os
import sys
from pathlib import Path

import numpy as np
from sgp4.api import WGS72, Satrec
from skyfield.api import EarthSatellite, load, load_file
from skyfield.framelib import true_equator_and_equinox_of_date

DATA = Path(os.environ["STREAKCAST_DATA"])
OBSERVERS = [20580, 63182, 48274]
RADIUS_KM, FLATTENING = 6378.137, 1 / 298.257223563


def limb_angle_deg(position, pointing):
    """Returns the angle of a pointing from the limb, both in a frame whose z axis is that of the Earth."""
    nadir = -position / np.linalg.norm(position)
    side = np.cross(nadir, [1.0, 0.3, 0.2])
    side /= np.linalg.norm(side)
    azimuths = np.linspace(0, 2 * np.pi, 20_000, endpoint=False)[:, None]
    outwards = side * np.cos(azimuths) + np.cross(nadir, side) * np.sin(azimuths)
    # The line position + s d touches the ellipsoid where the discriminant of |A (position + s d)| = 1 vanishes.
    scale = np.array([1, 1, 1 / (1 - FLATTENING)]) / RADIUS_KM
    inner, outer = np.zeros(len(azimuths)), np.full(len(azimuths), np.pi / 2)
    for _ in range(60):
        middle = (inner + outer) / 2
        rays = nadir * np.cos(middle)[:, None] + outwards * np.sin(middle)[:, None]
        a, b = rays * scale, position * scale
        hits = (a @ b) ** 2 >= (a * a).sum(1) * (b @ b - 1)
        inner, outer = np.where(hits, middle, inner), np.where(hits, outer, middle)
    rays = nadir * np.cos(inner)[:, None] + outwards * np.sin(inner)[:, None]
    apart = np.degrees(np.arccos(np.clip(rays @ pointing, -1, 1)).min())
    a, b = pointing * scale, position * scale
    is_hit = a @ b < 0 and (a @ b) ** 2 >= (a @ a) * (b @ b - 1)
    return -apart if is_hit else apart


def main(target):
    ts = load.timescale(builtin=True)
    planets = load_file(str(DATA / "aux/de421.bsp"))
    lines = [line.rstrip() for line in (DATA / "tle/active/active_2026-04-25.txt").read_text().splitlines()]
    elements = {int(a[2:7]): (a, b) for a, b in zip(lines, lines[1:]) if a.startswith("1 ") and b.startswith("2 ") and a[2:7].isdigit()}
    random = np.random.default_rng(48)
    rows = []
    for number in range(60):
        norad = OBSERVERS[number % len(OBSERVERS)]
        telescope = EarthSatellite(*elements[norad], ts=ts)
        model, afspc = telescope.model, Satrec()
        afspc.sgp4init(WGS72, "a", model.satnum, model.jdsatepoch - 2433281.5 + model.jdsatepochF, model.bstar, model.ndot, model.nddot,
                       model.ecco, model.argpo, model.inclo, model.mo, model.no_kozai, model.nodeo)  # fmt: skip
        afspc.jdsatepoch, afspc.jdsatepochF = model.jdsatepoch, model.jdsatepochF
        telescope.model = afspc
        seconds = round(float(random.uniform(0, 86_400)), 3)
        t = ts.utc(2026, 4, 26, 0, 0, seconds)
        ra, dec = random.uniform(0, 2 * np.pi), np.arcsin(random.uniform(-1, 1))
        ra, dec = (np.radians(round(float(np.degrees(angle)), 6)) for angle in (ra, dec))
        pointing = np.array([np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)])
        place = telescope.at(t)
        sun = (planets["earth"] + telescope).at(t).observe(planets["sun"]).position.km
        from_pointing = lambda vector: float(np.degrees(np.arccos(pointing @ vector / np.linalg.norm(vector))))  # noqa: E731
        to_date = true_equator_and_equinox_of_date.rotation_at(t)
        limb = limb_angle_deg(to_date @ place.position.km, to_date @ pointing)
        rows.append(f"{norad},{seconds:.3f},{np.degrees(ra):.6f},{np.degrees(dec):.6f},{from_pointing(place.position.km):.5f},{from_pointing(sun):.5f},{limb:.5f}")
    with open(target, "w") as out:
        out.write("# skyfield 1.55, sgp4 2.27 (WGS72, AFSPC), DE421; elements of active_2026-04-25.txt; python tests/reference/make_pointing_angle_goldens.py; 2026-11-29\n")
        out.write("telescope,seconds_after_2026_04_26,ra_deg,dec_deg,zenith_deg,sun_deg,limb_deg\n")
        out.write("\n".join(rows) + "\n")
    print(len(rows))


main(sys.argv[1])
