"""`StreakQueueManager`: exchanges visits of the queue if this saves more time from streaks than it costs in slewing."""

from __future__ import annotations

import logging
import math
import os
from collections import Counter, deque
from typing import Any, Union

import numpy as np
from rubin_scheduler.scheduler.model_observatory import KinemModel
from rubin_scheduler.scheduler.schedulers import BaseQueueManager
from streakcast import StreakModel
from streakcast.hosts import Hook

from ._arrays import BoolArray, IntArray
from ._candidates import OPEN_SHARE, candidates, choose, detours_s
from ._checks import whole
from ._costs import Costs, costs_of, with_costs
from ._dispatched import DispatchedVisits, Owner, key_of
from ._exchanges import MOST_EXCHANGES, Exchange, table_of, write
from ._mount import Mount, Openings
from ._verdicts import ConditionsCheck, scale_of

#: Cost of the first visit, seconds of open shutter, up to which it is dispatched without comparing other visits.
LEAST_COST_S = 0.05

log = logging.getLogger("streakcast.rubin")


class StreakQueueManager(BaseQueueManager):
    """Queue manager that exchanges two visits if this saves more observing time from streaks than it costs in slewing.

    For each requested visit it computes the shutter opening (slew and rotator, by the kinematic model of
    rubin_scheduler) and the cost of the streaks in seconds of open shutter (``streak_cost_s``). If the first visit of the
    queue costs more than 0.05 s, the first `look_ahead` valid visits are compared: the one with the least sum of cost and
    detour is dispatched. The detour is that of the whole path, which returns to the first visit; a second of it costs
    0.77 s of open shutter. Visits are never added, dropped or renumbered, and an exchanged visit stays first in the
    queue. After an error the default visit of rubin_scheduler is dispatched.

    Parameters
    ----------
    model : StreakModel
        Site, satellites, field and telescope (``telescope="rubin"``).
    bright_share : float, optional
        Share of a visit that is lost to a bright streak across the whole field. Default: that of the model, 0.08 if its
        telescope has none.
    limit_mag : float or dict, optional
        A satellite that is brighter costs the whole visit; by band as ``{"g": 7, "default": 6}``. Default: that of the
        model.
    look_ahead : int
        Number of visits of the queue that are compared.
    mjd_scale : {"utc", "tai", "tt"}, optional
        Scale of the scheduler's MJD. It must be given here or in the model.
    kinematics : KinemModel, optional
        Kinematic model with the speeds of the real mount; default: that of rubin_scheduler.
    watch_s : float
        Interval between checks of the model's files for new element sets, seconds.
    detailers, basis_functions, check_clouds
        As for ``BaseQueueManager``.

    Attributes
    ----------
    counts : collections.Counter
        ``asked`` (once per visit), ``compared`` (visits that were compared because the first one is crossed),
        ``exchanged`` (visits dispatched before the first one), ``saved_s`` and ``detour_s`` (sums over the exchanged
        visits: cost of the first less that of the dispatched visit, seconds of open shutter, and detours, seconds of the
        night), ``no_coordinates``, ``not_judged``, ``failed`` and the counters of `streakcast.hosts.Hook`.
    exchanges : dict of arrays
        The last 500,000 exchanges, for `survey_summary`: ``mjd`` (predicted shutter opening), ``target_id`` and ``band`` of
        the dispatched visit, ``first_target_id``, ``first_cost_s`` and ``cost_s`` (costs of the first and of the dispatched
        visit), ``saved_s`` and ``detour_s``.

    Raises
    ------
    ValueError
        The scale or the telescope is missing, or an option is out of range.
    """

    def __init__(
        self,
        model: StreakModel,
        *,
        bright_share: Union[float, None] = None,
        limit_mag: Any = None,
        look_ahead: int = 12,
        mjd_scale: Union[str, None] = None,
        kinematics: Union[KinemModel, None] = None,
        watch_s: float = 60.0,
        detailers: Any = None,
        basis_functions: Any = None,
        check_clouds: bool = True,
    ) -> None:
        super().__init__(detailers=detailers, basis_functions=basis_functions, check_clouds=check_clouds)
        self.mjd_scale = scale_of(model, mjd_scale)
        self.look_ahead = whole("look_ahead", look_ahead, 1)
        self.mount = Mount(kinematics)
        self.hook = Hook(with_costs(model, bright_share, limit_mag), "rubin", watch_s=watch_s)
        self._check = ConditionsCheck(self.hook, self.mjd_scale)
        self._dispatched, self._owner = DispatchedVisits(), Owner()
        self._exchanges: deque[Exchange] = deque(maxlen=MOST_EXCHANGES)
        self._choosing = False
        # Exchange of this request, which counts if no detailer drops its visit, with texts about the first visit.
        self._pending: Union[tuple[Exchange, str, str], None] = None
        # Visit that this request has chosen, and its time, for other copies.
        self._chosen: Union[tuple[Any, float], None] = None

    @property
    def counts(self) -> Counter[str]:
        """Counts of events."""
        return self.hook.counts

    @property
    def exchanges(self) -> dict[str, Any]:
        """Exchanges as columns."""
        return table_of(self._exchanges)

    def write_exchanges(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the exchanges as ECSV, a table that `survey_summary` and astropy read."""
        write(self.exchanges, path)

    # Methods called by rubin_scheduler -------------------------------------------------------------------------------

    def request_observation(self, conditions: Any, whole_queue: bool = False, n_return: int = 1) -> Any:
        """Returns the chosen visit; with `whole_queue` all valid visits in queue order, after the chosen one."""
        self._choosing, self._pending, self._chosen = True, None, None
        try:
            result = super().request_observation(conditions, whole_queue=whole_queue, n_return=n_return)
        finally:
            self._choosing = False
        if np.size(result) == 0:
            # If a detailer has dropped the chosen visit, the default visit is returned.
            result = super().request_observation(conditions, whole_queue=whole_queue, n_return=n_return)
        elif self._chosen is not None and self._chosen[0]["target_id"] == np.ravel(result["target_id"])[0]:
            # Only a visit that no detailer has dropped is taken for other copies.
            visit, now = self._chosen
            self._dispatched.add(visit, self._owner, now)
            if self._pending is not None:
                self._account(*self._pending)
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
            if float(visit["visittime"]) > 0.0:
                # Visits with duration 0 are reported as completed, but were not observed.
                self._dispatched.complete(visit)
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            self.hook.note("failed", f"a completed visit cannot be recorded: {type(error).__name__}: {error}")

    # Choice of the visit ---------------------------------------------------------------------------------------------

    def _choice(self, model: StreakModel, conditions: Any, valid: IntArray) -> Union[int, None]:
        """Returns the queue index of the visit to dispatch; `None` for the default visit."""
        self._check(conditions)
        queue, now = np.asarray(self.desired_observations_array), self.mount.now(conditions)
        taken = self._dispatched.with_others(self._owner, now)
        free = np.array([one for one in valid[: 4 * self.look_ahead] if key_of(queue[one]) not in taken]) if taken else valid
        free = free if free.size else valid
        first = queue[free[:1]]
        if not self._has_coordinates(first)[0]:
            return None
        opening = self.mount.openings(conditions, first)
        if not np.isfinite(opening.start_mjd[0]):
            # The first visit cannot be reached: the default visit of rubin_scheduler is used.
            return None
        cost_s = float(costs_of(model, first, opening, self.mjd_scale).cost_s[0])
        if not math.isfinite(cost_s):
            # It cannot be compared.
            self.hook.note("not_judged", f"the cost of visit {first['target_id'][0]} is unknown; it is dispatched in the order of the queue")
            return None
        chosen = int(free[0]) if cost_s <= LEAST_COST_S else self._compared(model, conditions, queue, free, now, cost_s)
        self._chosen = queue[chosen].copy(), now
        return chosen

    def _compared(self, model: StreakModel, conditions: Any, queue: Any, free: IntArray, now: float, first_s: float) -> int:
        """Compares the first visits of the queue, of which the first one costs `first_s`, and returns the queue index of the
        best one."""
        # One more than may be chosen, because the path continues after the last one.
        indices = candidates(queue, free, self.look_ahead + 1)
        following = indices[self.look_ahead :]
        indices = indices[self._has_coordinates(queue[indices])]
        if indices.size == 1:
            return int(indices[0])
        openings = self.mount.openings(conditions, queue[indices])
        reached = np.isfinite(openings.start_mjd)
        reached[0] = True
        openings, indices = Openings(*(column[reached] for column in openings)), indices[reached]
        visits = queue[indices]
        detour_s = detours_s(openings.slew_s, self.mount.between(now, visits))
        may_be_chosen = ~np.isin(indices, following)
        self.counts["compared"] += int(may_be_chosen.sum())
        # The cost of streaks is not computed for visits whose detour alone costs more than the first visit.
        near = may_be_chosen & (OPEN_SHARE * detour_s < first_s)
        near[0] = True
        if not near[1:].any():
            return int(indices[0])
        visits, indices, detour_s = visits[near], indices[near], detour_s[near]
        openings = Openings(*(column[near] for column in openings))
        costs = costs_of(model, visits, openings, self.mjd_scale)
        chosen = choose(costs.cost_s, detour_s)
        if chosen > 0:
            first, one = visits[0], visits[chosen]
            exchange = Exchange(
                float(openings.start_mjd[chosen]), int(one["target_id"]), str(one["band"]), int(first["target_id"]),
                float(costs.cost_s[0]), float(costs.cost_s[chosen]), float(detour_s[chosen]),
            )  # fmt: skip
            self._pending = exchange, _visit_text(first), _crossing_text(costs, 0)
        return int(indices[chosen])

    def _has_coordinates(self, visits: Any) -> BoolArray:
        """Returns which visits have coordinates, and notes the first one without."""
        has_coordinates: BoolArray = np.isfinite(visits["RA"]) & np.isfinite(visits["dec"])
        if not has_coordinates.all():
            self.hook.note("no_coordinates", f"visit {visits['target_id'][~has_coordinates][0]} has no coordinates and is not checked")
        return has_coordinates

    def _account(self, exchange: Exchange, first: str, crossing: str) -> None:
        """Records an exchange, updates the counters, and writes a log line with texts about the first visit."""
        self._exchanges.append(exchange)
        self.counts["exchanged"] += 1
        self.counts["saved_s"] += exchange.saved_s  # type: ignore[assignment]
        self.counts["detour_s"] += exchange.detour_s  # type: ignore[assignment]
        log.info(
            "%s after visit %d: streaks cost %.2f s instead of %.2f s, detour %+.1f s; %s",
            first, exchange.target_id, exchange.cost_s, exchange.first_cost_s, exchange.detour_s, crossing,
        )  # fmt: skip


def _visit_text(visit: Any) -> str:
    return f"visit {visit['target_id']} ({visit['band']}, ra {math.degrees(visit['RA']):.2f}, dec {math.degrees(visit['dec']):+.2f})"


def _crossing_text(costs: Costs, index: int) -> str:
    magnitude = costs.brightest_mag[index]
    light = f", brightest mag {magnitude:.1f}" if np.isfinite(magnitude) else ""
    return f"{costs.n_streaks[index]} satellites cross it{light}"
