"""Writes tests/data/frames_golden.csv: frames, observers, Sun and horizon by astropy, ERFA and Skyfield.

    pip install astropy==8.0.2 pyerfa==2.0.1.5 skyfield==1.55
    python tests/reference/make_frames_goldens.py FINALS2000A.all DE421.bsp tests/data/frames_golden.csv

60 random times from 2018 to 2027, each with a random satellite (TEME) and a random site. Both references read the same
finals2000A file; nothing is downloaded.
"""

import sys

import astropy
import astropy.units as u
import erfa
import numpy as np
import skyfield
from astropy.coordinates import (CartesianRepresentation, EarthLocation, GCRS, ITRS, TEME, get_body_barycentric_posvel, solar_system_ephemeris)
from astropy.time import Time
from astropy.utils import iers
from skyfield.api import load, load_file, wgs84
from skyfield.data import iers as skyfield_iers
from skyfield.positionlib import Geometric
from skyfield.sgp4lib import TEME as SKYFIELD_TEME
from skyfield.timelib import Timescale

ROWS = 60


def skyfield_timescale(finals):
    with open(finals, "rb") as f:
        utc_mjd, dut1 = skyfield_iers.parse_dut1_from_finals_all(f)
    tt, delta_t, leap_dates, leap_offsets = skyfield_iers.build_timescale_arrays(utc_mjd, dut1)
    ts = Timescale((tt, delta_t), leap_dates, leap_offsets)
    with open(finals, "rb") as f:
        skyfield_iers.install_polar_motion_table(ts, skyfield_iers.parse_x_y_dut1_from_finals_all(f))
    return ts


def main(finals, ephemeris, target):
    iers.conf.auto_download = False
    iers.conf.auto_max_age = None
    table = iers.IERS_A.open(finals)
    iers.earth_orientation_table.set(table)
    ts = skyfield_timescale(finals)
    planets = load_file(ephemeris)
    rng = np.random.default_rng(20261121)
    first, last = Time("2018-01-01", scale="utc"), Time("2027-10-01", scale="utc")

    columns, lines = None, []
    for _ in range(ROWS):
        millis = int(rng.integers(0, int((last - first).to_value("s") * 1000)))
        t = Time((first + millis * u.ms).utc.isot, scale="utc", precision=3)
        t = Time(t.isot, scale="utc", precision=3)
        row = {"utc": t.isot}

        dut1 = float(table.ut1_utc(t).to_value(u.s))
        xp, yp = (float(v.to_value(u.arcsec)) for v in table.pm_xy(t))
        t.delta_ut1_utc = dut1
        row |= {"ut1_minus_utc_s": dut1, "xp_arcsec": xp, "yp_arcsec": yp}
        row["gmst82_rad"] = float(erfa.gmst82(t.ut1.jd1, t.ut1.jd2))

        direction = rng.normal(size=3)
        satellite = direction / np.linalg.norm(direction) * rng.choice([6700.0, 6930.0, 7580.0, 26560.0, 42164.0])
        satellite = np.round(satellite, 6)
        teme = TEME(CartesianRepresentation(satellite * u.km), obstime=t)
        row |= dict(zip(["teme_x_km", "teme_y_km", "teme_z_km"], satellite))
        itrs = teme.transform_to(ITRS(obstime=t)).cartesian.xyz.to_value(u.km)
        row |= dict(zip(["itrs_x_km", "itrs_y_km", "itrs_z_km"], itrs))
        gcrs = teme.transform_to(ITRS(obstime=t)).transform_to(GCRS(obstime=t)).cartesian.xyz.to_value(u.km)
        row |= dict(zip(["gcrs_x_km", "gcrs_y_km", "gcrs_z_km"], gcrs))

        latitude, longitude, height = np.round([rng.uniform(-80, 80), rng.uniform(-180, 180), rng.uniform(0, 5000)], 4)
        row |= {"latitude_deg": latitude, "longitude_deg": longitude, "height_m": height}
        location = EarthLocation.from_geodetic(longitude * u.deg, latitude * u.deg, height * u.m)
        place, velocity = location.get_gcrs_posvel(t)
        row |= dict(zip(["site_x_km", "site_y_km", "site_z_km"], place.xyz.to_value(u.km)))
        row |= dict(zip(["site_vx_km_s", "site_vy_km_s", "site_vz_km_s"], velocity.xyz.to_value(u.km / u.s)))

        with solar_system_ephemeris.set("builtin"):
            (earth, earth_v), (sun, _) = (get_body_barycentric_posvel(body, t) for body in ("earth", "sun"))
        row |= dict(zip(["sun_x_km", "sun_y_km", "sun_z_km"], (sun - earth).xyz.to_value(u.km)))
        row |= dict(zip(["earth_vx_km_s", "earth_vy_km_s", "earth_vz_km_s"], earth_v.xyz.to_value(u.km / u.s)))

        # Skyfield: its precession and nutation, its reader of the same file, the Sun of DE421.
        when = ts.utc(t.datetime.year, t.datetime.month, t.datetime.day, t.datetime.hour, t.datetime.minute, t.datetime.second + t.datetime.microsecond * 1e-6)
        their_gcrs = SKYFIELD_TEME.rotation_at(when).T @ satellite
        row |= dict(zip(["skyfield_gcrs_x_km", "skyfield_gcrs_y_km", "skyfield_gcrs_z_km"], their_gcrs))
        site = wgs84.latlon(latitude, longitude, height)
        their_place = site.at(when)
        row |= dict(zip(["skyfield_site_x_km", "skyfield_site_y_km", "skyfield_site_z_km"], their_place.position.km))
        au_km = 149597870.7
        topocentric = Geometric((their_gcrs - their_place.position.km) / au_km, t=when, center=site)
        topocentric._ephemeris = None
        altitude, azimuth, distance = topocentric.altaz()
        row |= {"skyfield_altitude_deg": altitude.degrees, "skyfield_azimuth_deg": azimuth.degrees}
        their_sun = planets["sun"].at(when).position.km - planets["earth"].at(when).position.km
        row |= dict(zip(["de421_sun_x_km", "de421_sun_y_km", "de421_sun_z_km"], their_sun))
        row |= dict(zip(["de421_earth_vx_km_s", "de421_earth_vy_km_s", "de421_earth_vz_km_s"], planets["earth"].at(when).velocity.km_per_s))

        # A star at least 30 degrees from the Sun (deflection of light below 0.02"): its geocentric apparent position of
        # date.
        towards_sun = (sun - earth).xyz.to_value(u.km)
        while True:
            star_ra, star_dec = rng.uniform(0, 2 * np.pi), np.arcsin(rng.uniform(-1, 1))
            star = erfa.s2c(star_ra, star_dec)
            if np.dot(star, towards_sun) / np.linalg.norm(towards_sun) < np.cos(np.radians(30)):
                break
        ri, di, eo = erfa.atci13(star_ra, star_dec, 0.0, 0.0, 0.0, 0.0, t.tdb.jd1, t.tdb.jd2)
        row |= {"star_ra_rad": star_ra, "star_dec_rad": star_dec, "apparent_ra_rad": erfa.anp(ri - eo), "apparent_dec_rad": di}

        columns = columns or list(row)
        lines.append(",".join(value if isinstance(value, str) else repr(float(value)) for value in row.values()))

    with open(target, "w") as out:
        out.write(
            f"# astropy {astropy.__version__}, pyerfa {erfa.__version__}, skyfield {skyfield.__version__}; finals2000A.all of astropy-iers-data 0.2026.11.2, "
            "DE421; python tests/reference/make_frames_goldens.py; 2026-11-21\n"
        )
        out.write(",".join(columns) + "\n" + "\n".join(sorted(lines)) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
