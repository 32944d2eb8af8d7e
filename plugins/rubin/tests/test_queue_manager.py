"""Queue manager in rubin_scheduler: choice of visits, order of the queue, costs."""

import logging

import numpy as np
import pytest
from conftest import ids, manager_of
from streakcast_rubin._candidates import OPEN_SHARE, candidates, choose, detours_s
from streakcast_rubin._costs import costs_of, with_costs
from streakcast_rubin._dispatched import Owner
from streakcast_rubin._mount import Mount, Openings


#: Cost of a crossed visit, seconds, which is worth all detours of these tests.
COST_S = 20.0


def test_the_visit_with_the_least_cost_is_dispatched(ready, model, take_over, costly):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    costly([COST_S, COST_S, 0.0, *[COST_S] * 9])
    assert ids(scheduler.request_observation()) == [queue[2]]
    counts = scheduler.queue_manager.counts
    assert (counts["exchanged"], counts["compared"]) == (1, 12)
    assert counts["saved_s"] == pytest.approx(COST_S) and counts["saved_s"] > OPEN_SHARE * counts["detour_s"]
    table = scheduler.queue_manager.exchanges
    assert (table["target_id"].tolist(), table["first_target_id"].tolist()) == ([queue[2]], [queue[0]])
    assert table["saved_s"].tolist() == [pytest.approx(counts["saved_s"])] and table["detour_s"].tolist() == [counts["detour_s"]]
    costly(0.0)
    assert ids(scheduler.request_observation()) == [queue[0]]
    # A cost of 0.05 s is not compared.
    costly([0.05, *[0.0] * 11])
    assert ids(scheduler.request_observation()) == [queue[0]]
    assert (counts["asked"], counts["compared"]) == (3, 12)


def test_an_exchange_counts_if_its_visit_is_dispatched(ready, model, take_over, costly):
    """A detailer drops the chosen visit: the default visit is dispatched."""
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    manager = scheduler.queue_manager
    manager.detailers = [lambda visits, conditions: visits[visits["target_id"] != queue[2]]]
    costly([COST_S, COST_S, 0.0, *[COST_S] * 9])
    assert ids(scheduler.request_observation()) == [queue[0]]
    whole = ids(manager.request_observation(scheduler.conditions, whole_queue=True))
    assert queue[2] not in whole and len(whole) == len(queue) - 1
    assert manager.counts["exchanged"] == 0 and not manager.exchanges["mjd"].size
    # It remains available to copies of the manager.
    assert not manager._dispatched.with_others(Owner(), manager.mount.now(scheduler.conditions))


def test_if_all_visits_are_crossed_the_least_cost_is_dispatched(ready, model, take_over, costly):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    costly([25.0, 22.0, 26.0, 1.0, 24.0, 26.0, 27.0, 28.0, 29.0, 29.0, 29.0, 29.0])
    assert ids(scheduler.request_observation()) == [queue[3]]
    costly(25.0)
    assert ids(scheduler.request_observation()) == [queue[0]]


def test_the_detour_of_the_last_candidate_includes_the_path_after_it(ready, model, take_over, costly):
    """A detour does not depend on the number of candidates. The visit after the last candidate is never dispatched."""
    last, detours = 3, []
    for look_ahead in (last + 1, 12):
        manager = manager_of(model, look_ahead=look_ahead)
        scheduler = take_over(ready, manager)
        queue = ids(scheduler.return_active_queue())
        costly([500.0] * last + [0.0] + [500.0] * (11 - last))
        assert ids(scheduler.request_observation()) == [queue[last]]
        assert manager.counts["compared"] == look_ahead
        detours.append(manager.counts["detour_s"])
        if look_ahead < 12:
            costly([500.0] * look_ahead + [0.0])
            assert ids(scheduler.request_observation()) == [queue[0]]
    assert detours[0] == pytest.approx(detours[1], abs=1e-9) and detours[0] > 0.5


def test_an_unknown_cost_keeps_the_order_of_the_queue(ready, model, take_over, costly):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    costly([np.nan, 0.0, *[COST_S] * 10])
    assert ids(scheduler.request_observation()) == [queue[0]]
    counts = scheduler.queue_manager.counts
    assert (counts["not_judged"], counts["exchanged"], counts["failed"]) == (1, 0, 0)
    # A later visit of unknown cost is never preferred.
    costly([COST_S, np.nan, 0.0, *[COST_S] * 9])
    assert ids(scheduler.request_observation()) == [queue[2]]


def test_an_exchange_is_worth_its_detour(ready, model, take_over, costly):
    """The detour is that of the whole path by the kinematic model: a smaller saving makes no exchange."""
    manager = manager_of(model, look_ahead=2)
    scheduler = take_over(ready, manager)
    queue = ids(scheduler.return_active_queue())
    costly([COST_S, 0.0])
    assert ids(scheduler.request_observation()) == [queue[1]]
    detour_s = manager.counts["detour_s"]
    assert 0.5 < detour_s < 20.0
    for factor, expected in ((0.9, queue[0]), (1.1, queue[1])):
        costly([0.01 + factor * OPEN_SHARE * detour_s, 0.01])
        assert ids(scheduler.request_observation()) == [expected]


def test_the_whole_queue_is_returned(ready, model, take_over, costly):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    costly([COST_S, 0.0, *[COST_S] * 10])
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


def test_detours_are_those_of_the_path():
    """The sum over the path in the other order, less that in the order of the queue."""
    random = np.random.default_rng(45)
    slew_s, between_s = random.uniform(3.0, 9.0, 6), random.uniform(3.0, 9.0, (6, 6))

    def path_s(order):
        return slew_s[order[0]] + sum(between_s[one, next_one] for one, next_one in zip(order, order[1:]))

    expected = [path_s([k, *[one for one in range(6) if one != k]]) - path_s([*range(6)]) for k in range(6)]
    assert np.allclose(detours_s(slew_s, between_s), expected, atol=1e-12)
    assert detours_s(slew_s[:1], between_s[:1, :1]).tolist() == [0.0]


def test_slews_between_visits_are_single_slews(ready):
    mount, visits = Mount(), np.asarray(ready.scheduler.queue_manager.desired_observations_array)[:5]
    now = float(np.max(ready.scheduler.conditions.mjd))
    between_s, model = mount.between(now, visits), mount.kinematics
    altitude, azimuth, _ = model.radec2altaz(visits["RA"], visits["dec"], now)
    for start in range(5):
        for end in range(5):
            one = {"alt_rad": altitude[[end]], "az_rad": azimuth[[end]]}
            single_s = model.slew_times(None, None, now, starting_alt_rad=altitude[start], starting_az_rad=azimuth[start], **one)
            assert between_s[start, end] == max(single_s[0], model.readtime)
    assert between_s.max() > 1.2 * model.readtime


def test_cost_plus_detour_is_least():
    cost_s = np.array([2.4, 0.0, 0.5])
    assert choose(cost_s, np.array([0.0, 4.0, 2.0])) == 2
    assert choose(cost_s, np.array([0.0, 4.0, 3.0])) == 0
    assert choose(cost_s, np.array([0.0, -1.0, -9.0])) == 1
    assert choose(cost_s, np.array([0.0, np.nan, 2.0])) == 2
    assert choose(np.array([np.nan, np.nan]), np.zeros(2)) == 0


def test_each_exchange_is_logged(ready, model, take_over, costly, caplog):
    scheduler = take_over(ready, manager_of(model))
    costly([COST_S, *[0.0] * 11])
    with caplog.at_level(logging.INFO, logger="streakcast.rubin"):
        scheduler.request_observation()
        scheduler.request_observation()
    assert len(caplog.records) == scheduler.queue_manager.counts["exchanged"] == 2
    assert "streaks cost 0.00 s instead of 20.00 s, detour" in caplog.text and "mag 7.0" in caplog.text


def test_costs_are_those_of_the_model(models, pairs_evening):
    """`bright_share` and the limit of the queue manager are options of the model."""
    visits = np.asarray(pairs_evening.visits)
    openings = Openings(visits["mjd"], np.zeros(visits.size), visits["exptime"])
    default, one, limited = (
        costs_of(with_costs(models[40768], share, limit), visits, openings, "utc").cost_s
        for share, limit in ((None, None), (1.0, None), (None, {"default": 30.0}))
    )
    assert default.mean() > 0.1 and (one >= default).all() and one.mean() > 5.0 * default.mean()
    assert (limited >= default).all() and np.isclose(limited.max(), 30.0, rtol=0.1)
    # Brighter satellites than -20 mag do not exist.
    assert np.allclose(costs_of(with_costs(models[40768], None, -20.0), visits, openings, "utc").cost_s, default, atol=1e-3)
