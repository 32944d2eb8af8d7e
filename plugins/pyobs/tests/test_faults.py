"""What fails at night is counted, said once, and never stops pyobs; what cannot work is said at construction."""

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


def made(settings, **options):
    """A constraint as pyobs makes one, with the site of its observer."""
    context = {"observer": Observer(location=LOCATION, name="test site")}
    return Constraint.model_validate({"class": "streakcast_pyobs.SatelliteConstraint", "model": settings, **options}, context=context)


def answers(constraint, tasks, data, minutes=range(0, 60, 3)):
    async def all_of_them():
        return [await constraint(START + minute * u.min, task, data) for task in tasks[:5] for minute in minutes]

    return asyncio.run(all_of_them())


@pytest.fixture
def data(observer):
    return DataProvider(observer)


def lines(log):
    return [record for record in log.records if record.name == "streakcast.pyobs"]


def test_yaml_makes_it_with_the_site_of_the_observer(settings, observer):
    constraint = made(settings, exposure_s=30)
    assert constraint.hook().model.site.name == "test site"
    assert (constraint.cost, constraint.target_dependent) == (50.0, True)
    again = Constraint.model_validate(constraint.model_dump())
    assert again.model_dump() == constraint.model_dump() and again.hook() is constraint.hook()
    with pytest.raises(ValueError, match="site"):
        SatelliteConstraint(model=settings)


def test_copies_hold_settings_only(settings, tasks, data):
    constraint = made(settings, exposure_s=30)
    expected = answers(constraint, tasks, data)
    assert len(pickle.dumps(constraint)) < 5000
    for copy in (pickle.loads(pickle.dumps(constraint)), constraint.model_copy(deep=True)):
        assert answers(copy, tasks, data) == expected and not all(expected)


def test_filter_skycoord_is_the_same_question(settings, tasks, data):
    constraint = made(settings, exposure_s=60, n_exposures=5)
    coordinates = SkyCoord([task.target.coord for task in tasks[:5]])
    for minute in (0, 6, 12):
        mask = asyncio.run(constraint.filter_skycoord(START + minute * u.min, coordinates, data))
        assert mask.dtype == bool and mask.tolist() == answers(constraint, tasks, data, [minute])


def test_the_duration_of_the_task_counts(settings, tasks, data):
    constraint = made(settings)
    clear = []
    for duration_s in (0.0, 60.0, 600.0):
        for task in tasks:
            task.duration = duration_s
        clear.append(sum(answers(constraint, tasks, data)))
    assert clear[0] > clear[1] > clear[2]


def test_merits_are_shares(settings, tasks, data):
    merit = SatelliteMerit(model={**settings, "mpc": "X05"}, exposure_s=55, readout_s=5, worst_merit=0.1)
    values = answers(merit, tasks, data)
    allowed = 0.1 + 0.9 * np.arange(6) / 5
    assert all(np.abs(allowed - value).min() < 1e-9 for value in values)
    assert len(set(np.round(values, 6))) >= 3 and max(values) == 1.0


def test_a_share_may_be_spoilt(settings, tasks, data):
    strict, patient = (made(settings, exposure_s=55, readout_s=5, min_clear_share=share) for share in (1.0, 0.6))
    assert sum(answers(strict, tasks, data)) < sum(answers(patient, tasks, data))


def test_elements_that_vanish_or_break_leave_the_old_ones(tmp_path, tasks, data, log):
    path = tmp_path / "gp.tle"
    write_tle(path, walker(SHELLS[:1], START))
    constraint = made({"elements": str(path), "fov": "6deg"}, exposure_s=30)
    hook = constraint.hook()
    hook._state.watch_s, hook._state.next_look_s = 1e-6, 0.0
    before = answers(constraint, tasks, data)
    text = path.read_text()
    path.unlink()
    assert answers(constraint, tasks, data) == before and not all(before)
    assert hook.counts["kept_old"] >= 1 and len(lines(log)) == 1
    path.write_text(text[: len(text) // 5])
    os.utime(path, (time.time() - 60, time.time() - 60))
    for _ in range(2):
        assert answers(constraint, tasks, data) == before
        hook.settle()
    assert hook.counts["failed"] == hook.counts["reloaded"] == 0 and len(lines(log)) == 2


def test_settings_in_a_process_without_files_let_everything_through(tmp_path, tasks, data, log, monkeypatch):
    """Unpickled where the elements are not: nothing was validated there, and nothing may stop there."""
    path = tmp_path / "gp.tle"
    write_tle(path, walker(SHELLS[:1], START))
    constraint = made({"elements": str(path), "fov": "6deg"}, exposure_s=30)
    expected, text, kept = answers(constraint, tasks, data), pickle.dumps(constraint), path.read_text()
    _shared._hosts.clear()
    path.unlink()
    constraint = pickle.loads(text)
    assert all(answers(constraint, tasks, data)) and not all(expected)
    coordinates = SkyCoord([task.target.coord for task in tasks[:5]])
    assert asyncio.run(constraint.filter_skycoord(START, coordinates, data)).all()
    times = START + np.arange(10) * u.min
    assert constraint.to_astroplan().compute_constraint(times, data.observer, coordinates[:, np.newaxis]).shape == (5, 10)
    assert len(lines(log)) == 1 and "gp.tle" in lines(log)[0].message
    # They come, and are read within a minute.
    path.write_text(kept)
    assert all(answers(constraint, tasks, data))
    monkeypatch.setattr(_shared, "monotonic", lambda: time.monotonic() + _shared.AGAIN_S)
    assert answers(constraint, tasks, data) == expected


def test_models_that_nobody_asks_any_more_are_forgotten(settings, monkeypatch):
    monkeypatch.setattr(_shared, "KEPT_HOSTS", 2)
    first = made({**settings, "fov": "1deg"})
    hook = first.hook()
    for degrees in (2, 3):
        made({**settings, "fov": f"{degrees}deg"})
        # Asked in between: it stays.
        assert first.hook() is hook
    assert len(_shared._hosts) == 2


def test_a_host_without_a_site_or_a_clock_goes_on(settings, tasks, observer, log, monkeypatch):
    constraint = made(settings, exposure_s=30)
    expected = answers(constraint, tasks, DataProvider(observer))
    monkeypatch.setattr(_shared.Time, "now", lambda: 1 / 0)
    _shared._hosts.clear()
    assert answers(constraint, tasks, SimpleNamespace()) == expected

    class Broken:
        @property
        def observer(self):
            raise RuntimeError("no observer")

    assert answers(constraint, tasks, Broken()) == expected
    counts = constraint.hook().counts
    assert counts["site"] >= 1 and counts["clock"] >= 1 and counts["failed"] == 0 and len(lines(log)) == 2


class Nowhere(Target):
    """A target that cannot say where it is."""

    def coordinates(self, time):
        raise RuntimeError("no ephemeris")


def test_targets_without_coordinates_go_through(settings, data, log):
    constraint = made(settings, exposure_s=30)
    without = Task(name="none", duration=60.0)
    broken = Task(name="broken", duration=60.0, target=Nowhere(name="nowhere"))
    unknown = Task(name="unknown", duration=60.0, target=SiderealTarget(name="nan", ra=float("nan"), dec=0.0))
    assert all(answers(constraint, [without, broken, unknown], data))
    assert constraint.hook().counts["target"] == 60 and len(lines(log)) == 3


def test_a_site_elsewhere_is_said_once(settings, tasks, log):
    constraint = made(settings, exposure_s=30)
    far = EarthLocation.from_geodetic(LOCATION.lon, LOCATION.lat + 2.0 * u.km / (6371 * u.km) * u.rad, LOCATION.height)
    assert not all(answers(constraint, tasks, DataProvider(Observer(location=far))))
    assert constraint.hook().counts["site"] == 1 and len(lines(log)) == 1 and "2.0 km apart" in lines(log)[0].message


def test_a_clock_37_s_wrong_is_said_once(settings, tasks, data, log):
    right = answers(made(settings, exposure_s=30), tasks, data)
    _shared._hosts.clear()
    constraint = made(settings, exposure_s=30)
    Time.set_offset_to_now(TimeDelta(37 * u.s))
    try:
        assert answers(constraint, tasks, data) == right
    finally:
        Time.set_offset_to_now(TimeDelta(0 * u.s))
    assert constraint.hook().counts["clock"] >= 1
    assert len(lines(log)) == 1 and "TAI read as UTC" in lines(log)[0].message


def test_a_model_that_breaks_lets_everything_through(settings, tasks, data, log, monkeypatch):
    constraint, merit = made(settings, exposure_s=30), SatelliteMerit(model={**settings, "mpc": "X05"}, exposure_s=30)
    monkeypatch.setattr(_shared.ClearStarts, "worth_of_block", lambda *_: 1 / 0)
    assert all(answers(constraint, tasks, data)) and set(answers(merit, tasks, data)) == {1.0}
    assert constraint.hook().counts["failed"] == merit.hook().counts["failed"] == 100 and len(lines(log)) == 2


def test_hooks_are_those_of_the_wheel(settings):
    assert type(made(settings).hook()) is Hook


REFUSED = {
    "no-such-file": {"model": {"elements": "no-such-file.csv", "fov": "1deg"}},
    "no field of view": {"model": {"shells": "starlink-gen1"}},
    "has no argument 'elemnts'": {"model": {"elemnts": "gp.csv"}},
    "greater than 0": {"exposure_s": 0},
    "readout and n_exposures are given without exposure": {"n_exposures": 3},
    "blocking is 'all'; allowed: any, avoid": {"blocking": "all"},
    "less than or equal to 1": {"min_clear_share": 1.5},
    "Extra inputs are not permitted": {"exposure": 30},
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_cannot_work_is_said_at_construction(settings, message):
    options = {"model": settings, **REFUSED[message]}
    context = {"observer": Observer(location=LOCATION)}
    with pytest.raises((ValueError, TypeError), match=message):
        Constraint.model_validate({"class": "streakcast_pyobs.SatelliteConstraint", **options}, context=context)


def test_a_score_of_pixels_needs_a_telescope(settings):
    with pytest.raises(ValueError, match="no telescope"):
        SatelliteMerit(model={**settings, "mpc": "X05"}, score="pixels")
