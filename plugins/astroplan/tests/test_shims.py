"""Interfaces to POCS and M4OPT. Tests with these packages are skipped if they are not installed."""

import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from astroplan import FixedTarget
from astropy import units as u
from astropy.coordinates import AltAz, SkyCoord
from astropy.time import Time

from conftest import FOV_DEG, LOCATION, START
from streakcast_astroplan import SatelliteStreakConstraint
from streakcast_astroplan.m4opt import SatelliteStreaks as ForM4opt
from streakcast_astroplan.pocs import SatelliteStreaks as ForPocs


@pytest.fixture
def field(targets):
    """Returns a POCS observation of ten exposures of 30 s."""
    return SimpleNamespace(field=targets[0], exptime=30 * u.s, exp_set_size=10, dark=False)


@pytest.fixture
def options(elements):
    """Returns options as POCS reads them from YAML."""
    location = {"latitude_deg": LOCATION.lat.deg, "longitude_deg": LOCATION.lon.deg, "height_m": LOCATION.height.to_value("m")}
    return {"model": {"site": location, "elements": str(elements[0]), "fov": f"{FOV_DEG}deg"}, "readout": 5.0}


def pocs(options, **more):
    """Returns the constraint without logging and configuration server of POCS."""
    return ForPocs(**options, **more)


def test_valid_a_pocs_score_is_the_fraction_of_clear_exposures(options, observer, field, sky):
    constraint = pocs(options, weight=2.0)
    contacts = sky.contacts(field.field.coord, START, 3700.0, FOV_DEG / 2)
    scores = []
    for minute in range(0, 54, 3):
        veto, score = constraint.get_score(START + minute * u.min, observer, field, moon=None)
        hit = sum(any(a <= start + 30 and b >= start for _, a, b in contacts) for start in 60.0 * minute + 35.0 * np.arange(10))
        # The margin, and satellites at the edge of the field, may affect one more exposure.
        assert not veto and 0.0 <= 2.0 * (10 - hit) / 10 - score <= 2.0 * 2 / 10 + 1e-9
        scores.append(score)
    assert min(scores) < max(scores) == 2.0
    assert constraint.hook.counts["failed"] == 0 and constraint.hook.counts["asked"] == 18


def test_pocs_vetoes_only_if_configured(options, observer, field):
    times = [START + minute * u.min for minute in range(0, 60, 3)]
    never, strict = pocs(options), pocs(options, min_clear_share=1.0)
    assert not any(never.get_score(time, observer, field)[0] for time in times)
    for time in times:
        veto, score = strict.get_score(time, observer, field)
        assert veto == (score < 1.0)
    field.dark = True
    assert all(strict.get_score(time, observer, field) == (False, 1.0) for time in times)


def test_pocs_continues_after_errors(options, observer, log):
    log.set_level("WARNING", logger="streakcast.pocs")
    constraint = pocs(options)
    broken = SimpleNamespace(field=SimpleNamespace(), exptime=30 * u.s, exp_set_size=10)
    assert all(constraint.get_score(START, observer, broken) == (False, 1.0) for _ in range(3))
    # A field near the zenith, so that the result does not depend on the time of day.
    overhead = SkyCoord(AltAz(alt=80 * u.deg, az=180 * u.deg, obstime=Time.now(), location=LOCATION)).icrs
    up = SimpleNamespace(field=FixedTarget(overhead, name="overhead"), exptime=30 * u.s, exp_set_size=10)
    off = Time.now() + 37 * u.s
    for _ in range(3):
        constraint.get_score(off, observer, up)
        # POCS reads the time some seconds before it scores all fields.
        constraint.get_score(Time.now() - 10 * u.s, observer, up)
    counts = constraint.hook.counts
    assert counts["failed"] == 3 and counts["clock"] == 3
    # The third message states that positions are unknown today, because the element sets are old.
    messages = [one.message for one in log.records if one.name == "streakcast.pocs"]
    assert len(messages) == 3 and sum("counted as 'unknown'" in one for one in messages) == 1


class WithoutSite:
    """Observer or location that raises errors."""

    @property
    def location(self):
        raise RuntimeError("no such site")

    shape = location


def test_unreadable_sites_and_clocks_do_not_stop_the_host(options, model, observer, field, targets):
    constraint = pocs(options)
    expected = constraint.get_score(START, observer, field)
    assert constraint.get_score(START, WithoutSite(), field) == expected
    assert constraint.hook.counts["site"] == 1 and constraint.hook.counts["failed"] == 0
    # For an invalid time the score cannot be computed either.
    assert constraint.get_score("soon", observer, field) == (False, 1.0)
    assert constraint.hook.counts["clock"] == constraint.hook.counts["failed"] == 1
    for_m4opt = ForM4opt(model, 30 * u.s)
    arguments = (targets[0].coord, START + np.arange(20) * 60 * u.s)
    assert (for_m4opt(WithoutSite(), *arguments) == for_m4opt(observer.location, *arguments)).all()
    assert for_m4opt.constraint.hook.counts["site"] == 1


@pytest.mark.filterwarnings("ignore::Warning")
def test_the_real_pocs_loads_it_by_its_dotted_name(options, observer):
    try:
        from panoptes.pocs.scheduler import create_constraints_from_config
        from panoptes.pocs.scheduler.constraint import BaseConstraint
        from panoptes.pocs.scheduler.dispatch import Scheduler
    except ImportError:
        warnings.warn("*** SKIPPED the test with POCS itself: panoptes-pocs 0.8.6 (740 MB, Python 3.12) is not installed", stacklevel=1)
        pytest.skip("no panoptes-pocs; pip install panoptes-pocs==0.8.6 in an environment of Python 3.12")
    config = {"constraints": [{"name": "streakcast_astroplan.pocs.SatelliteStreaks", "options": options}]}
    (constraint,) = create_constraints_from_config(config)
    assert isinstance(constraint, BaseConstraint) and isinstance(constraint, ForPocs)
    fields = [
        {"field": {"name": f"field-{number}", "position": f"{ra}deg {dec}deg"}, "observation": {"exptime": 30, "min_nexp": 10, "exp_set_size": 10}}
        for number, (ra, dec) in enumerate([(150.0, -30.0), (140.0, -20.0), (160.0, -40.0), (130.0, -10.0)])
    ]
    scheduler = Scheduler(observer, fields_list=fields, constraints=[constraint])
    chosen = []
    for minute in range(0, 60, 4):
        scores = dict(scheduler.get_observation(time=START + minute * u.min, show_all=True))
        alone = {name: constraint.get_score(START + minute * u.min, observer, one)[1] * one.priority for name, one in scheduler.observations.items()}
        chosen.append(min(alone.values()) < max(alone.values()))
        best = scheduler.get_observation(time=START + minute * u.min)[0]
        assert alone[getattr(best, "name", best)] == max(alone.values()) and set(scores) >= set(alone)
    assert any(chosen) and constraint.hook.counts["failed"] == 0


def test_m4opt_shapes(model, observer, targets):
    constraint = ForM4opt(model, 30 * u.s)
    own = SatelliteStreakConstraint(model, 30 * u.s, each="exposure")
    coordinates = SkyCoord([one.coord for one in targets[:4]])
    times = START + np.arange(60) * 60 * u.s
    # All targets at all times, or one target at one time.
    result = constraint(observer_location=observer.location, target_coord=coordinates[:, np.newaxis], obstime=times)
    assert result.shape == (4, 60) and result.dtype == bool and 0 < (~result).sum() < 120
    assert (result == own(observer, targets[:4], times, grid_times_targets=True)).all()
    for index in (3, 17):
        single = constraint(observer_location=observer.location, target_coord=coordinates[1], obstime=times[index])
        assert single.shape == () and single == result[1, index]
    assert constraint.constraint.hook.counts["site"] == 0


@pytest.mark.filterwarnings("ignore::Warning")
def test_the_real_m4opt_combines_the_constraint_with_others(model, observer, targets):
    try:
        from m4opt.constraints import AltitudeConstraint, Constraint
    except ImportError:
        warnings.warn("*** SKIPPED the test with M4OPT itself: m4opt 4.0 (needs CPLEX) is not installed", stacklevel=1)
        pytest.skip("no m4opt; pip install --no-deps m4opt==4.0.0 aep8 synphot sympy dust-extinction frozendict dustmaps is sufficient for constraints")
    constraint = ForM4opt(model, 30 * u.s)
    assert isinstance(constraint, Constraint)
    coordinates = SkyCoord([one.coord for one in targets[:3]])[:, np.newaxis]
    times = START + np.arange(30) * 120 * u.s
    arguments = (observer.location, coordinates, times)
    clear, high = constraint(*arguments), AltitudeConstraint(60 * u.deg, 90 * u.deg)(*arguments)
    both = (constraint & AltitudeConstraint(60 * u.deg, 90 * u.deg))(*arguments)
    assert (both == (clear & high)).all() and ((~constraint)(*arguments) == ~clear).all()
    assert 0 < both.sum() < clear.sum() < clear.size
