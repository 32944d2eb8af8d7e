"""Writes tests/data/ephemeris_golden.csv: astrometric positions of real satellites from a site, by Skyfield.

    pip install skyfield==1.55 sgp4==2.27 numpy
    STREAKCAST_DATA=... python tests/reference/make_ephemeris_goldens.py tests/data/ephemeris_golden.csv

Satellites are from tle/active/active_2026-04-25.txt: low orbits of all inclinations, a navigation satellite, three
geostationary ones. The site is that of make_forecast_goldens.py. Both programs use UT1 and polar motion of the IERS
(aux/finals2000A.all).

ra, dec         (Earth + site).observe(Earth + satellite): light time and the Earth's motion during it, ICRS
rates           central differences of these over 0.4 s; the right ascension times the cosine of the declination
altitude, azimuth, range, range rate   of (satellite - site): geometric, both at the time of reception
phase, elongation                      angles of the geometric vectors to site, satellite and Sun (DE421)

Columns: satellite, seconds after 2026-04-25T23:00:00 UTC, degrees, degrees per second, km, km/s.
"""

import sys

import numpy as np
from make_forecast_goldens import afspc
from make_shadow_goldens import DATA, catalogue
from skyfield.api import EarthSatellite, load_file, wgs84
from skyfield.data import iers
from skyfield.timelib import Timescale

SATELLITES = (25544, 44057, 44714, 20580, 25994, 31698, 43013, 40105, 38740, 40732, 54743)
SECONDS = (0.0, 600.0, 1234.5, 3000.25, 7200.0, 20000.0)
STEP_S = 0.2


def angle_deg(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def main(target):
    with open(DATA / "aux/finals2000A.all", "rb") as file:
        finals = iers.parse_x_y_dut1_from_finals_all(file)
    daily_tt, delta_t, leap_dates, leap_offsets = iers.build_timescale_arrays(finals["utc_mjd"], finals["dut1"])
    scale = Timescale((daily_tt, delta_t), leap_dates, leap_offsets)
    iers.install_polar_motion_table(scale, finals)

    planets = load_file(str(DATA / "aux/de421.bsp"))
    earth, sun = planets["earth"], planets["sun"]
    site = wgs84.latlon(-(30 + 14 / 60 + 40.7 / 3600), -(70 + 44 / 60 + 57.9 / 3600), elevation_m=2662.75)
    start = scale.utc(2026, 4, 25, 23)
    at = lambda seconds: scale.tai_jd(start.whole, start.tai_fraction + seconds / 86400.0)
    elements, rows = catalogue(), []
    for norad in SATELLITES:
        satellite = afspc(EarthSatellite(*elements[norad], ts=scale))
        seen = lambda seconds: (earth + site).at(at(seconds)).observe(earth + satellite)
        place = lambda seconds: [angle._degrees for angle in seen(seconds).radec()[:2]]
        for seconds in SECONDS:
            time = at(seconds)
            ra, dec = seen(seconds).radec()[:2]
            (ra_0, dec_0), (ra_1, dec_1) = place(seconds - STEP_S), place(seconds + STEP_S)
            ra_rate = ((ra_1 - ra_0 + 180) % 360 - 180) * np.cos(dec.radians) / (2 * STEP_S)
            difference = (satellite - site).at(time)
            altitude, azimuth, distance = difference.altaz()
            line, velocity = difference.position.km, difference.velocity.km_per_s
            to_sun = (sun - earth).at(time).position.km - site.at(time).position.km
            values = (
                ra._degrees, dec.degrees, ra_rate, (dec_1 - dec_0) / (2 * STEP_S), altitude.degrees, azimuth.degrees, distance.km,
                line @ velocity / distance.km, angle_deg(-line, to_sun - line), angle_deg(line, to_sun),
            )  # fmt: skip
            decimals = (8, 8, 9, 9, 7, 7, 5, 8, 5, 5)
            rows.append(f"{norad},{seconds}," + ",".join(f"{value:.{digits}f}" for value, digits in zip(values, decimals)))
    with open(target, "w") as out:
        out.write("# skyfield 1.55, sgp4 2.27 (WGS72, AFSPC), DE421, finals2000A; elements of active_2026-04-25.txt; "
                  "python tests/reference/make_ephemeris_goldens.py; 2026-11-24\n")
        out.write("norad_id,seconds,ra_deg,dec_deg,ra_cos_dec_rate_deg_s,dec_rate_deg_s,altitude_deg,azimuth_deg,range_km,range_rate_km_s,"
                  "phase_angle_deg,elongation_deg\n")
        out.write("\n".join(rows) + "\n")
    print(len(rows), "rows")


if __name__ == "__main__":
    main(sys.argv[1])
