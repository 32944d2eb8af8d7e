"""Prints apparent positions of date and ICRS positions for the tests of src/geometry/topocentric.rs."""
import astropy.units as u
import numpy as np
from astropy.coordinates import TETE, SkyCoord
from astropy.time import Time
from astropy.utils import iers

iers.conf.auto_download = False
iers.conf.auto_max_age = None
rng = np.random.default_rng(7)
for year in (2016, 2021, 2024, 2026):
    for _ in range(3):
        time = Time(f"{year}-{rng.integers(1, 13):02d}-{rng.integers(1, 28):02d}T{rng.integers(0, 24):02d}:30:00", scale="utc")
        place = SkyCoord(rng.uniform(0, 360) * u.deg, np.degrees(np.arcsin(rng.uniform(-1, 1))) * u.deg, frame=TETE(obstime=time))
        icrs = place.icrs
        print(f'        ("{time.isot[:19]} UTC", [{place.ra.deg:.7f}, {place.dec.deg:.7f}], [{icrs.ra.deg:.7f}, {icrs.dec.deg:.7f}]),')
