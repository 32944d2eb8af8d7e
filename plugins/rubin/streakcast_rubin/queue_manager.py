"""`StreakQueueManager`: dispatches visits of the queue that no satellite crosses."""

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
from ._dispatched import DispatchedVisits, Owner
from ._mount import Mount, Openings
from ._verdicts import BLOCKINGS, DAMAGES, Rules, Verdicts, judge, scale_of, check_conditions

log = logging.getLogger("streakcast.rubin")


class StreakQueueManager(BaseQueueManager):
    """Queue manager that dispatches visits which no satellite crosses.

    For each requested visit it computes, for the first `look_ahead` valid visits of the queue, the shutter openings
    (slew and rotator, by the kinematic model of rubin_scheduler) and the satellites that cross each field from
    `jitter_s` before opening until `jitter_s` after closing. It dispatches the first visit if it is clear, or else the
    nearest clear one, or else the one with the smallest loss. Visits are never added, dropped or renumbered, and a
    deferred visit stays first in the queue. After an error the default visit of rubin_scheduler is dispatched.

    Parameters
    ----------
    model : StreakModel
        Site, satellites and field (``telescope="rubin"``).
    mjd_scale : {"utc", "tai", "tt"}, optional
        Scale of the scheduler's MJD. It must be given here or in the model.
    limit_mag : float or dict, optional
        Only satellites that cross and are brighter with a probability of at least 0.5 are avoided; by band as ``{"g":
        7, "default": 6}``. Without it, and in bands without a limit, all lit satellites are avoided.
    blocking : {"any", "avoid"}, optional
        Satellites to avoid: all lit ones, or those that exceed a limit (`limit_mag`, or without it the limits of the
        model's policy). Default: ``avoid`` if `limit_mag` is given, otherwise ``any``.
    damage : {"light", "pixels"}
        Measure of the loss of a visit: expected fraction of lost pixels, weighted by the brightness of the brightest
        satellite or not.
    look_ahead : int
        Number of visits of the queue that are checked.
    max_defer : int
        Largest number of deferrals, after which a visit is dispatched even if it is crossed.
    jitter_s : float
        Tolerance of the predicted shutter opening, seconds.
    max_extra_slew_s : float
        Largest slew time in excess of that to the first visit, seconds.
    kinematics : KinemModel, optional
        Kinematic model with the speeds of the real mount; default: that of rubin_scheduler.
    watch_s : float
        Interval between checks of the model's files for new element sets, seconds.
    detailers, basis_functions, check_clouds
        As for ``BaseQueueManager``.

    Attributes
    ----------
    counts : collections.Counter
        ``asked`` (once per visit), ``checked`` (visits evaluated), ``deferred`` (visits deferred), ``given_up``
        (dispatched although crossed), ``due`` (of these, after the largest number of deferrals), ``no_coordinates``,
        ``failed`` and the counters of `streakcast.hosts.Hook`.

    Raises
    ------
    ValueError
        The scale is missing, or an option is out of range.
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
            raise ValueError("limit_mag has no effect with blocking='any'; allowed: one of them")
        if model.field_radius_deg is None:
            raise ValueError("the model has no field of view; specify StreakModel(telescope=...) or fov=...")
        self.damage = one_of("damage", damage, DAMAGES)
        self.look_ahead = int(at_least("look_ahead", look_ahead, 1))
        self.max_defer = int(at_least("max_defer", max_defer, 0))
        self.jitter_s = at_least("jitter_s", jitter_s, 0.0, most=3600.0)
        self.max_extra_slew_s = at_least("max_extra_slew_s", max_extra_slew_s, 0.0)
        self.mount = Mount(kinematics)
        self._rules = Rules(self.mjd_scale, self.jitter_s, self.damage, self.blocking, self.limit_mag)
        self.hook = Hook(model, "rubin", watch_s=watch_s)
        self._dispatched, self._owner = DispatchedVisits(), Owner()
        self._choosing = False

    @property
    def counts(self) -> Counter[str]:
        """Counts of events."""
        return self.hook.counts

    # Methods called by rubin_scheduler -------------------------------------------------------------------------------

    def request_observation(self, conditions: Any, whole_queue: bool = False, n_return: int = 1) -> Any:
        """Returns the chosen visit; with `whole_queue` all valid visits in queue order, after the chosen one."""
        self._choosing = True
        try:
            result = super().request_observation(conditions, whole_queue=whole_queue, n_return=n_return)
        finally:
            self._choosing = False
        if np.size(result) == 0:
            # If a detailer has dropped the chosen visit, the default visit is returned.
            result = super().request_observation(conditions, whole_queue=whole_queue, n_return=n_return)
        return result

    def find_valid_observations_indx(self, conditions: Any, mjd: Union[float, None] = None) -> Any:
        """Returns the queue indices of valid visits. During a request the chosen one is first."""
        valid = super().find_valid_observations_indx(conditions, mjd=mjd)
        if mjd is not None:
            # The scheduler checks whether the queue is still valid. In simulations with old conditions, only this call
            # contains the current time.
            try:
                self.mount.set_time(mjd)
            except Exception as error:  # noqa: BLE001 - a hook never stops its host
                self.hook.note("clock", f"the time of the scheduler cannot be used: {type(error).__name__}: {error}", kind="time")
        if not self._choosing or np.size(valid) == 0:
            return valid
        chosen = self.hook.evaluate(lambda model: self._choice(model, conditions, valid), None)
        if chosen is None:
            return valid
        return np.concatenate([[chosen], valid[valid != chosen]])

    def add_observation(self, observation: Any, **more: Any) -> None:
        super().add_observation(observation, **more)
        try:
            self.mount.done(observation)
            visit = np.ravel(np.asarray(observation))[0]
            self._dispatched.clear_deferrals(visit)
            if float(visit["visittime"]) > 0.0:
                # Visits with duration 0 are reported as completed, but were not observed.
                self._dispatched.complete(visit)
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            self.hook.note("failed", f"a completed visit cannot be recorded: {type(error).__name__}: {error}")

    # Choice of the visit ---------------------------------------------------------------------------------------------

    def _choice(self, model: StreakModel, conditions: Any, valid: IntArray) -> Union[int, None]:
        """Returns the queue index of the visit to dispatch; `None` for the default visit."""
        check_conditions(self.hook, conditions, self.mjd_scale)
        queue, now = np.asarray(self.desired_observations_array), self.mount.now(conditions)
        free = np.array([index for index in valid[: 4 * self.look_ahead] if not self._dispatched.is_with_another(queue[index], self._owner, now)])
        indices = candidates(queue, free if free.size else valid, self.look_ahead)
        has_coordinates = np.isfinite(queue["RA"][indices]) & np.isfinite(queue["dec"][indices])
        if not has_coordinates.all():
            self.hook.note("no_coordinates", f"visit {queue['target_id'][indices[~has_coordinates][0]]} has no coordinates and is not checked")
            if not has_coordinates[0]:
                return None
            indices = indices[has_coordinates]
        visits = queue[indices]
        openings = self.mount.openings(conditions, visits)
        reached = np.isfinite(openings.start_mjd)
        if not reached[0]:
            # The first visit cannot be reached: the default visit of rubin_scheduler is used.
            return None
        reachable = Openings(*(one[reached] for one in openings))
        verdicts = judge(model, visits[reached], reachable, self._rules)
        indices, visits = indices[reached], visits[reached]
        self.counts["checked"] += int(indices.size)
        deferred = np.array([self._dispatched.deferred(one, now) for one in visits])
        choice = choose(verdicts.blocked, verdicts.damage, reachable.slew_s, deferred, self.max_extra_slew_s, self.max_defer)
        self._account(choice, visits, verdicts, reachable, now)
        self._dispatched.add(visits[choice.candidate], self._owner, now)
        return int(indices[choice.candidate])

    def _account(self, choice: Choice, visits: Visits, verdicts: Verdicts, openings: Openings, now: float) -> None:
        """Updates the counters. Writes a log line if a visit is deferred, or dispatched although crossed."""
        first, chosen = visits[0], visits[choice.candidate]
        if choice.candidate > 0:
            self.counts["deferred"] += 1
            self._dispatched.defer(first, now)
            longer_s = openings.slew_s[choice.candidate] - openings.slew_s[0]
            log.info("%s deferred for visit %d (slew %+.1f s): %s", _visit_text(first), chosen["target_id"], longer_s, _crossing_text(verdicts, 0))
        if choice.reason == "clear":
            return
        self.counts["given_up"] += 1
        self.counts["due"] += int(choice.reason == "due")
        reason = f"deferred {self.max_defer} times" if choice.reason == "due" else f"least loss of {visits.size} visits"
        log.info("%s dispatched although crossed (%s): %s", _visit_text(chosen), reason, _crossing_text(verdicts, choice.candidate))


def _visit_text(visit: Any) -> str:
    return f"visit {visit['target_id']} ({visit['band']}, ra {math.degrees(visit['RA']):.2f}, dec {math.degrees(visit['dec']):+.2f})"


def _crossing_text(verdicts: Verdicts, index: int) -> str:
    magnitude = verdicts.brightest_mag[index]
    light = f", brightest mag {magnitude:.1f}" if np.isfinite(magnitude) else ""
    return f"{verdicts.n_streaks[index]} satellites cross it{light}"
