"""Shared fixtures: a simulated constellation in a file, an observer of pyobs, 20 tasks (no download)."""

import logging
from collections import OrderedDict

import numpy as np
import pytest
from astroplan import Observer
from astropy import units as u
from astropy.coordinates import EarthLocation
from astropy.utils import iers
from pyobs.robotic import Task
from pyobs.utils.time import Time

from brute_force import Sky, walker, write_tle

iers.conf.auto_download = False
iers.conf.auto_max_age = None

#: Evening twilight at Rubin Observatory, when the Sun is at -12 deg.
START = Time("2026-04-25T22:50:00", scale="utc")
LOCATION = EarthLocation.from_geodetic(lon=-70.7494, lat=-30.2444, height=2663.0)
SHELLS = [(550.0, 53.0, 36, 22), (1200.0, 87.9, 36, 40)]
FOV_DEG = 6.0
TASK_S = 300.0


@pytest.fixture(scope="session")
def elements(tmp_path_factory):
    """Returns an element file, and the same satellites for the brute-force computation."""
    path = tmp_path_factory.mktemp("elements") / "walker.tle"
    return path, write_tle(path, walker(SHELLS, START))


@pytest.fixture(scope="session")
def settings(elements):
    """Returns settings of the model as in YAML."""
    return {"elements": str(elements[0]), "fov": f"{FOV_DEG}deg"}


@pytest.fixture(scope="session")
def sky(elements):
    """Returns the independent brute-force computation."""
    return Sky(elements[1], LOCATION)


@pytest.fixture(scope="session")
def observer():
    return Observer(location=LOCATION, name="test site")


@pytest.fixture
def tasks():
    """Returns 20 tasks of five minutes, above the horizon in the evening."""
    random = np.random.default_rng(20260425)
    positions = zip(random.uniform(110.0, 180.0, 20), random.uniform(-60.0, -5.0, 20))
    return [
        Task.model_validate(
            {
                "id": number,
                "name": f"field-{number:02d}",
                "duration": TASK_S,
                "priority": 1.0 + 0.01 * number,
                "merits": [{"class": "pyobs.robotic.scheduler.merits.PerNightMerit", "count": 1}],
                "target": {"class": "pyobs.robotic.scheduler.targets.SiderealTarget", "name": f"field-{number:02d}", "ra": ra, "dec": dec},
            },
            by_alias=True,
        )
        for number, (ra, dec) in enumerate(positions)
    ]


@pytest.fixture
def hours():
    """Returns start and end of the scheduled two hours."""
    return START, START + 2 * u.hour


@pytest.fixture
def log(caplog):
    caplog.set_level(logging.WARNING, logger="streakcast.pyobs")
    return caplog


@pytest.fixture(autouse=True)
def separate_counters(monkeypatch):
    """Clears the hooks that are common to all settings of a model, so that counts start at zero."""
    from streakcast_pyobs import _shared

    monkeypatch.setattr(_shared, "_hosts", OrderedDict())
    monkeypatch.setattr(_shared, "_broken", {})
