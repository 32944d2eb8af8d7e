"""Shared fixtures: a simulated constellation in a file, a site, 40 targets (no download)."""

import logging
import warnings

import numpy as np
import pytest
from astroplan import FixedTarget, Observer
from astropy import units as u
from astropy.coordinates import EarthLocation, SkyCoord
from astropy.time import Time
from astropy.utils import iers

from brute_force import Sky, walker, write_tle
from streakcast import StreakModel

iers.conf.auto_download = False
iers.conf.auto_max_age = None

#: Evening twilight at Rubin Observatory, when the Sun is at -12 deg.
START = Time("2026-04-25T22:50:00", scale="utc")
LOCATION = EarthLocation.from_geodetic(lon=-70.7494, lat=-30.2444, height=2663.0)
#: Height (km), inclination (deg), number of planes, satellites per plane. Lower satellites enter the shadow earlier.
SHELLS = [(550.0, 53.0, 36, 22), (1200.0, 87.9, 36, 40)]
FOV_DEG = 8.0


@pytest.fixture(scope="session")
def elements(tmp_path_factory):
    """Returns an element file, and the same satellites for the brute-force computation."""
    path = tmp_path_factory.mktemp("elements") / "walker.tle"
    return path, write_tle(path, walker(SHELLS, START))


@pytest.fixture(scope="session")
def model(elements):
    return StreakModel(site=LOCATION, elements=elements[0], fov=FOV_DEG * u.deg, limit_mag=7, blocking="any")


@pytest.fixture(scope="session")
def sky(elements):
    """Returns the independent brute-force computation."""
    return Sky(elements[1], LOCATION)


@pytest.fixture(scope="session")
def observer():
    return Observer(location=LOCATION)


@pytest.fixture(scope="session")
def targets():
    """Returns 40 fields above the horizon in the evening."""
    random = np.random.default_rng(20260425)
    positions = zip(random.uniform(100.0, 190.0, 40), random.uniform(-65.0, 0.0, 40))
    return [FixedTarget(SkyCoord(ra, dec, unit="deg"), name=f"field-{number:02d}") for number, (ra, dec) in enumerate(positions)]


@pytest.fixture(autouse=True)
def quiet():
    warnings.filterwarnings("ignore", category=UserWarning, module="streakcast")


@pytest.fixture
def log(caplog):
    caplog.set_level(logging.INFO, logger="streakcast.astroplan")
    return caplog
