"""Writes tests/data/forecast_golden.csv: passes and shadow edges of real satellites over one night, by Skyfield.

    pip install skyfield==1.55 sgp4==2.27 numpy
    STREAKCAST_DATA=... python tests/reference/make_forecast_goldens.py tests/data/forecast_golden.csv

Satellites are from tle/active/active_2026-04-25.txt: one for each cell of mean motion and inclination (selected by
make_shadow_goldens.py) and every 300th of the others. The site is at 30 deg 14 min 40.7 s south, 70 deg 44 min 57.9 s
west, 2662.75 m. The time range is 2026-04-25T22:00:00 to 2026-04-26T11:00:00 UTC.

rise, set     Skyfield's find_events at 10 deg (geometric, no refraction), refined here to 1e-4 s by bisection of its
              altitude
culmination   the highest point in between, by golden section of the same altitude
fades, back   the first edge of the penumbra of the WGS84 ellipsoid between rise and set, in both directions, by rays
              (make_shadow_goldens.py)

Columns: satellite, event, seconds after the reference, altitude and azimuth in degrees.
"""

import sys

import numpy as np
from make_shadow_goldens import DATA, catalogue, chosen, ellipsoid
from sgp4.api import WGS72, Satrec
from skyfield.api import EarthSatellite, load, load_file, wgs84

SPAN_S = 13 * 3600.0
LIMIT_DEG = 10.0


def afspc(satellite):
    """Returns the same satellite in the AFSPC mode with WGS72."""
    improved, model = satellite.model, Satrec()
    model.sgp4init(WGS72, "a", improved.satnum, improved.jdsatepoch - 2433281.5 + improved.jdsatepochF, improved.bstar, improved.ndot,
                   improved.nddot, improved.ecco, improved.argpo, improved.inclo, improved.mo, improved.no_kozai, improved.nodeo)
    model.jdsatepoch, model.jdsatepochF = improved.jdsatepoch, improved.jdsatepochF
    satellite.model = model
    return satellite


def bisect(holds, inside, outside):
    while abs(inside - outside) > 1e-4:
        middle = 0.5 * (inside + outside)
        if holds(middle):
            inside = middle
        else:
            outside = middle
    return 0.5 * (inside + outside)


def main(target):
    scale = load.timescale(builtin=True)
    planets = load_file(str(DATA / "aux/de421.bsp"))
    start = scale.utc(2026, 4, 25, 22)
    at = lambda seconds: scale.tai_jd(start.tai + np.asarray(seconds) / 86400.0)
    site = wgs84.latlon(-(30 + 14 / 60 + 40.7 / 3600), -(70 + 44 / 60 + 57.9 / 3600), elevation_m=2662.75)
    elements = catalogue()
    ids = list(dict.fromkeys(chosen(elements) + sorted(elements)[::300]))
    rows, used = [], 0
    for norad in ids:
        satellite = afspc(EarthSatellite(*elements[norad], ts=scale))
        seen = lambda seconds: (satellite - site).at(at(seconds)).altaz()
        height = lambda seconds: seen(seconds)[0].degrees

        def clearance(seconds):
            time = at(np.atleast_1d(seconds))
            sun = (planets["sun"] - planets["earth"]).at(time).position.km.T
            return ellipsoid(satellite.at(time).position.km.T, sun)[0]

        times, events = satellite.find_events(site, start, at(SPAN_S), altitude_degrees=LIMIT_DEG)
        if np.isnan(satellite.at(at(SPAN_S)).position.km).any():
            continue
        seconds = (times.tai - start.tai) * 86400.0
        events = list(zip(seconds, events))
        passes = [(a, b) for (a, kind), (b, other) in zip(
            [one for one in events if one[1] != 1], [one for one in events if one[1] != 1][1:]) if kind == 0 and other == 2]
        used += bool(passes)
        for rise, fall in passes:
            low, high = rise, fall
            rise = bisect(lambda s: height(s) >= LIMIT_DEG, rise + 1.0, rise - 1.0)
            fall = bisect(lambda s: height(s) >= LIMIT_DEG, fall - 1.0, fall + 1.0)
            grid = np.linspace(rise, fall, 200)
            top = int(np.argmax(height(grid)))
            low, high = grid[max(top - 1, 0)], grid[min(top + 1, 199)]
            golden = 0.5 * (5**0.5 - 1)
            while high - low > 1e-3:
                width = golden * (high - low)
                if height(high - width) > height(low + width):
                    high = low + width
                else:
                    low = high - width
            found = [("rise", rise), ("culmination", 0.5 * (low + high)), ("set", fall)]
            lit = clearance(grid) > 0
            for is_lit, name in ((False, "fades"), (True, "back")):
                for step in range(1, 200):
                    if lit[step] == is_lit and lit[step - 1] != is_lit:
                        inside, outside = (grid[step - 1], grid[step]) if name == "fades" else (grid[step], grid[step - 1])
                        found.append((name, bisect(lambda s: clearance(s)[0] > 0, inside, outside)))
                        break
            for name, moment in found:
                altitude, azimuth, _ = seen(moment)
                rows.append(f"{norad},{name},{moment:.4f},{altitude.degrees:.5f},{azimuth.degrees:.5f}")
    with open(target, "w") as out:
        out.write("# skyfield 1.55, sgp4 2.27 (WGS72, AFSPC), DE421; elements of active_2026-04-25.txt; "
                  "python tests/reference/make_forecast_goldens.py; 2026-11-22\n")
        out.write("norad_id,event,seconds,altitude_deg,azimuth_deg\n")
        out.write("\n".join(rows) + "\n")
    print(f"{len(ids)} satellites, {used} with passes, {len(rows)} rows")


if __name__ == "__main__":
    main(sys.argv[1])
