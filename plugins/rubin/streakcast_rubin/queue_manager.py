"""`StreakQueueManager`: at each visit, the first of the next in the queue that no satellite will cross."""

from __future__ import annotations

import logging
import math
from collections import Counter
from typing import Any, Union

import numpy as np
from rubin_scheduler.scheduler.model_observatory import KinemModel
from rubin_scheduler.scheduler.schedulers import BaseQueueManager
from streakcast import StreakModel
from streakcast.hosts import Hook

from ._arrays import IntArray, Visits
from ._candidates import Choice, candidates, choose
from ._checks import at_least, limits, one_of
from ._handed import Handed, Owner
from ._mount import Mount, Openings
from ._questions import BLOCKINGS, DAMAGES, Rules, Verdicts, judge, scale_of, see

log = logging.getLogger("streakcast.rubin")


class StreakQueueManager(BaseQueueManager):
    """Dispatches visits of the queue so that no satellite crosses them.

    Asked for a visit, it takes the first `look_ahead` valid ones of the queue, computes when the shutter would open on each (slew
    and rotator, by the host's own kinematic model), asks for all in one question which satellites cross the field from `jitter_s`
    before that until as long after the closing, and dispatches the first of the queue if it is clear, else the nearest clear one, else
    the one that loses least. Visits are
    never invented, dropped or given other numbers; a visit that was put off stays first in the queue. Whatever fails, the host's own
    choice goes out.

    Parameters
    ----------
    model : StreakModel
        Site, satellites and field (``telescope="rubin"``).
    mjd_scale : {"utc", "tai", "tt"}, optional
        Scale of the host's MJD. Must be said here or in the model.
    limit_mag : float or dict, optional
        Only satellites brighter than this are dodged, by band as ``{"g": 7, "default": 6}``; without it, and in bands that it does not
        name, all that are lit.
    blocking : {"any", "avoid"}, optional
        What is dodged: any lit satellite, or what breaks a limit: `limit_mag`, or without it those of the model's policy. By itself
        the second where `limit_mag` is given.
    damage : {"light", "pixels"}
        By what the least bad is found: expected share of lost pixels weighed with the light of the brightest satellite, or alone.
    look_ahead : int
        How many visits of the queue are looked at.
    max_defer : int
        How often a visit may be put off before it goes out streaked or not.
    jitter_s : float
        How much earlier or later than computed the shutter may open, seconds.
    max_extra_slew_s : float
        How much longer than to the first visit the way to another may be, seconds.
    kinematics : KinemModel, optional
        The host's kinematic model with the mount's real speeds; its defaults where left out.
    watch_s : float
        How often the files of the model are looked at for new elements, seconds.
    detailers, basis_functions, check_clouds
        As for the host's ``BaseQueueManager``.

    Attributes
    ----------
    counts : collections.Counter
        ``asked`` (once a visit), ``checked`` (visits judged), ``deferred`` (visits put off), ``given_up`` (dispatched although crossed), ``due`` (of
        these, put off too often), ``no_coordinates``, ``failed`` and what `streakcast.hosts.Hook` counts.

    Raises
    ------
    ValueError
        A scale that nobody said, or an option that is out of range.
    """

    def __init__(
        self,
        model: StreakModel,
        *,
        mjd_scale: Union[str, None] = None,
        limit_mag: Any = None,
        blocking: Union[str, None] = None,
        damage: str = "light",
        look_ahead: int = 12,
        max_defer: int = 20,
        jitter_s: float = 3.0,
        max_extra_slew_s: float = 20.0,
        kinematics: Union[KinemModel, None] = None,
        watch_s: float = 60.0,
        detailers: Any = None,
        basis_functions: Any = None,
        check_clouds: bool = True,
    ) -> None:
        super().__init__(detailers=detailers, basis_functions=basis_functions, check_clouds=check_clouds)
        self.mjd_scale = scale_of(model, mjd_scale)
        self.blocking = blocking if blocking is not None else "any" if limit_mag is None else "avoid"
        one_of("blocking", self.blocking, BLOCKINGS)
        self.limit_mag = limits(limit_mag)
        if limit_mag is not None and self.blocking == "any":
            raise ValueError("limit_mag with blocking='any' does nothing; allowed: one of them")
        if model.field_radius_deg is None:
            raise ValueError("the model has no field of view: give it telescope= or fov=")
        self.damage = one_of("damage", damage, DAMAGES)
        self.look_ahead = int(at_least("look_ahead", look_ahead, 1))
        self.max_defer = int(at_least("max_defer", max_defer, 0))
        self.jitter_s = at_least("jitter_s", jitter_s, 0.0, most=3600.0)
        self.max_extra_slew_s = at_least("max_extra_slew_s", max_extra_slew_s, 0.0)
        self.mount = Mount(kinematics)
        self._rules = Rules(self.mjd_scale, self.jitter_s, self.damage, self.blocking, self.limit_mag)
        self.hook = Hook(model, "rubin", watch_s=watch_s)
        self._handed, self._owner = Handed(), Owner()
        self._choosing = False

    @property
    def counts(self) -> Counter[str]:
        """How often what happened."""
        return self.hook.counts

    # What the host calls -------------------------------------------------------------------------------------------

    def request_observation(self, conditions: Any, whole_queue: bool = False, n_return: int = 1) -> Any:
        """The host's question. With `whole_queue` all valid visits come, in the queue's order but for the first, which is our choice."""
        self._choosing = True
        try:
            result = super().request_observation(conditions, whole_queue=whole_queue, n_return=n_return)
        finally:
            self._choosing = False
        if np.size(result) == 0:
            # A detailer may have dropped what we chose: the host's own first one then.
            result = super().request_observation(conditions, whole_queue=whole_queue, n_return=n_return)
        return result

    def find_valid_observations_indx(self, conditions: Any, mjd: Union[float, None] = None) -> Any:
        """Places in the queue of what can be observed; our choice comes first while a visit is being asked for."""
        valid = super().find_valid_observations_indx(conditions, mjd=mjd)
        if mjd is not None:
            # Asked whether the queue is still good: the one place where a simulation with old conditions tells the time.
            try:
                self.mount.tell(mjd)
            except Exception as error:  # noqa: BLE001 - a hook never stops its host
                self.hook.note("clock", f"the host's time cannot be followed: {type(error).__name__}: {error}", kind="told")
        if not self._choosing or np.size(valid) == 0:
            return valid
        chosen = self.hook.ask(lambda model: self._choice(model, conditions, valid), None)
        if chosen is None:
            return valid
        return np.concatenate([[chosen], valid[valid != chosen]])

    def add_observation(self, observation: Any, **more: Any) -> None:
        super().add_observation(observation, **more)
        try:
            self.mount.done(observation)
            visit = np.ravel(np.asarray(observation))[0]
            self._handed.taken(visit)
            if float(visit["visittime"]) > 0.0:
                # Without a length it was not done, only taken for done.
                self._handed.back(visit)
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            self.hook.note("failed", f"a visit cannot be followed: {type(error).__name__}: {error}")

    # How it is chosen ----------------------------------------------------------------------------------------------

    def _choice(self, model: StreakModel, conditions: Any, valid: IntArray) -> Union[int, None]:
        """The place in the queue of what should go out now."""
        see(self.hook, conditions, self.mjd_scale)
        queue, now = np.asarray(self.desired_observations_array), self.mount.now(conditions)
        free = np.array([place for place in valid[: 4 * self.look_ahead] if not self._handed.by_others(queue[place], self._owner, now)])
        places = candidates(queue, free if free.size else valid, self.look_ahead)
        placed = np.isfinite(queue["RA"][places]) & np.isfinite(queue["dec"][places])
        if not placed.all():
            self.hook.note("no_coordinates", f"visit {queue['target_id'][places[~placed][0]]} has no coordinates and is not judged")
            if not placed[0]:
                return None
            places = places[placed]
        visits = queue[places]
        openings = self.mount.openings(conditions, visits)
        reached = np.isfinite(openings.start_mjd)
        if not reached[0]:
            # The telescope cannot go where the host wants it: the host's own affair.
            return None
        known = Openings(*(one[reached] for one in openings))
        verdicts = judge(model, visits[reached], known, self._rules)
        places, visits = places[reached], visits[reached]
        self.counts["checked"] += int(places.size)
        deferred = np.array([self._handed.deferred(one, now) for one in visits])
        choice = choose(verdicts.blocked, verdicts.damage, known.slew_s, deferred, self.max_extra_slew_s, self.max_defer)
        self._account(choice, visits, verdicts, known, now)
        self._handed.out(visits[choice.place], self._owner, now)
        return int(places[choice.place])

    def _account(self, choice: Choice, visits: Visits, verdicts: Verdicts, openings: Openings, now: float) -> None:
        """Counters, and one line in the log where a visit is put off or goes out streaked."""
        first, chosen = visits[0], visits[choice.place]
        if choice.place > 0:
            self.counts["deferred"] += 1
            self._handed.put_off(first, now)
            longer_s = openings.slew_s[choice.place] - openings.slew_s[0]
            log.info("%s put off for visit %d (slew %+.1f s): %s", _named(first), chosen["target_id"], longer_s, _why(verdicts, 0))
        if choice.why == "clear":
            return
        self.counts["given_up"] += 1
        self.counts["due"] += int(choice.why == "due")
        reason = f"put off {self.max_defer} times" if choice.why == "due" else f"the least bad of {visits.size}"
        log.info("%s goes out crossed (%s): %s", _named(chosen), reason, _why(verdicts, choice.place))


def _named(visit: Any) -> str:
    return f"visit {visit['target_id']} ({visit['band']}, ra {math.degrees(visit['RA']):.2f}, dec {math.degrees(visit['dec']):+.2f})"


def _why(verdicts: Verdicts, place: int) -> str:
    magnitude = verdicts.brightest_mag[place]
    light = f", brightest mag {magnitude:.1f}" if np.isfinite(magnitude) else ""
    return f"{verdicts.n_streaks[place]} satellites cross it{light}"
