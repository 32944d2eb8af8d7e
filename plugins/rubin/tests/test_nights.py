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
from streakcast_rubin import StreakMaskBasisFunction, StreakQueueManager, StreakRewardBasisFunction

#: Smallest reduction of streaked visits with 4,408 and 40,768 satellites; largest loss of visits and increase of slew
#: time.
MIN_REDUCTION = {4408: 0.80, 40768: 0.60}
MAX_LOST, MAX_SLEW_INCREASE = 0.03, 0.15


@pytest.mark.whole
def test_pairs_all_night_under_4408_satellites(folder, models, truths, pairs_night):
    manager = StreakQueueManager(models[4408], detailers=[RotspUpdateDetailer()])
    dodged = night.run(EVENING, "pairs", folder, queue_manager=manager)
    before = brute_force.streaked(truths[4408], pairs_night.visits).sum()
    after = brute_force.streaked(truths[4408], dodged.visits).sum()
    print(f"streaked {before} -> {after}, visits {len(pairs_night.visits)} -> {len(dodged.visits)}, {manager.counts}")
    assert before >= 10
    assert after <= (1.0 - MIN_REDUCTION[4408]) * before
    assert len(dodged.visits) >= (1.0 - MAX_LOST) * len(pairs_night.visits)
    assert dodged.mean_slew_s <= (1.0 + MAX_SLEW_INCREASE) * pairs_night.mean_slew_s
    assert manager.counts["failed"] == 0
    assert manager.counts["asked"] >= len(dodged.visits)


def test_pairs_in_the_evening_under_40768_satellites(truths, pairs_evening, dodged_evening):
    before = brute_force.streaked(truths[40768], pairs_evening.visits)
    after = brute_force.streaked(truths[40768], dodged_evening.visits)
    print(f"streaked {before.sum()} of {before.size} -> {after.sum()} of {after.size}")
    assert before.mean() > 0.2
    assert after.sum() <= (1.0 - MIN_REDUCTION[40768]) * before.sum()


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
def test_greedy_with_the_mask(folder, models, truths, greedy_evening):
    """At twilight more than half of the sky is crossed; default options are used."""
    plain = greedy_evening
    mask = StreakMaskBasisFunction(models[40768])
    dodged = night.run(EVENING, "greedy", folder, hours=0.7, masks=[mask])
    before = brute_force.streaked(truths[40768], plain.visits).sum()
    after = brute_force.streaked(truths[40768], dodged.visits).sum()
    print(f"streaked {before} of {len(plain.visits)} -> {after} of {len(dodged.visits)}, {mask.counts}")
    assert before >= 15
    assert after <= (1.0 - MIN_REDUCTION[40768]) * before
    assert mask.counts["failed"] == 0
    # The mask is computed once per visit.
    assert mask.counts["asked"] <= len(dodged.visits) + 2


@pytest.mark.whole
def test_a_wholly_blocked_sky_still_returns_visits(folder, models, pairs_evening):
    """A field of 140 degrees is never clear."""
    manager = StreakQueueManager(models[40768].with_options(fov="140deg"), detailers=[RotspUpdateDetailer()])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        done = night.run(EVENING, "pairs", folder, hours=0.5, queue_manager=manager)
    same = pairs_evening.visits["mjd"] <= done.visits["mjd"].max()
    assert len(done.visits) >= 0.85 * np.count_nonzero(same)
    assert manager.counts["given_up"] == len(done.visits)
    assert not [one for one in caught if "rejected everything" in str(one.message)]


@pytest.mark.whole
def test_a_wholly_blocked_sky_still_returns_greedy_visits(folder, models, greedy_evening):
    mask = StreakMaskBasisFunction(models[40768].with_options(fov="60deg"))
    done = night.run(EVENING, "greedy", folder, hours=0.5, masks=[mask])
    same = greedy_evening.visits["mjd"] <= done.visits["mjd"].max()
    print(f"visits {np.count_nonzero(same)} -> {len(done.visits)}, {mask.counts}")
    assert len(done.visits) >= 0.85 * np.count_nonzero(same)
    assert mask.counts["capped"] == mask.counts["asked"] and mask.counts["failed"] == 0


def test_rewards_are_recorded(folder, models):
    """Labels and reward tables of rubin_scheduler include the basis functions."""
    mask, reward = StreakMaskBasisFunction(models[4408]), StreakRewardBasisFunction(models[4408])
    done = night.run(EVENING, "greedy", folder, hours=0.1, masks=[mask], rewards=[(reward, 1.0)], record_rewards=True)
    frame = done.scheduler.make_reward_df(done.scheduler.conditions)
    assert {"StreakMask", "StreakReward"} <= {label.split(" @")[0] for label in frame["basis_function"]}
    assert reward.counts["failed"] == mask.counts["failed"] == 0
    assert reward.counts["made"] < reward.counts["asked"]


@pytest.mark.whole
@pytest.mark.parametrize("hours", [HOURS])
def test_a_limit_costs_less(folder, models, pairs_evening, dodged_evening, hours):
    """If only satellites brighter than 7 mag are avoided, fewer visits are lost, and there are fewer bright streaks."""
    manager = StreakQueueManager(models[40768], limit_mag=7.0, detailers=[RotspUpdateDetailer()])
    limited = night.run(EVENING, "pairs", folder, hours=hours, queue_manager=manager)
    limited_model = models[40768].with_options(limit_mag=7.0)

    def bright(visits):
        return int(limited_model.assess((np.degrees(visits["RA"]), np.degrees(visits["dec"])), visits["mjd"], visits["exptime"]).avoid.sum())

    print(f"visits {len(pairs_evening.visits)}, {len(limited.visits)} with a limit, {len(dodged_evening.visits)} without")
    assert bright(limited.visits) <= 0.4 * bright(pairs_evening.visits)
    assert limited.mean_slew_s < dodged_evening.mean_slew_s
    assert len(limited.visits) >= len(dodged_evening.visits)
