"""Errors in the queue manager: rubin_scheduler continues, and each error is logged once."""

import copy
import logging
import time

import brute_force
import numpy as np
import pytest
import streakcast
from astropy.time import Time
from conftest import ids, manager_of
from rubin_scheduler.scheduler.schedulers import BaseQueueManager
from streakcast_rubin import StreakCostBasisFunction
from streakcast_rubin._verdicts import sun_altitude_deg


def test_an_error_gives_the_default_choice(ready, model, take_over, monkeypatch, caplog):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())

    def fails(*_, **__):
        raise RuntimeError("the index is gone")

    monkeypatch.setattr(streakcast.StreakModel, "assess", fails)
    with caplog.at_level(logging.WARNING):
        for _ in range(5):
            assert ids(scheduler.request_observation()) == [queue[0]]
    assert scheduler.queue_manager.counts["failed"] == 5
    assert len([one for one in caplog.records if "the index is gone" in one.message]) == 1


def test_a_visit_without_coordinates(ready, model, take_over, costly):
    # The first visit is compared with others.
    costly(20.0)
    scheduler = take_over(ready, manager_of(model))
    queue = scheduler.queue_manager.desired_observations_array
    indices = np.flatnonzero(scheduler.queue_manager.need_observing)
    queue["RA"][indices[2]] = np.nan
    assert ids(scheduler.request_observation()) == [int(queue["target_id"][indices[0]])]
    assert scheduler.queue_manager.counts["no_coordinates"] == 1 and scheduler.queue_manager.counts["failed"] == 0
    # If it is the first visit, the default visit of rubin_scheduler is used.
    queue["RA"][indices[0]] = np.nan
    manager = scheduler.queue_manager
    assert manager.find_valid_observations_indx(scheduler.conditions)[0] == indices[0]


def test_deleted_element_files(ready, folder, take_over, caplog):
    path = folder / "vanishing.csv"
    path.write_bytes((folder / "4408.csv").read_bytes())
    model = streakcast.StreakModel(site="Rubin Observatory", elements=path, telescope="rubin", mjd_scale="utc")
    scheduler = take_over(ready, manager_of(model, watch_s=0.01))
    scheduler.request_observation()
    path.unlink()
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            time.sleep(0.02)
            assert np.size(scheduler.request_observation()) == 1
    assert scheduler.queue_manager.counts["failed"] == 0
    assert scheduler.queue_manager.counts["kept_old"] >= 1
    assert len([one for one in caplog.records if "is missing" in one.message]) == 1


def test_old_element_sets_are_logged(ready, tmp_path, take_over, caplog):
    """Positions from element sets that are ten weeks old are inaccurate, but the scheduler continues."""
    brute_force.write_walker(["starlink-gen1"], Time("2025-11-05T00:00:00"), tmp_path / "old.csv")
    model = streakcast.StreakModel(site="Rubin Observatory", elements=tmp_path / "old.csv", telescope="rubin", mjd_scale="utc")
    scheduler = take_over(ready, manager_of(model, look_ahead=2))
    with caplog.at_level(logging.WARNING):
        for _ in range(2):
            assert np.size(scheduler.request_observation()) == 1
    assert scheduler.queue_manager.counts["warned"] >= 1 and scheduler.queue_manager.counts["failed"] == 0
    assert len([one for one in caplog.records if "more than 14 days" in one.message]) == 1


def test_a_different_site_is_logged(ready, folder, take_over, caplog):
    model = streakcast.StreakModel(lat=-30.0, lon=-70.0, height=2000.0, elements=folder / "4408.csv", telescope="rubin", mjd_scale="utc")
    scheduler = take_over(ready, manager_of(model))
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            assert np.size(scheduler.request_observation()) == 1
    # All three requests have the same conditions, whose site is compared once.
    assert scheduler.queue_manager.counts["site"] == 1
    assert len([one for one in caplog.records if "km apart" in one.message]) == 1


def test_the_site_of_rubin_scheduler_agrees(ready, model, take_over, caplog):
    scheduler = take_over(ready, manager_of(model))
    scheduler.request_observation()
    assert scheduler.queue_manager.counts["site"] == scheduler.queue_manager.counts["clock"] == 0


def test_a_clock_error_of_37_seconds_is_logged(ready, model, take_over, caplog):
    """The current time in TAI is passed as UTC."""
    scheduler = take_over(ready, manager_of(model))
    manager = scheduler.queue_manager
    manager.mount.last = None
    now = Time.now()
    scheduler.conditions._mjd = now.tai.mjd
    with caplog.at_level(logging.WARNING):
        manager.find_valid_observations_indx(scheduler.conditions)
        for _ in range(2):
            manager.hook.evaluate(lambda one: manager._choice(one, scheduler.conditions, np.flatnonzero(manager.need_observing)), None)
    # Conditions with the same time are as old as their queue, and are compared once.
    assert manager.counts["clock"] == 1
    # Without a last visit, the pointing is that of the conditions.
    assert manager.counts["failed"] == 0
    assert "37.0 s" in caplog.text


@pytest.mark.parametrize("kind", ["queue", "map"])
def test_a_wrong_scale_is_noticed_by_the_sun(kind, ready, model, take_over, caplog):
    """The MJD of the simulator is UTC."""
    conditions = ready.observatory.return_conditions()
    for scale, expected in (("utc", 0), ("tai", 1), ("tt", 1)):
        caplog.clear()
        if kind == "queue":
            scheduler = take_over(copy.deepcopy(ready), manager_of(model, mjd_scale=scale))
            hook = scheduler.queue_manager
            for _ in range(3):
                scheduler.request_observation()
        else:
            hook = StreakCostBasisFunction(model, mjd_scale=scale, ahead_min=45.0)
            for _ in range(3):
                hook.recalc = True
                hook(conditions)
        assert hook.counts["clock"] == expected and hook.counts["failed"] == 0
        assert len([one for one in caplog.records if "mjd_scale='utc' agrees" in one.message]) == expected


def test_the_altitude_of_the_sun_is_that_of_rubin_scheduler(ready):
    conditions = ready.observatory.return_conditions()
    site = streakcast.StreakModel(site="Rubin Observatory", shells="starlink-gen1").site
    assert abs(sun_altitude_deg(float(np.max(conditions.mjd)), "utc", site) - np.degrees(conditions.sun_alt)) < 0.02


def test_times_need_a_scale(folder):
    model = streakcast.StreakModel(site="Rubin Observatory", elements=folder / "4408.csv", telescope="rubin")
    with pytest.raises(ValueError, match="missing mjd_scale"):
        manager_of(model)
    assert manager_of(model, mjd_scale="tai").mjd_scale == "tai"
    with pytest.raises(ValueError, match="mjd_scale is 'ut1'; allowed: utc, tai, tt"):
        manager_of(model, mjd_scale="ut1")


def test_tai_and_utc_differ(models, pairs_evening):
    visits = pairs_evening.visits
    target = (np.degrees(visits["RA"]), np.degrees(visits["dec"]))
    crossed = [models[40768].assess(target, visits["mjd"], visits["exptime"], scale=scale).crosses for scale in ("utc", "tai")]
    assert np.count_nonzero(crossed[0] != crossed[1]) > 0.1 * len(visits)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"look_ahead": 0}, "look_ahead is 0; allowed: a whole number from 1 upwards"),
        ({"look_ahead": 2.5}, "look_ahead is 2.5; allowed: a whole number"),
        ({"look_ahead": "12"}, "look_ahead is '12'; allowed: a whole number"),
        ({"bright_share": -0.1}, "0 to 100"),
        ({"bright_share": float("nan")}, "bright_share is nan"),
        ({"limit_mag": {"q": 7.0}}, "limit_mag has the unknown band 'q'"),
        ({"limit_mag": "bright"}, "limit_mag is 'bright'"),
    ],
)
def test_invalid_options(model, options, message):
    with pytest.raises(ValueError, match=message):
        manager_of(model, **options)


def test_a_scheduler_that_restarts_at_an_earlier_time(ready, model, take_over):
    """After a restart at an earlier time, in the same or another night, later times and visits are discarded."""
    manager = manager_of(model)
    scheduler = take_over(ready, manager)
    scheduler.request_observation()
    mount = manager.mount
    now = mount.now(scheduler.conditions)
    mount.set_time(now + 3.0)
    assert mount.now(scheduler.conditions) == now
    mount.set_time(now + 0.01)
    assert mount.now(scheduler.conditions) == now + 0.01
    # Two hours later by the time of the scheduler, and then earlier again.
    mount.set_time(now + 0.08)
    assert mount.now(scheduler.conditions) == now + 0.08
    mount.set_time(now)
    assert mount.now(scheduler.conditions) == now and mount.last is not None
    # Two hours later by a visit, and then earlier again by the conditions.
    later, visit = copy.copy(scheduler.conditions), np.atleast_1d(ready.visits[-1:]).copy()
    visit["mjd"] = now + 0.08
    later._mjd = now + 0.08
    mount.done(visit)
    assert mount.now(later) > now + 0.08
    assert mount.now(scheduler.conditions) == now and mount.last is None


def test_an_invalid_time_does_not_stop_the_scheduler(ready, model, take_over, monkeypatch):
    manager = manager_of(model)
    scheduler = take_over(ready, manager)
    now = manager.mount.now(scheduler.conditions)
    expected = BaseQueueManager.find_valid_observations_indx(manager, scheduler.conditions, mjd=now)
    monkeypatch.setattr(manager.mount, "set_time", lambda mjd: 1 / 0)
    found = manager.find_valid_observations_indx(scheduler.conditions, mjd=now)
    assert np.array_equal(found, expected) and manager.counts["clock"] == 1


def test_an_unreadable_site_is_logged(ready, model, take_over, costly, caplog):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    costly([20.0, 0.0, *[20.0] * 10])
    site = scheduler.conditions.site

    class Hidden:
        """Site of rubin_scheduler, except that reading `latitude` raises an error."""

        def __getattr__(self, name):
            if name == "latitude":
                raise RuntimeError("no such site")
            return getattr(site, name)

    scheduler.conditions.site = Hidden()
    assert ids(scheduler.request_observation()) == [queue[1]]
    counts = scheduler.queue_manager.counts
    assert counts["site"] == 1 and counts["failed"] == 0 and "cannot be read" in caplog.text


def test_a_model_without_a_telescope(folder):
    model = streakcast.StreakModel(site="Rubin Observatory", elements=folder / "4408.csv", mjd_scale="utc")
    for one in (model, model.with_options(fov="3.5deg")):
        with pytest.raises(ValueError, match="no telescope"):
            manager_of(one)


def test_something_else_than_a_model_is_rejected():
    with pytest.raises(TypeError, match="model is of the type str; allowed: a StreakModel"):
        StreakCostBasisFunction("model")
