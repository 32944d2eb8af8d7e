"""Compares `check_pointings` of streakcast and rubin_sim, for the same satellites and visits.

    pip install rubin-sim rubin-scheduler skyfield shapely astropy "./plugins/python[astropy]"
    python tests/reference/compare_check_pointings.py DE421.BSP

The installed rubin_sim (GPL-3.0) is called; none of its code is included here. It takes `mjds` as UT1 (at most 0.9 s
from UTC, which is 9 km along an orbit), draws a satellite as a polyline of positions 2 s apart on the tangent plane,
clips it with a circle of 64 corners, and neglects light time. Lengths may therefore differ by 0.2 % (corners and
tangent plane), and by the effect of about 20 arcsec at the edge. Its shadow is a step function, so the visits are at
twilight, when every satellite above 30° is lit.
"""

import os
import sys
import tempfile
from pathlib import Path

import numpy as np
from astropy import units as u
from astropy.coordinates import AltAz, EarthLocation, SkyCoord, get_sun
from astropy.time import Time

import streakcast

VISITS = 200
EVERY = 2
#: Tolerances of lengths, relative and in degrees. Shorter streaks (at the edge) may be found by only one program.
SHARE, LENGTH_DEG, GRAZING_DEG = 0.005, 0.01, 0.3


def visits(location):
    """Returns visits on evenings after the epoch, with the Sun at -8° to -10° and pointings above 35°."""
    generator = np.random.default_rng(4)
    starts, pointings = [], []
    while len(starts) < VISITS:
        time = Time("2023-10-01T22:50:00", scale="utc") + generator.integers(0, 3) * u.day + generator.uniform(0, 40) * u.min
        frame = AltAz(obstime=time, location=location)
        if not -10.0 < get_sun(time).transform_to(frame).alt.deg < -8.0:
            continue
        place = SkyCoord(az=generator.uniform(0, 360) * u.deg, alt=np.degrees(np.arcsin(generator.uniform(0.574, 0.99))) * u.deg, frame=frame)
        starts.append(time.utc.mjd)
        pointings.append([place.icrs.ra.deg, place.icrs.dec.deg])
    return np.array(starts), np.array(pointings).T


def within_a_turn(tle):
    """Reduces mean anomalies above 360°, which streakcast rejects, and corrects the checksum."""
    name, first, second = tle.split("\n")
    anomaly_deg = float(second[43:51]) % 360.0
    return "\n".join((name, first, f"{second[:43]}{anomaly_deg:8.4f}{second[51:]}"))


def main(ephemeris):
    from rubin_sim.satellite_constellations import Constellation, starlink_tles_v1

    tles = starlink_tles_v1()[::EVERY]
    os.chdir(Path(ephemeris).resolve().parent)
    constellation = Constellation(tles)
    site = constellation.observatory_site
    place = (site.latitude.degrees, site.longitude.degrees, site.elevation.m)
    location = EarthLocation.from_geodetic(lat=place[0], lon=place[1], height=place[2])
    starts, (ra, dec) = visits(location)
    utc = Time(starts, format="mjd", scale="utc")
    lengths, counts = constellation.check_pointings(ra, dec, utc.ut1.mjd, np.full(VISITS, 30.0))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "shell.tle"
        file.write_text("\n".join(map(within_a_turn, tles)) + "\n")
        model = streakcast.StreakModel(
            lat=place[0], lon=place[1], height=place[2], elements=file, accept_bad_checksums=True, fov="3.5deg", mjd_scale="utc"
        )
        own_lengths, own_counts = model.check_pointings(ra, dec, starts, 30.0)
    grazing = np.abs(lengths - own_lengths) < GRAZING_DEG
    same = (own_counts == counts) | ((np.abs(own_counts - counts) == 1) & grazing)
    off = np.abs(own_lengths - lengths) - SHARE * lengths
    both = own_counts == counts
    print(f"{VISITS} visits, {len(tles)} satellites: {counts.sum()} streaks there, {own_counts.sum()} here, {lengths.sum():.2f}° and {own_lengths.sum():.2f}°")
    print(f"same number in {both.sum()} visits; largest difference of lengths there {np.abs(own_lengths - lengths)[both].max():.4f}°")
    print(f"UT1 - UTC is {86400 * (utc.ut1.mjd - starts).mean():+.3f} s on these days")
    if not same.all() or (off[both] > LENGTH_DEG).any():
        for row in np.flatnonzero(~same | (both & (off > LENGTH_DEG))):
            print(f"visit {row}: {counts[row]} {lengths[row]:.4f}° there, {own_counts[row]} {own_lengths[row]:.4f}° here")
        sys.exit(1)


if __name__ == "__main__":
    main(sys.argv[1])
