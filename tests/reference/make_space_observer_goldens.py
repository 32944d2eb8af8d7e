"""Writes tests/data/space_observer_golden.csv: astrometric directions from satellite to satellite, by Skyfield.

    pip install skyfield==1.55 sgp4==2.27 numpy
    STREAKCAST_DATA=... python tests/reference/make_space_observer_goldens.py tests/data/space_observer_golden.csv

Observer and satellite are `earth + EarthSatellite` for elements in tle/active/active_2026-04-25.txt.
`observer.at(t).observe(satellite)` iterates the light time between barycentric positions: this is the astrometric
direction, without aberration by the velocities of Earth and observer, as in a star-calibrated image. The last columns
are the offset of the geometric direction (`satellite - observer`). SGP4 is in AFSPC mode with WGS72, as in streakcast.
"""

import os
import sys
from pathlib import Path

import numpy as np
from sgp4.api import WGS72, Satrec
from skyfield.api import EarthSatellite, load, load_file

DATA = Path(os.environ["STREAKCAST_DATA"])
OBSERVERS = [20580, 53719, 56154]


def main(target):
    ts = load.timescale(builtin=True)
    planets = load_file(str(DATA / "aux/de421.bsp"))
    lines = [line.rstrip() for line in (DATA / "tle/active/active_2026-04-25.txt").read_text().splitlines()]
    elements = {int(a[2:7]): (a, b) for a, b in zip(lines, lines[1:]) if a.startswith("1 ") and b.startswith("2 ") and a[2:7].isdigit()}

    def satellite(norad):
        made = EarthSatellite(*elements[norad], ts=ts)
        model, afspc = made.model, Satrec()
        afspc.sgp4init(WGS72, "a", model.satnum, model.jdsatepoch - 2433281.5 + model.jdsatepochF, model.bstar, model.ndot, model.nddot,
                       model.ecco, model.argpo, model.inclo, model.mo, model.no_kozai, model.nodeo)  # fmt: skip
        afspc.jdsatepoch, afspc.jdsatepochF = model.jdsatepoch, model.jdsatepochF
        made.model = afspc
        return made

    random = np.random.default_rng(20260426)
    ids = sorted(elements)
    rows = []
    for number in range(60):
        observer, target_id = OBSERVERS[number % len(OBSERVERS)], int(random.choice(ids))
        seconds = round(float(random.uniform(0, 86_400)), 3)
        t = ts.utc(2026, 4, 26, 0, 0, seconds)
        a, b = satellite(observer), satellite(target_id)
        seen = (planets["earth"] + a).at(t).observe(planets["earth"] + b)
        ra, dec, distance = seen.radec()
        plain = (b - a).at(t)
        off = np.degrees(seen.separation_from(plain).radians) * 3600
        rows.append(f"{observer},{target_id},{seconds:.3f},{ra._degrees:.9f},{dec.degrees:.9f},{distance.km:.6f},{plain.distance().km:.6f},{off:.3f}")
    with open(target, "w") as out:
        out.write("# skyfield 1.55, sgp4 2.27 (WGS72, AFSPC), DE421; elements of active_2026-04-25.txt; python tests/reference/make_space_observer_goldens.py; 2026-11-21\n")
        out.write("observer,satellite,seconds_after_2026_04_26,ra_deg,dec_deg,light_path_km,range_km,geometric_off_arcsec\n")
        out.write("\n".join(rows) + "\n")
    print(len(rows))


main(sys.argv[1])
