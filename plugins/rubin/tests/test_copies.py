"""Copies and pickles of the queue manager, which `SummitWrapper` makes for each visit."""

import copy
import pickle

from conftest import ids, manager_of
from rubin_scheduler.scheduler.detailers import RotspUpdateDetailer
from rubin_scheduler.scheduler.schedulers import BaseQueueManager, SummitWrapper

#: Accepted increase of the size of a pickled scheduler, bytes.
MOST_PICKLED = 100_000


def test_summit_wrapper(ready, models, take_over):
    """The wrapper makes deep copies of the scheduler, requests several visits, and reports them as completed."""
    scheduler = take_over(ready, manager_of(models[40768]))
    wrapper = SummitWrapper(scheduler)
    wrapper.update_conditions(scheduler.conditions)
    out = [ids(wrapper.request_observation())[0] for _ in range(4)]
    assert len(set(out)) == 4
    ahead = wrapper.ahead_scheduler.queue_manager
    assert ahead is not scheduler.queue_manager and ahead.counts["failed"] == 0 and ahead.counts["asked"] == 4
    # Requested visits are taken as being in progress: the next one opens after them.
    taken_s = (ahead.mount.last["free_mjd"] - scheduler.queue_manager.mount.last["free_mjd"]) * 86_400.0
    assert 4 * 31.0 < taken_s < 4 * 31.0 + 4 * 40.0


def test_summit_wrapper_receives_no_visit_twice(ready, model, take_over, costly):
    """The first visit of the queue is dispatched as the second, and is in progress when the other one is completed."""
    scheduler = take_over(ready, manager_of(model))
    queue = ids(scheduler.return_active_queue())
    wrapper = SummitWrapper(scheduler)
    wrapper.update_conditions(scheduler.conditions)
    costly([20.0, *[0.0] * 11])
    one = wrapper.request_observation()
    costly(0.0)
    two = wrapper.request_observation()
    assert ids(two) == [queue[0]] and ids(one)[0] > queue[0]
    done = wrapper.requested_but_unadded_obs[0].copy()
    done["visittime"] = 31.0
    wrapper.add_observation(done)
    three = wrapper.request_observation()
    assert ids(three)[0] not in (*ids(one), *ids(two))
    assert wrapper.ahead_scheduler.queue_manager.counts["failed"] == 0
    # A visit that was not completed is available again later.
    manager = copy.deepcopy(scheduler.queue_manager)
    manager.mount.set_time(manager.mount.now(scheduler.conditions) + 11.0 / 1440.0)
    assert ids(manager.request_observation(scheduler.conditions)) == [queue[0]]


def test_pickles_stay_small(ready, models, take_over):
    plain = copy.deepcopy(ready)
    plain.scheduler.queue_manager = BaseQueueManager(detailers=[RotspUpdateDetailer()])
    plain.scheduler.queue_manager.set_queue(ready.scheduler.queue_manager.desired_observations_array)
    scheduler = take_over(ready, manager_of(models[40768]))
    first = ids(scheduler.request_observation())
    pickled = pickle.dumps(scheduler)
    assert len(pickled) - len(pickle.dumps(plain.scheduler)) < MOST_PICKLED
    again = pickle.loads(pickled)
    assert ids(again.request_observation()) == first
    assert again.queue_manager.counts["failed"] == 0
