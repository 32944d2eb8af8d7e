"""Queue manager in rubin_scheduler: choice of visits, order of the queue, magnitude limits."""

import logging

import numpy as np
import streakcast
from conftest import ids, manager_of
from streakcast_rubin._candidates import candidates, choose
from streakcast_rubin._mount import Openings
from streakcast_rubin._verdicts import Rules, judge


def test_a_clear_visit_is_dispatched(ready, model, take_over, blocked):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    blocked(streakcast.StreakModel, [0, 1, *range(3, 12)])
    assert ids(scheduler.request_observation()) == [queue[2]]
    blocked(streakcast.StreakModel, [])
    assert ids(scheduler.request_observation()) == [queue[0]]


def test_without_clear_visits_the_least_loss_is_dispatched(ready, model, take_over, blocked):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    blocked(streakcast.StreakModel, "all", damage=[3.0, 2.0, 5.0, 1.0, 4.0, 6.0, 7.0, 8.0, 9.0, 9.0, 9.0, 9.0])
    assert ids(scheduler.request_observation()) == [queue[3]]
    assert scheduler.queue_manager.counts["given_up"] == 1
    # If no visit is much better, the first one is dispatched.
    blocked(streakcast.StreakModel, "all", damage=[3.0, *[2.0] * 11])
    assert ids(scheduler.request_observation()) == [queue[0]]


def test_deferrals_of_a_visit_are_limited(ready, model, take_over, blocked):
    scheduler = take_over(ready, manager_of(model, max_defer=3))
    first = ids(scheduler.return_active_queue())[0]
    blocked(streakcast.StreakModel, [0])
    out = [ids(scheduler.request_observation())[0] for _ in range(4)]
    assert out[:3].count(first) == 0 and out[3] == first
    assert scheduler.queue_manager.counts["due"] == 1


def test_the_whole_queue_is_returned(ready, model, take_over, blocked):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    blocked(streakcast.StreakModel, [0, *range(2, 12)])
    whole = ids(scheduler.request_observation(whole_queue=True))
    assert whole == [queue[1], queue[0], *queue[2:]]
    three = ids(scheduler.queue_manager.request_observation(scheduler.conditions, n_return=3))
    assert three == [queue[1], queue[0], queue[2]]


def test_other_bands_and_second_halves_wait():
    queue = np.zeros(6, dtype=[("band", "U1"), ("RA", float), ("dec", float)])
    queue["band"] = ["r", "r", "r", "r", "i", "i"]
    queue["RA"] = [1.0, 2.0, 1.0, 3.0, 1.0, 2.0]
    valid = np.arange(6)
    assert candidates(queue, valid, 12).tolist() == [0, 1, 3]
    assert candidates(queue, valid[2:], 12).tolist() == [2, 3]
    assert candidates(queue, valid, 1).tolist() == [0]
    assert candidates(queue, valid[:0], 12).size == 0


def test_long_slews_are_not_made():
    crossed, slew_s = np.array([True, False, False]), np.array([5.0, 40.0, 8.0])
    arguments = {"damage": np.array([2.0, 0.0, 0.0]), "deferred": np.zeros(3, dtype=int), "max_defer": 9}
    assert choose(crossed, slew_s=slew_s, max_extra_slew_s=10.0, **arguments) == (2, "clear")
    assert choose(crossed, slew_s=slew_s, max_extra_slew_s=60.0, **arguments) == (2, "clear")
    assert choose(crossed, slew_s=slew_s, max_extra_slew_s=1.0, **arguments) == (0, "least")
    assert choose(crossed, slew_s=np.array([5.0, np.nan, 8.0]), max_extra_slew_s=60.0, **arguments) == (2, "clear")


def test_the_nearest_clear_visit_is_chosen():
    arguments = {"damage": np.zeros(3), "deferred": np.zeros(3, dtype=int), "max_defer": 9, "max_extra_slew_s": 20.0}
    crossed = np.array([True, False, False])
    assert choose(crossed, slew_s=np.array([5.0, 9.0, 6.0]), **arguments) == (2, "clear")
    # Among equally near visits, the order of the queue is used.
    assert choose(crossed, slew_s=np.array([5.0, 6.1, 6.0]), **arguments) == (1, "clear")
    assert choose(~crossed, slew_s=np.array([5.0, 1.0, 1.0]), **arguments) == (0, "clear")


def test_each_deferral_is_logged(ready, model, take_over, blocked, caplog):
    scheduler = take_over(ready, manager_of(model))
    blocked(streakcast.StreakModel, [0])
    with caplog.at_level(logging.INFO, logger="streakcast.rubin"):
        scheduler.request_observation()
        scheduler.request_observation()
    assert len(caplog.records) == scheduler.queue_manager.counts["deferred"] == 2
    assert "deferred for visit" in caplog.text and "mag 7.0" in caplog.text


def test_limits_of_the_models_policy(models, pairs_evening, ready):
    """A limit of the model, and the same limit as an option, block the same visits."""
    visits = np.asarray(pairs_evening.visits)
    openings = Openings(visits["mjd"], np.zeros(visits.size), visits["exptime"])
    model = models[40768]
    by_policy, by_option, alone = (
        judge(one, visits, openings, Rules("utc", 3.0, "light", blocking, limit))
        for one, blocking, limit in ((model.with_options(limit_mag=7.0), "avoid", None), (model, "avoid", 7.0), (model, "any", None))
    )
    assert 5 < by_policy.blocked.sum() < alone.blocked.sum()
    assert np.array_equal(by_policy.blocked, by_option.blocked)
    assert np.array_equal(by_policy.n_streaks, by_option.n_streaks)
    assert np.allclose(by_policy.brightest_mag, by_option.brightest_mag, equal_nan=True)
    # Only the policy includes near misses.
    crossed = alone.blocked
    assert np.median(np.abs(by_policy.damage[crossed] / by_option.damage[crossed] - 1.0)) < 0.05


def test_in_a_band_without_a_limit_every_lit_satellite_counts(models, pairs_evening):
    """The result is that without any limit."""
    visits = np.asarray(pairs_evening.visits)
    openings = Openings(visits["mjd"], np.zeros(visits.size), visits["exptime"])
    alone, other_band, mixed = (
        judge(models[40768], visits, openings, Rules("utc", 3.0, "light", blocking, limit)).blocked
        for blocking, limit in (("any", None), ("avoid", {"u": -20.0}), ("avoid", {visits["band"][0]: -20.0}))
    )
    assert np.array_equal(other_band, alone)
    limited = visits["band"] == visits["band"][0]
    assert alone[limited].any() and not mixed[limited].any() and np.array_equal(mixed[~limited], alone[~limited])


def test_limits_by_band(ready, models, take_over):
    """No satellite is brighter than -20 mag."""
    scheduler = take_over(ready, manager_of(models[40768].with_options(fov="140deg"), limit_mag={"default": -20.0}))
    first = ids(scheduler.return_active_queue())[0]
    assert ids(scheduler.request_observation()) == [first]
    counts = scheduler.queue_manager.counts
    assert counts["deferred"] == counts["given_up"] == counts["failed"] == 0 and scheduler.queue_manager.blocking == "avoid"
