"""Errors during a night are counted and logged once, and never stop astroplan."""

import os
import time
import warnings

import numpy as np
import pytest
from astroplan import AltitudeConstraint, ObservingBlock, Observer, PriorityScheduler, Schedule, Transitioner
from astropy import units as u
from astropy.coordinates import EarthLocation, SkyCoord

from brute_force import walker, write_tle
from conftest import FOV_DEG, LOCATION, SHELLS, START
from streakcast import StreakModel
from streakcast.hosts import Hook
from streakcast_astroplan import SatelliteStreakConstraint

TIMES = START + np.arange(120) * 20 * u.s


@pytest.fixture
def replaced(tmp_path):
    """Returns the path of an element file, and a constraint that checks the file at each call."""
    path = tmp_path / "gp.tle"
    write_tle(path, walker(SHELLS[:1], START))
    hook = Hook(StreakModel(site=LOCATION, elements=path, fov=FOV_DEG * u.deg), "astroplan", watch_s=1e-6)
    return path, SatelliteStreakConstraint(hook, 30.0)


def lines(log):
    return [record for record in log.records if record.name == "streakcast.astroplan"]


def aged(path):
    """Sets an old modification time, as for a file that was written completely."""
    os.utime(path, (time.time() - 60, time.time() - 60))


def test_deleted_element_files_keep_the_old_satellites(replaced, observer, targets, log):
    path, constraint = replaced
    before = constraint(observer, targets, TIMES, grid_times_targets=True)
    path.unlink()
    for shift_s in (0.0, 1e-3, 2e-3):
        after = constraint(observer, targets, TIMES + shift_s * u.s, grid_times_targets=True)
        assert (after != before).mean() < 0.01
    assert constraint.hook.counts["kept_old"] >= 1 and constraint.hook.counts["failed"] == 0
    assert len(lines(log)) == 1 and "is missing; the satellites read before stay in use" in lines(log)[0].message


def test_partial_element_files_keep_the_old_satellites_and_complete_ones_are_read(replaced, observer, targets, log):
    path, constraint = replaced
    before = constraint(observer, targets, TIMES, grid_times_targets=True)
    text = path.read_text()
    path.write_text(text[: len(text) // 5])
    aged(path)
    for shift_s in (1e-3, 2e-3):
        assert (constraint(observer, targets, TIMES + shift_s * u.s, grid_times_targets=True) != before).mean() < 0.01
        constraint.hook.settle()
    # An invalid file is read again, and logged once. The other message states that the element sets are old now.
    assert constraint.hook.counts["kept_old"] >= 1 and len([one for one in lines(log) if "counted as 'kept_old'" in one.message]) == 1
    assert len(lines(log)) <= 2
    # The same satellites an hour later in their orbits.
    write_tle(path, walker(SHELLS[:1], START + 17 * u.min))
    aged(path)
    constraint(observer, targets[0], TIMES)
    constraint.hook.settle()
    after = constraint(observer, targets, TIMES, grid_times_targets=True)
    assert constraint.hook.counts["reloaded"] == 1 and (after != before).any()


def test_old_elements_are_used_with_a_warning(tmp_path, observer, targets):
    path = tmp_path / "old.tle"
    write_tle(path, walker(SHELLS[:1], START - 40 * u.day))
    constraint = SatelliteStreakConstraint(StreakModel(site=LOCATION, elements=path, fov=FOV_DEG * u.deg), 30.0)
    with pytest.warns(UserWarning, match="days"):
        constraint.hook.model.assess((150.0, -30.0), START, 30.0)
    assert not constraint(observer, targets, TIMES, grid_times_targets=True).all()
    assert constraint.hook.counts["failed"] == 0


def test_only_targets_without_coordinates_count_as_observable(model, observer, targets, log):
    constraint = SatelliteStreakConstraint(model)
    good = SkyCoord([one.coord for one in targets[:3]])[:, np.newaxis]
    partly_invalid = SkyCoord([good.ra.deg[0, 0], np.nan, good.ra.deg[2, 0]], good.dec.deg[:, 0], unit="deg")[:, np.newaxis]
    expected = constraint.compute_constraint(TIMES, observer, good)
    for _ in range(3):
        result = constraint.compute_constraint(TIMES, observer, partly_invalid)
        assert result[1].all() and (result[[0, 2]] == expected[[0, 2]]).all() and not expected.all()
    assert constraint.compute_constraint(TIMES, observer, None).all()
    assert constraint.hook.counts["target"] == 4 and len(lines(log)) == 2


def test_a_different_site_is_logged_once(model, targets, log):
    constraint = SatelliteStreakConstraint(model, 30.0)
    near = EarthLocation.from_geodetic(LOCATION.lon, LOCATION.lat + 0.5 * u.km / (6371 * u.km) * u.rad, LOCATION.height)
    far = EarthLocation.from_geodetic(LOCATION.lon, LOCATION.lat + 2.0 * u.km / (6371 * u.km) * u.rad, LOCATION.height)
    constraint(Observer(location=near), targets[0], TIMES)
    assert constraint.hook.counts["site"] == 0
    for _ in range(5):
        assert not constraint(Observer(location=far), targets, TIMES, grid_times_targets=True).all()
    assert constraint.hook.counts["site"] >= 1
    assert len(lines(log)) == 1 and "2.0 km apart" in lines(log)[0].message


class WithoutSite:
    """Observer whose site raises an error."""

    @property
    def location(self):
        raise RuntimeError("no such site")


def test_an_unreadable_site_is_logged_once(model, observer, targets, log):
    constraint = SatelliteStreakConstraint(model, 30.0)
    expected = constraint.compute_constraint(TIMES, observer, targets[0].coord)
    assert (constraint.compute_constraint(TIMES, WithoutSite(), targets[0].coord) == expected).all() and not expected.all()
    assert constraint.hook.counts["site"] == 1 and constraint.hook.counts["failed"] == 0
    assert len(lines(log)) == 1 and "no such site" in lines(log)[0].message


def test_warnings_of_the_model_are_counted_and_logged_once(tmp_path, observer, targets, log):
    path = tmp_path / "old.tle"
    write_tle(path, walker(SHELLS[:1], START - 40 * u.day))
    constraint = SatelliteStreakConstraint(StreakModel(site=LOCATION, elements=path, fov=FOV_DEG * u.deg), 30.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(3):
            constraint.compute_constraint(TIMES, observer, targets[0].coord)
    assert constraint.hook.counts["warned"] == 1 and len([one for one in lines(log) if "14 days" in one.message]) == 1


def test_a_single_time_without_exposure_counts_as_observable(model, observer, targets, log):
    constraint = SatelliteStreakConstraint(model)
    assert bool(constraint(observer, targets[0], START)) and bool(constraint(observer, targets[0], START + 1 * u.s))
    assert constraint.hook.counts["instant"] == 2 and len(lines(log)) == 1


def test_exposures_longer_than_their_block_are_logged_once(model, observer, targets, log):
    constraint = SatelliteStreakConstraint(model, 60.0, n_exposures=10)
    for target in targets[:3]:
        constraint(observer, target, START + [0, 60, 120] * u.s)
    assert constraint.hook.counts["block"] == 3 and len(lines(log)) == 1 and "last 600 s" in lines(log)[0].message


def test_an_invalid_time_counts_as_observable(model, observer, targets, log):
    constraint = SatelliteStreakConstraint(model, 30.0)
    broken = START + [0, 20, 40] * u.s
    broken[1] = np.ma.masked
    for _ in range(3):
        assert constraint.compute_constraint(broken, observer, targets[0].coord).all()
    assert constraint.hook.counts["failed"] == 3 and len(lines(log)) == 1


@pytest.mark.parametrize("failure", ["model breaks", "clock 37 s wrong"])
def test_the_scheduler_continues(model, observer, targets, log, failure):
    start = START
    hook = Hook(model, "astroplan")
    if failure == "model breaks":
        hook.evaluate = lambda question, otherwise: Hook.evaluate(hook, lambda _: 1 / 0, otherwise)
    else:
        start = START + 37 * u.s
    constraint = SatelliteStreakConstraint(hook, 30.0)
    blocks = [ObservingBlock(target, 2 * u.min, 1) for target in targets[:5]]
    scheduler = PriorityScheduler(
        [AltitudeConstraint(min=25 * u.deg), constraint], observer, transitioner=Transitioner(slew_rate=2 * u.deg / u.s), time_resolution=1 * u.min
    )
    assert len(scheduler(blocks, Schedule(start, start + 1 * u.hour)).observing_blocks) == 5
    assert hook.counts["failed"] == (1 if failure == "model breaks" else 0)
    assert len(lines(log)) == hook.counts["failed"]
