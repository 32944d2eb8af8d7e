"""Simulated nights checked by brute force: short versions of the runs in the README.

Tests marked `whole` simulate further nights, and run with `plugins/test.sh --all`.
"""

import warnings

import brute_force
import night
import numpy as np
import pytest
from conftest import EVENING, HOURS
from rubin_scheduler.scheduler.detailers import RotspUpdateDetailer
from streakcast_rubin import StreakCostBasisFunction, StreakQueueManager
from streakcast_rubin._candidates import OPEN_SHARE
from streakcast_rubin._exchanges import of_visits

#: Smallest reduction of the cost of streaks by the queue manager, for streaks that destroy a visit; largest loss of
#: visits and increase of slew time.
MIN_SAVED = 0.3
MAX_LOST, MAX_SLEW_INCREASE = 0.02, 0.06
#: Smallest reduction of the cost by the map in twilight, and largest loss of visits.
MIN_SAVED_GREEDY = 0.5
MAX_LOST_GREEDY = 0.08


def costs_s(model, visits):
    """Costs of visits, seconds, if a bright streak destroys the visit."""
    whole = model.with_options(bright_share=1.0)
    return whole.assess((np.degrees(visits["RA"]), np.degrees(visits["dec"])), visits["mjd"], visits["exptime"]).streak_cost_s


@pytest.mark.whole
def test_pairs_all_night_under_4408_satellites(folder, models, truths, pairs_night):
    manager = StreakQueueManager(models[4408], bright_share=1.0, detailers=[RotspUpdateDetailer()])
    dodged = night.run(EVENING, "pairs", folder, queue_manager=manager)
    before, after = (brute_force.streaked(truths[4408], one.visits).sum() for one in (pairs_night, dodged))
    print(f"streaked {before} -> {after}, visits {len(pairs_night.visits)} -> {len(dodged.visits)}, {manager.counts}")
    assert before >= 10
    assert costs_s(models[4408], dodged.visits).sum() <= (1.0 - MIN_SAVED) * costs_s(models[4408], pairs_night.visits).sum()
    assert len(dodged.visits) >= (1.0 - MAX_LOST) * len(pairs_night.visits)
    assert dodged.mean_slew_s <= (1.0 + MAX_SLEW_INCREASE) * pairs_night.mean_slew_s
    assert manager.counts["failed"] == 0
    assert manager.counts["asked"] >= len(dodged.visits)
    assert manager.counts["saved_s"] > OPEN_SHARE * manager.counts["detour_s"]


def test_pairs_in_the_evening_under_40768_satellites(models, pairs_evening, dodged_evening):
    """At the default share of 0.08, exchanges save more than they cost, and fewer visits have bright streaks."""
    before, after = (costs_s(models[40768], one.visits) for one in (pairs_evening, dodged_evening))
    counts = dodged_evening.scheduler.queue_manager.counts
    print(f"cost {before.sum():.0f} s of {before.size} visits -> {after.sum():.0f} s of {after.size}, {counts}")
    assert after.mean() <= (1.0 - MIN_SAVED) * before.mean()
    assert counts["exchanged"] >= 5 and counts["failed"] == 0
    assert counts["saved_s"] > OPEN_SHARE * counts["detour_s"]
    assert dodged_evening.mean_slew_s <= (1.0 + MAX_SLEW_INCREASE) * pairs_evening.mean_slew_s


def test_the_model_agrees_with_brute_force(models, truths, pairs_evening):
    visits = pairs_evening.visits
    found = models[40768].assess((np.degrees(visits["RA"]), np.degrees(visits["dec"])), visits["mjd"], visits["exptime"])
    truth = brute_force.streaked(truths[40768], visits)
    # Crossings at the edge differ: the brute force uses the shadow of a sphere and steps of a second.
    assert np.count_nonzero(found.crosses != truth) <= 0.01 * truth.size


def test_shutters_open_at_the_predicted_times(dodged_evening, planned):
    visits = dodged_evening.visits
    late_s = np.array([(one["mjd"] - planned[int(one["target_id"])]) * 86_400.0 for one in visits if int(one["target_id"]) in planned])
    assert late_s.size == len(visits)
    # Exceptions are the first visit, and filter exchanges, where rubin_scheduler resets the rotator.
    assert np.mean(np.abs(late_s) < 1.0) > 0.95


def test_exchanges_are_those_of_their_visits(dodged_evening, tmp_path):
    manager, visits = dodged_evening.scheduler.queue_manager, np.asarray(dodged_evening.visits)
    manager.write_exchanges(tmp_path / "exchanges.ecsv")
    expected = manager.exchanges
    assert len(expected["mjd"]) == manager.counts["exchanged"] > 5
    for table in (expected, tmp_path / "exchanges.ecsv"):
        found = of_visits(table, visits["mjd"], visits["band"])
        exchanged = found["exchanged_visits"] > 0
        assert sorted(visits["target_id"][exchanged].tolist()) == sorted(expected["target_id"].tolist())
        assert found["saved_s"].sum() == pytest.approx(manager.counts["saved_s"])
        assert found["detour_s"].sum() == pytest.approx(manager.counts["detour_s"])


def test_pairs_stay_pairs(pairs_evening, dodged_evening):
    for done in (pairs_evening, dodged_evening):
        assert np.unique(done.visits["target_id"]).size == len(done.visits)
    visits = dodged_evening.visits
    tags_by_field = {}
    for visit in visits:
        field = (round(float(visit["RA"]), 9), round(float(visit["dec"]), 9))
        tags_by_field.setdefault(field, []).append(str(visit["scheduler_note"])[-1])
    pairs = [tags for tags in tags_by_field.values() if len(tags) == 2]
    assert len(pairs) > 30
    assert all(tags == ["a", "b"] for tags in pairs)
    exchanges = [int(np.count_nonzero(done.visits["band"][1:] != done.visits["band"][:-1])) for done in (pairs_evening, dodged_evening)]
    assert exchanges[1] <= exchanges[0]


@pytest.fixture(scope="module")
def greedy_evening(folder):
    return night.run(EVENING, "greedy", folder, hours=0.7)


@pytest.mark.whole
def test_greedy_with_the_map(folder, models, truths, greedy_evening):
    """At twilight more than half of the sky is crossed."""
    plain, function = greedy_evening, StreakCostBasisFunction(models[40768], bright_share=0.3)
    dodged = night.run(EVENING, "greedy", folder, hours=0.7, rewards=[(function, night.SLEWTIME_WEIGHT)])
    before, after = (brute_force.streaked(truths[40768], one.visits).sum() for one in (plain, dodged))
    print(f"streaked {before} of {len(plain.visits)} -> {after} of {len(dodged.visits)}, {function.counts}")
    assert before >= 15 and after < 0.8 * before
    assert costs_s(models[40768], dodged.visits).sum() <= (1.0 - MIN_SAVED_GREEDY) * costs_s(models[40768], plain.visits).sum()
    assert len(dodged.visits) >= (1.0 - MAX_LOST_GREEDY) * len(plain.visits)
    assert function.counts["failed"] == 0
    # The map is computed once per visit.
    assert function.counts["made"] <= len(dodged.visits) + 2


@pytest.mark.whole
def test_a_wholly_blocked_sky_still_returns_visits(folder, models, pairs_evening):
    """A field of 140 degrees is never clear."""
    manager = StreakQueueManager(models[40768].with_options(fov="140deg"), detailers=[RotspUpdateDetailer()])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        done = night.run(EVENING, "pairs", folder, hours=0.5, queue_manager=manager)
    same = pairs_evening.visits["mjd"] <= done.visits["mjd"].max()
    assert len(done.visits) >= 0.85 * np.count_nonzero(same)
    assert manager.counts["compared"] >= len(done.visits)
    assert not [one for one in caught if "rejected everything" in str(one.message)]


def test_rewards_are_recorded(folder, models):
    """Labels and reward tables of rubin_scheduler include the basis function."""
    function = StreakCostBasisFunction(models[4408])
    done = night.run(EVENING, "greedy", folder, hours=0.1, rewards=[(function, night.SLEWTIME_WEIGHT)], record_rewards=True)
    frame = done.scheduler.make_reward_df(done.scheduler.conditions)
    assert "StreakCost" in {label.split(" @")[0] for label in frame["basis_function"]}
    assert function.counts["failed"] == 0 and function.counts["made"] >= 5


@pytest.mark.whole
def test_a_higher_share_avoids_more(folder, models, pairs_evening, dodged_evening):
    """If a bright streak destroys the visit, longer detours are made, and the streaks cost less."""
    manager = StreakQueueManager(models[40768], bright_share=1.0, detailers=[RotspUpdateDetailer()])
    done = night.run(EVENING, "pairs", folder, hours=HOURS, queue_manager=manager)
    mean_s = [costs_s(models[40768], one.visits).mean() for one in (pairs_evening, dodged_evening, done)]
    print(f"mean cost {mean_s} s, {manager.counts}")
    assert mean_s[2] < 0.6 * mean_s[1] < 0.6 * mean_s[0]
    assert manager.counts["saved_s"] > OPEN_SHARE * manager.counts["detour_s"]
