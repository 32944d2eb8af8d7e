"""Errors during a night are counted and logged once, and never stop pyobs; invalid settings fail at construction."""

import asyncio
import os
import pickle
import time
from types import SimpleNamespace

import numpy as np
import pytest
from astroplan import Observer
from astropy import units as u
from astropy.coordinates import EarthLocation, SkyCoord
from astropy.time import TimeDelta
from pyobs.robotic import Task
from pyobs.robotic.scheduler import DataProvider
from pyobs.robotic.scheduler.constraints import Constraint
from pyobs.robotic.scheduler.targets import SiderealTarget, Target
from pyobs.utils.time import Time

from brute_force import walker, write_tle
from conftest import LOCATION, SHELLS, START
from streakcast.hosts import Hook
from streakcast_pyobs import SatelliteConstraint, SatelliteMerit, _shared

CENTRE = {"ra": 150.0, "dec": -30.0}


def constraint_of(settings, **options):
    """Creates a constraint with the site of an observer, as pyobs does."""
    context = {"observer": Observer(location=LOCATION, name="test site")}
    return Constraint.model_validate({"class": "streakcast_pyobs.SatelliteConstraint", "model": settings, **options}, context=context)


def results(constraint, tasks, data, minutes=range(0, 60, 3)):
    async def all_of_them():
        return [await constraint(START + minute * u.min, task, data) for task in tasks[:5] for minute in minutes]

    return asyncio.run(all_of_them())


@pytest.fixture
def data(observer):
    return DataProvider(observer)


def lines(log):
    return [record for record in log.records if record.name == "streakcast.pyobs"]


def test_the_default_site_is_that_of_the_observer(settings, observer):
    constraint = constraint_of(settings, exposure_s=30)
    assert constraint.hook().model.site.name == "test site"
    assert (constraint.cost, constraint.target_dependent) == (50.0, True)
    again = Constraint.model_validate(constraint.model_dump())
    assert again.model_dump() == constraint.model_dump() and again.hook() is constraint.hook()
    with pytest.raises(ValueError, match="site"):
        SatelliteConstraint(model=settings)


def test_copies_contain_settings_only(settings, tasks, data):
    constraint = constraint_of(settings, exposure_s=30)
    expected = results(constraint, tasks, data)
    assert len(pickle.dumps(constraint)) < 5000
    for copy in (pickle.loads(pickle.dumps(constraint)), constraint.model_copy(deep=True)):
        assert results(copy, tasks, data) == expected and not all(expected)


def test_filter_skycoord_agrees_with_calls(settings, tasks, data):
    constraint = constraint_of(settings, exposure_s=60, n_exposures=5)
    coordinates = SkyCoord([task.target.coord for task in tasks[:5]])
    for minute in (0, 6, 12):
        mask = asyncio.run(constraint.filter_skycoord(START + minute * u.min, coordinates, data))
        assert mask.dtype == bool and mask.tolist() == results(constraint, tasks, data, [minute])


def test_the_duration_of_the_task_counts(settings, tasks, data):
    constraint = constraint_of(settings)
    clear = []
    for duration_s in (0.0, 60.0, 600.0):
        for task in tasks:
            task.duration = duration_s
        clear.append(sum(results(constraint, tasks, data)))
    assert clear[0] > clear[1] > clear[2]


def test_merits_are_fractions(settings, tasks, data):
    merit = SatelliteMerit(model={**settings, "mpc": "X05"}, exposure_s=55, readout_s=5, worst_merit=0.1)
    values = results(merit, tasks, data)
    allowed = 0.1 + 0.9 * np.arange(6) / 5
    assert all(np.abs(allowed - value).min() < 1e-9 for value in values)
    assert len(set(np.round(values, 6))) >= 3 and max(values) == 1.0


def test_a_fraction_of_exposures_may_be_crossed(settings, tasks, data):
    strict, patient = (constraint_of(settings, exposure_s=55, readout_s=5, min_clear_share=share) for share in (1.0, 0.6))
    assert sum(results(strict, tasks, data)) < sum(results(patient, tasks, data))


def test_deleted_or_broken_element_files_keep_the_old_satellites(tmp_path, tasks, data, log):
    path = tmp_path / "gp.tle"
    write_tle(path, walker(SHELLS[:1], START))
    constraint = constraint_of({"elements": str(path), "fov": "6deg"}, exposure_s=30)
    hook = constraint.hook()
    hook._state.watch_s, hook._state.next_check_s = 1e-6, 0.0
    before = results(constraint, tasks, data)
    text = path.read_text()
    path.unlink()
    assert results(constraint, tasks, data) == before and not all(before)
    assert hook.counts["kept_old"] >= 1 and len(lines(log)) == 1
    path.write_text(text[: len(text) // 5])
    os.utime(path, (time.time() - 60, time.time() - 60))
    for _ in range(2):
        assert results(constraint, tasks, data) == before
        hook.settle()
    assert hook.counts["failed"] == hook.counts["reloaded"] == 0 and len(lines(log)) == 2


def test_settings_in_a_process_without_files_count_as_clear(tmp_path, tasks, data, log, monkeypatch):
    """Settings unpickled in a process without the element files are not validated, and must not raise errors."""
    path = tmp_path / "gp.tle"
    write_tle(path, walker(SHELLS[:1], START))
    constraint = constraint_of({"elements": str(path), "fov": "6deg"}, exposure_s=30)
    expected, pickled, content = results(constraint, tasks, data), pickle.dumps(constraint), path.read_text()
    _shared._hosts.clear()
    path.unlink()
    constraint = pickle.loads(pickled)
    assert all(results(constraint, tasks, data)) and not all(expected)
    coordinates = SkyCoord([task.target.coord for task in tasks[:5]])
    assert asyncio.run(constraint.filter_skycoord(START, coordinates, data)).all()
    times = START + np.arange(10) * u.min
    assert constraint.to_astroplan().compute_constraint(times, data.observer, coordinates[:, np.newaxis]).shape == (5, 10)
    assert len(lines(log)) == 1 and "gp.tle" in lines(log)[0].message
    # Files that appear later are read within a minute.
    path.write_text(content)
    assert all(results(constraint, tasks, data))
    monkeypatch.setattr(_shared, "monotonic", lambda: time.monotonic() + _shared.RETRY_S)
    assert results(constraint, tasks, data) == expected


def test_unused_models_are_removed_from_the_cache(settings, monkeypatch):
    monkeypatch.setattr(_shared, "CACHED_HOSTS", 2)
    first = constraint_of({**settings, "fov": "1deg"})
    hook = first.hook()
    for degrees in (2, 3):
        constraint_of({**settings, "fov": f"{degrees}deg"})
        # Used between the others, so that it stays in the cache.
        assert first.hook() is hook
    assert len(_shared._hosts) == 2


def test_an_unreadable_site_or_clock_does_not_stop_the_host(settings, tasks, observer, log, monkeypatch):
    constraint = constraint_of(settings, exposure_s=30)
    expected = results(constraint, tasks, DataProvider(observer))
    monkeypatch.setattr(_shared.Time, "now", lambda: 1 / 0)
    _shared._hosts.clear()
    assert results(constraint, tasks, SimpleNamespace()) == expected

    class Broken:
        @property
        def observer(self):
            raise RuntimeError("no observer")

    assert results(constraint, tasks, Broken()) == expected
    counts = constraint.hook().counts
    assert counts["site"] >= 1 and counts["clock"] >= 1 and counts["failed"] == 0 and len(lines(log)) == 2


class WithoutCoordinates(Target):
    """Target without coordinates."""

    def coordinates(self, time):
        raise RuntimeError("no ephemeris")


def test_targets_without_coordinates_count_as_clear(settings, data, log):
    constraint = constraint_of(settings, exposure_s=30)
    without = Task(name="none", duration=60.0)
    broken = Task(name="broken", duration=60.0, target=WithoutCoordinates(name="nowhere"))
    unknown = Task(name="unknown", duration=60.0, target=SiderealTarget(name="nan", ra=float("nan"), dec=0.0))
    assert all(results(constraint, [without, broken, unknown], data))
    assert constraint.hook().counts["target"] == 60 and len(lines(log)) == 3


def test_a_different_site_is_logged_once(settings, tasks, log):
    constraint = constraint_of(settings, exposure_s=30)
    far = EarthLocation.from_geodetic(LOCATION.lon, LOCATION.lat + 2.0 * u.km / (6371 * u.km) * u.rad, LOCATION.height)
    assert not all(results(constraint, tasks, DataProvider(Observer(location=far))))
    assert constraint.hook().counts["site"] == 1 and len(lines(log)) == 1 and "2.0 km apart" in lines(log)[0].message


def test_a_clock_error_of_37_s_is_logged_once(settings, tasks, data, log):
    right = results(constraint_of(settings, exposure_s=30), tasks, data)
    _shared._hosts.clear()
    constraint = constraint_of(settings, exposure_s=30)
    Time.set_offset_to_now(TimeDelta(37 * u.s))
    try:
        assert results(constraint, tasks, data) == right
    finally:
        Time.set_offset_to_now(TimeDelta(0 * u.s))
    assert constraint.hook().counts["clock"] >= 1
    assert len(lines(log)) == 1 and "TAI was probably read as UTC" in lines(log)[0].message


def test_errors_of_the_model_count_as_clear(settings, tasks, data, log, monkeypatch):
    constraint, merit = constraint_of(settings, exposure_s=30), SatelliteMerit(model={**settings, "mpc": "X05"}, exposure_s=30)
    monkeypatch.setattr(_shared.ClearStarts, "worth_of_block", lambda *_: 1 / 0)
    assert all(results(constraint, tasks, data)) and set(results(merit, tasks, data)) == {1.0}
    assert constraint.hook().counts["failed"] == merit.hook().counts["failed"] == 100 and len(lines(log)) == 2


def test_hooks_are_of_the_streakcast_package(settings):
    assert type(constraint_of(settings).hook()) is Hook


INVALID = {
    "no-such-file": {"model": {"elements": "no-such-file.csv", "fov": "1deg"}},
    "no field of view": {"model": {"shells": "starlink-gen1"}},
    "has no argument 'elemnts'": {"model": {"elemnts": "gp.csv"}},
    "greater than 0": {"exposure_s": 0},
    "readout and n_exposures are given without exposure": {"n_exposures": 3},
    "blocking is 'all'; allowed: any, avoid": {"blocking": "all"},
    "less than or equal to 1": {"min_clear_share": 1.5},
    "Extra inputs are not permitted": {"exposure": 30},
}


@pytest.mark.parametrize("message", INVALID)
def test_invalid_settings_are_reported_at_construction(settings, message):
    options = {"model": settings, **INVALID[message]}
    context = {"observer": Observer(location=LOCATION)}
    with pytest.raises((ValueError, TypeError), match=message):
        Constraint.model_validate({"class": "streakcast_pyobs.SatelliteConstraint", **options}, context=context)


def test_a_score_of_cost_needs_a_telescope(settings):
    with pytest.raises(ValueError, match="no telescope"):
        SatelliteMerit(model={**settings, "mpc": "X05"}, score="cost")


def test_with_a_telescope_the_merit_is_that_of_the_cost(settings):
    def score(**options):
        return SatelliteMerit(**{"model": {**settings, "mpc": "X05", "telescope": "rubin"}, **options}).rules().score

    assert (score(), score(blocking="any"), score(score="clear")) == ("cost", "clear", "clear")
    assert score(model={**settings, "mpc": "X05"}) == "clear"
