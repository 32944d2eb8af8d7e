"""The queue manager on a real scheduler with a real queue: what it may and may not do, and what it does when something is wrong."""

import copy
import logging
import pickle
import time

import brute_force
import numpy as np
import pytest
import streakcast
from astropy.time import Time
from rubin_scheduler.scheduler.detailers import RotspUpdateDetailer
from rubin_scheduler.scheduler.schedulers import BaseQueueManager, SummitWrapper
from streakcast_rubin import StreakQueueManager
from streakcast_rubin._candidates import candidates, choose
from streakcast_rubin._mount import Openings
from streakcast_rubin._questions import Rules, judge

#: What a pickle of the scheduler may grow by.
MOST_PICKLED = 100_000


def manager_of(model, **options):
    return StreakQueueManager(model, detailers=[RotspUpdateDetailer()], **options)


def ids(visits):
    return np.ravel(visits["target_id"]).tolist()


@pytest.fixture
def blocked(monkeypatch):
    """Names the visits (by their places among the candidates) that are crossed, whatever the sky is like."""

    def block(model_class, places, damage=None):
        def passes(self, target, *_, **__):
            n = np.size(target[0])
            crossed = np.arange(n) if places == "all" else np.array([one for one in places if one < n], dtype=int)
            lost = np.ones(n) if damage is None else np.resize(damage, n)
            ones = np.ones(crossed.size)
            return {
                "exposure_id": crossed, "magnitude_peak": 7.0 * ones, "lost_pixel_fraction": lost[crossed],
                "streak_length_deg": ones, "probability": ones,
            }  # fmt: skip

        monkeypatch.setattr(model_class, "passes", passes)

    return block


def test_a_clear_visit_goes_out(ready, model, take_over, blocked):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    blocked(streakcast.StreakModel, [0, 1, *range(3, 12)])
    assert ids(scheduler.request_observation()) == [queue[2]]
    blocked(streakcast.StreakModel, [])
    assert ids(scheduler.request_observation()) == [queue[0]]


def test_else_the_least_bad(ready, model, take_over, blocked):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    blocked(streakcast.StreakModel, "all", damage=[3.0, 2.0, 5.0, 1.0, 4.0, 6.0, 7.0, 8.0, 9.0, 9.0, 9.0, 9.0])
    assert ids(scheduler.request_observation()) == [queue[3]]
    assert scheduler.queue_manager.counts["given_up"] == 1
    # Where it is no better anywhere, the telescope does not wander.
    blocked(streakcast.StreakModel, "all", damage=[3.0, *[2.0] * 11])
    assert ids(scheduler.request_observation()) == [queue[0]]


def test_a_visit_is_put_off_so_often_and_no_more(ready, model, take_over, blocked):
    scheduler = take_over(ready, manager_of(model, max_defer=3))
    first = ids(scheduler.return_active_queue())[0]
    blocked(streakcast.StreakModel, [0])
    out = [ids(scheduler.request_observation())[0] for _ in range(4)]
    assert out[:3].count(first) == 0 and out[3] == first
    assert scheduler.queue_manager.counts["due"] == 1


def test_the_whole_queue_comes_whole(ready, model, take_over, blocked):
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


def test_a_long_way_is_not_gone():
    crossed, slew_s = np.array([True, False, False]), np.array([5.0, 40.0, 8.0])
    arguments = {"damage": np.array([2.0, 0.0, 0.0]), "deferred": np.zeros(3, dtype=int), "max_defer": 9}
    assert choose(crossed, slew_s=slew_s, max_extra_slew_s=10.0, **arguments) == (2, "clear")
    assert choose(crossed, slew_s=slew_s, max_extra_slew_s=60.0, **arguments) == (2, "clear")
    assert choose(crossed, slew_s=slew_s, max_extra_slew_s=1.0, **arguments) == (0, "least")
    assert choose(crossed, slew_s=np.array([5.0, np.nan, 8.0]), max_extra_slew_s=60.0, **arguments) == (2, "clear")


def test_of_clear_visits_the_nearest():
    arguments = {"damage": np.zeros(3), "deferred": np.zeros(3, dtype=int), "max_defer": 9, "max_extra_slew_s": 20.0}
    crossed = np.array([True, False, False])
    assert choose(crossed, slew_s=np.array([5.0, 9.0, 6.0]), **arguments) == (2, "clear")
    # As near: the order of the queue.
    assert choose(crossed, slew_s=np.array([5.0, 6.1, 6.0]), **arguments) == (1, "clear")
    assert choose(~crossed, slew_s=np.array([5.0, 1.0, 1.0]), **arguments) == (0, "clear")


def test_deferrals_are_logged_a_line_each(ready, model, take_over, blocked, caplog):
    scheduler = take_over(ready, manager_of(model))
    blocked(streakcast.StreakModel, [0])
    with caplog.at_level(logging.INFO, logger="streakcast.rubin"):
        scheduler.request_observation()
        scheduler.request_observation()
    assert len(caplog.records) == scheduler.queue_manager.counts["deferred"] == 2
    assert "put off for visit" in caplog.text and "mag 7.0" in caplog.text


# Faults ---------------------------------------------------------------------------------------------------------------


def test_any_failure_leaves_the_host_alone(ready, model, take_over, monkeypatch, caplog):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())

    def fails(*_, **__):
        raise RuntimeError("the index is gone")

    monkeypatch.setattr(streakcast.StreakModel, "passes", fails)
    with caplog.at_level(logging.WARNING):
        for _ in range(5):
            assert ids(scheduler.request_observation()) == [queue[0]]
    assert scheduler.queue_manager.counts["failed"] == 5
    assert len([one for one in caplog.records if "the index is gone" in one.message]) == 1


def test_a_visit_without_coordinates(ready, model, take_over):
    scheduler = take_over(ready, manager_of(model))
    queue = scheduler.queue_manager.desired_observations_array
    places = np.flatnonzero(scheduler.queue_manager.need_observing)
    queue["RA"][places[2]] = np.nan
    assert ids(scheduler.request_observation()) == [int(queue["target_id"][places[0]])]
    assert scheduler.queue_manager.counts["no_coordinates"] == 1 and scheduler.queue_manager.counts["failed"] == 0
    # Where it is the first, the host decides.
    queue["RA"][places[0]] = np.nan
    manager = scheduler.queue_manager
    assert manager.find_valid_observations_indx(scheduler.conditions)[0] == places[0]


def test_elements_that_vanish(ready, folder, take_over, caplog):
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


def test_old_elements_are_told(ready, tmp_path, take_over, caplog):
    """Ten weeks old: nobody knows where these are, and the night goes on."""
    brute_force.write_walker(["starlink-gen1"], Time("2025-11-05T00:00:00"), tmp_path / "old.csv")
    model = streakcast.StreakModel(site="Rubin Observatory", elements=tmp_path / "old.csv", telescope="rubin", mjd_scale="utc")
    scheduler = take_over(ready, manager_of(model, look_ahead=2))
    with caplog.at_level(logging.WARNING):
        for _ in range(2):
            assert np.size(scheduler.request_observation()) == 1
    assert scheduler.queue_manager.counts["warned"] == 1 and scheduler.queue_manager.counts["failed"] == 0
    assert len([one for one in caplog.records if "more than 14 days" in one.message]) == 1


def test_another_site_is_told(ready, folder, take_over, caplog):
    model = streakcast.StreakModel(lat=-30.0, lon=-70.0, height=2000.0, elements=folder / "4408.csv", telescope="rubin", mjd_scale="utc")
    scheduler = take_over(ready, manager_of(model))
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            assert np.size(scheduler.request_observation()) == 1
    assert scheduler.queue_manager.counts["site"] == 3
    assert len([one for one in caplog.records if "km apart" in one.message]) == 1


def test_rubins_own_site_is_no_other(ready, model, take_over, caplog):
    scheduler = take_over(ready, manager_of(model))
    scheduler.request_observation()
    assert scheduler.queue_manager.counts["site"] == scheduler.queue_manager.counts["clock"] == 0


def test_a_clock_37_seconds_off_is_told(ready, model, take_over, caplog):
    """TAI handed over as UTC, now."""
    scheduler = take_over(ready, manager_of(model))
    manager = scheduler.queue_manager
    manager.mount.last = None
    now = Time.now()
    scheduler.conditions._mjd = now.tai.mjd
    with caplog.at_level(logging.WARNING):
        manager.find_valid_observations_indx(scheduler.conditions)
        manager.hook.ask(lambda one: manager._choice(one, scheduler.conditions, np.flatnonzero(manager.need_observing)), None)
    assert manager.counts["clock"] == 1
    # Without a last visit the telescope stands where the conditions say.
    assert manager.counts["failed"] == 0
    assert "37.0 s" in caplog.text


def test_times_need_a_scale(folder):
    model = streakcast.StreakModel(site="Rubin Observatory", elements=folder / "4408.csv", telescope="rubin")
    with pytest.raises(ValueError, match="mjd_scale is not said"):
        manager_of(model)
    assert manager_of(model, mjd_scale="tai").mjd_scale == "tai"
    with pytest.raises(ValueError, match="mjd_scale 'ut1'; allowed: utc, tai, tt"):
        manager_of(model, mjd_scale="ut1")


def test_tai_and_utc_differ(models, pairs_evening):
    visits = pairs_evening.visits
    where = (np.degrees(visits["RA"]), np.degrees(visits["dec"]))
    answers = [models[40768].assess(where, visits["mjd"], visits["exptime"], scale=scale).crosses for scale in ("utc", "tai")]
    assert np.count_nonzero(answers[0] != answers[1]) > 0.1 * len(visits)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"look_ahead": 0}, "look_ahead is 0; allowed: a number from 1 up"),
        ({"max_defer": -1}, "max_defer is -1"),
        ({"jitter_s": float("nan")}, "jitter_s is nan"),
        ({"max_extra_slew_s": "5"}, "max_extra_slew_s is '5'"),
        ({"damage": "stars"}, "damage 'stars'; allowed: pixels, light"),
        ({"blocking": "some"}, "blocking 'some'; allowed: any, avoid"),
        ({"limit_mag": {"q": 7.0}}, "limit_mag names the band 'q'"),
        ({"limit_mag": "bright"}, "limit_mag is 'bright'"),
        ({"limit_mag": 7.0, "blocking": "any"}, "limit_mag with blocking='any' does nothing"),
    ],
)
def test_impossible_options(model, options, message):
    with pytest.raises(ValueError, match=message):
        manager_of(model, **options)


def test_limits_of_the_models_policy(models, pairs_evening, ready):
    """The model's own limits, and the same limit as an option, forbid the same visits."""
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
    # The one takes near misses along.
    crossed = alone.blocked
    assert np.median(np.abs(by_policy.damage[crossed] / by_option.damage[crossed] - 1.0)) < 0.05


def test_a_band_without_a_limit_is_one_without_limits(models, pairs_evening):
    """As where no limit is given at all: every lit satellite counts."""
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
    """Nothing is brighter than -20 mag."""
    scheduler = take_over(ready, manager_of(models[40768].with_options(fov="140deg"), limit_mag={"default": -20.0}))
    first = ids(scheduler.return_active_queue())[0]
    assert ids(scheduler.request_observation()) == [first]
    counts = scheduler.queue_manager.counts
    assert counts["deferred"] == counts["given_up"] == counts["failed"] == 0 and scheduler.queue_manager.blocking == "avoid"


def test_a_night_that_begins_again(ready, model, take_over):
    """A host that goes back in time is not answered for what it did later, in the night before or in the same one."""
    manager = manager_of(model)
    scheduler = take_over(ready, manager)
    scheduler.request_observation()
    mount = manager.mount
    now = mount.now(scheduler.conditions)
    mount.tell(now + 3.0)
    assert mount.now(scheduler.conditions) == now
    mount.tell(now + 0.01)
    assert mount.now(scheduler.conditions) == now + 0.01
    # Two hours on by the host's word, then back by its word.
    mount.tell(now + 0.08)
    assert mount.now(scheduler.conditions) == now + 0.08
    mount.tell(now)
    assert mount.now(scheduler.conditions) == now and mount.last is not None
    # Two hours on by a visit, then back by the conditions.
    later, visit = copy.copy(scheduler.conditions), np.atleast_1d(ready.visits[-1:]).copy()
    visit["mjd"] = now + 0.08
    later._mjd = now + 0.08
    mount.done(visit)
    assert mount.now(later) > now + 0.08
    assert mount.now(scheduler.conditions) == now and mount.last is None


def test_a_time_that_cannot_be_followed_stops_nothing(ready, model, take_over, monkeypatch):
    manager = manager_of(model)
    scheduler = take_over(ready, manager)
    now = manager.mount.now(scheduler.conditions)
    expected = BaseQueueManager.find_valid_observations_indx(manager, scheduler.conditions, mjd=now)
    monkeypatch.setattr(manager.mount, "tell", lambda mjd: 1 / 0)
    found = manager.find_valid_observations_indx(scheduler.conditions, mjd=now)
    assert np.array_equal(found, expected) and manager.counts["clock"] == 1


def test_a_site_that_cannot_be_looked_at_is_told(ready, model, take_over, blocked, caplog):
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    blocked(streakcast.StreakModel, [0, *range(2, 12)])
    site = scheduler.conditions.site

    class Hidden:
        """The host's own site, but for its latitude in degrees."""

        def __getattr__(self, name):
            if name == "latitude":
                raise RuntimeError("no such site")
            return getattr(site, name)

    scheduler.conditions.site = Hidden()
    assert ids(scheduler.request_observation()) == [queue[1]]
    counts = scheduler.queue_manager.counts
    assert counts["site"] == 1 and counts["failed"] == 0 and "cannot be looked at" in caplog.text


def test_a_model_without_a_field(folder):
    model = streakcast.StreakModel(site="Rubin Observatory", elements=folder / "4408.csv", mjd_scale="utc")
    with pytest.raises(ValueError, match="no field of view"):
        manager_of(model)


# Copies ---------------------------------------------------------------------------------------------------------------


def test_summit_wrapper(ready, models, take_over):
    """It copies the scheduler deep, asks for several visits at one moment, and hands back what it only asked for."""
    scheduler = take_over(ready, manager_of(models[40768]))
    wrapper = SummitWrapper(scheduler)
    wrapper.update_conditions(scheduler.conditions)
    out = [ids(wrapper.request_observation())[0] for _ in range(4)]
    assert len(set(out)) == 4
    ahead = wrapper.ahead_scheduler.queue_manager
    assert ahead is not scheduler.queue_manager and ahead.counts["failed"] == 0 and ahead.counts["asked"] == 4
    # Each visit that was asked for is taken to be under way: the next opens after it.
    taken_s = (ahead.mount.last["free_mjd"] - scheduler.queue_manager.mount.last["free_mjd"]) * 86_400.0
    assert 4 * 31.0 < taken_s < 4 * 31.0 + 4 * 40.0


def test_summit_wrapper_gets_no_visit_twice(ready, model, take_over, blocked):
    """The first visit of the queue goes out second, and is under way when the one before it is done."""
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    wrapper = SummitWrapper(scheduler)
    wrapper.update_conditions(scheduler.conditions)
    blocked(streakcast.StreakModel, [0])
    one = wrapper.request_observation()
    blocked(streakcast.StreakModel, [])
    two = wrapper.request_observation()
    assert ids(two) == [queue[0]] and ids(one)[0] > queue[0]
    done = wrapper.requested_but_unadded_obs[0].copy()
    done["visittime"] = 31.0
    wrapper.add_observation(done)
    three = wrapper.request_observation()
    assert ids(three)[0] not in (*ids(one), *ids(two))
    assert wrapper.ahead_scheduler.queue_manager.counts["failed"] == 0
    # A visit that never came back is not lost for good.
    manager = copy.deepcopy(scheduler.queue_manager)
    manager.mount.tell(manager.mount.now(scheduler.conditions) + 11.0 / 1440.0)
    assert ids(manager.request_observation(scheduler.conditions)) == [queue[0]]


def test_visits_are_put_off_so_often_by_all_copies_together(ready, model, take_over, blocked):
    """The wrapper asks a new copy after each visit that is done."""
    scheduler = take_over(ready, manager_of(model, max_defer=3))
    first = ids(scheduler.return_active_queue())[0]
    wrapper = SummitWrapper(scheduler)
    wrapper.update_conditions(scheduler.conditions)
    blocked(streakcast.StreakModel, [0])
    out, copies = [], set()
    for _ in range(4):
        out.append(ids(wrapper.request_observation())[0])
        copies.add(id(wrapper.ahead_scheduler.queue_manager))
        done = wrapper.requested_but_unadded_obs[0].copy()
        done["visittime"] = 31.0
        wrapper.add_observation(done)
    assert len(copies) > 1
    assert out[:3].count(first) == 0 and out[3] == first
    assert wrapper.ahead_scheduler.queue_manager.counts["due"] == 1


def test_what_was_put_off_stays_so_in_a_pickle(ready, model, take_over, blocked):
    manager = manager_of(model, max_defer=2)
    scheduler = take_over(ready, manager)
    first = ids(scheduler.return_active_queue())[0]
    blocked(streakcast.StreakModel, [0])
    for _ in range(2):
        assert ids(manager.request_observation(scheduler.conditions)) != [first]
    again = pickle.loads(pickle.dumps(manager))
    assert ids(again.request_observation(scheduler.conditions)) == [first]


def test_pickles_stay_small(ready, models, take_over):
    plain = copy.deepcopy(ready)
    plain.scheduler.queue_manager = BaseQueueManager(detailers=[RotspUpdateDetailer()])
    plain.scheduler.queue_manager.set_queue(ready.scheduler.queue_manager.desired_observations_array)
    scheduler = take_over(ready, manager_of(models[40768]))
    first = ids(scheduler.request_observation())
    kept = pickle.dumps(scheduler)
    assert len(kept) - len(pickle.dumps(plain.scheduler)) < MOST_PICKLED
    again = pickle.loads(kept)
    assert ids(again.request_observation()) == first
    assert again.queue_manager.counts["failed"] == 0
