"""`StreakCostBasisFunction`: cost of streaks as a map, for visits that start now or in the next minutes."""

from __future__ import annotations

import copy
from collections import Counter
from typing import Any, Union

import healpy as hp
import numpy as np
from rubin_scheduler.scheduler.basis_functions import BaseBasisFunction
from streakcast import StreakModel
from streakcast.hosts import Hook

from ._arrays import FloatArray, SingleArray
from ._candidates import OPEN_SHARE
from ._checks import BANDS, at_least
from ._costs import JITTER_S, with_costs
from ._tracks import CELLS, NSIDE, VISIT_S, Cache, Pointings, Samples, Sky, centres, discs, pointings_of
from ._verdicts import ConditionsCheck, scale_of

#: Slew time at which `SlewtimeBasisFunction` is -1, seconds.
SLEW_UNIT_S = 135.0
#: Smallest altitude of the telescope, degrees.
LOWEST_DEG = 20.0

#: Map of visits that start now: interval between samples, number of samples in a cached time slot, and number of cached
#: slots (ten minutes).
STEP_S = 1.0
STEPS = 40
SLOT_S = STEPS * STEP_S
CACHED_SLOTS = 15

#: Map of later visits: time for which a map is used and between samples, radius of the discs, and smallest cost that
#: counts. Smaller differences would decide between blocks whose other rewards are equal.
AHEAD_STEP_MIN = 5.0
DISC_DEG = 10.0
DEAD_BAND_S = 0.1
#: Number of cached maps: those of the bands with different limits.
CACHED_MAPS = 6


class StreakCostBasisFunction(BaseBasisFunction):
    """Expected cost of the streaks of a visit to each cell, nside 32, RING, with a minus sign.

    The value is -C / (0.77 · 135 s), where C is the cost in seconds of open shutter (``streak_cost_s``). This is the unit
    of `SlewtimeBasisFunction`: give it the weight that the survey gives to the slew time. Values are never NaN.

    With ``ahead_min=0``, for greedy surveys, C is that of a visit that starts now: after the slew to the cell (map of
    the conditions). With ``ahead_min=45``, for pairs and blobs, the start of the visit is unknown. C is then the mean of
    this time span and of a disc of 10 deg, less 0.1 s, and at least 0. This map is computed every 5 min, and is common to
    all bands with the same limits: use one object for all surveys.

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
    ahead_min : float
        Time span of the visits, minutes, up to 720; 0 for visits that start now.
    mjd_scale : {"utc", "tai", "tt"}, optional
        Scale of the scheduler's MJD. It must be given here or in the model.
    bandname : str, optional
        Band of the survey, for limits by band; default: the current band.
    watch_s : float
        Interval between checks of the model's files for new element sets, seconds.

    Attributes
    ----------
    counts : collections.Counter
        ``asked``, ``made`` (computed maps), ``failed``, ``unknown`` (the element sets are too old) and the counters of
        `streakcast.hosts.Hook`. After an error, and if the positions are unknown, the map is 0 everywhere.

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
        ahead_min: float = 0.0,
        mjd_scale: Union[str, None] = None,
        bandname: Union[str, None] = None,
        watch_s: float = 60.0,
    ) -> None:
        super().__init__(nside=NSIDE, bandname=bandname)
        # The map does not depend on completed visits.
        self.update_on_newobs = False
        self.mjd_scale = scale_of(model, mjd_scale)
        if bandname is not None and bandname not in BANDS[:-1]:
            raise ValueError(f"bandname is '{bandname}'; allowed: {', '.join(BANDS[:-1])}")
        self.ahead_min = at_least("ahead_min", ahead_min, 0.0, most=720.0)
        self.hook = Hook(with_costs(model, bright_share, limit_mag), "rubin", watch_s=watch_s)
        self._check = ConditionsCheck(self.hook, self.mjd_scale)
        self._survey: Any = None
        self._clear_caches()

    def _clear_caches(self) -> None:
        self._slots: Cache[SingleArray] = Cache(CACHED_SLOTS)
        self._ahead: Cache[FloatArray] = Cache(CACHED_MAPS)
        #: Night, fields of the survey, and field index of each cell, if the survey has not yet rotated its fields for
        #: the night.
        self._rotated_fields: Union[tuple[int, Any, Any], None] = None

    def __getstate__(self) -> dict[str, Any]:
        # Cached maps are not copied. They are computed again on first use.
        caches = ("_slots", "_ahead", "_rotated_fields")
        return {**{name: one for name, one in self.__dict__.items() if name not in caches}, "value": 0, "recalc": True}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._clear_caches()

    @property
    def counts(self) -> Counter[str]:
        """Counts of events."""
        return self.hook.counts

    def _calc_value(self, conditions: Any, indx: Any = None, **_: Any) -> FloatArray:
        """Returns the map at the time of the conditions, or zeros after an error."""
        self.value = self.hook.evaluate(lambda model: self._map_of(model, conditions), np.zeros(CELLS))
        self.mjd_last = conditions.mjd + 0
        self.recalc = False
        return self.value

    def _map_of(self, model: StreakModel, conditions: Any) -> FloatArray:
        self._check(conditions)
        band = self.bandname if self.bandname is not None else conditions.current_band
        sky = Sky(model, self.mjd_scale, band)
        now = float(np.max(conditions.mjd))
        cost_s = self._cost_ahead_s(sky, now) if self.ahead_min > 0.0 else self._cost_now_s(sky, now, conditions)
        return -cost_s / (OPEN_SHARE * SLEW_UNIT_S)

    # Visits that start later -----------------------------------------------------------------------------------------

    def _cost_ahead_s(self, sky: Sky, now: float) -> FloatArray:
        slot = int(now * 1440.0 // AHEAD_STEP_MIN)
        key = (slot, sky.costs)
        found = self._ahead.get(sky.model, key)
        if found is not None:
            return found
        later_min = np.arange(0.0, self.ahead_min + AHEAD_STEP_MIN / 2.0, AHEAD_STEP_MIN)
        share_per_s = np.zeros(CELLS)
        for start_mjd in (slot * AHEAD_STEP_MIN + later_min) / 1440.0:
            # The discs of the lowest visits reach below the smallest altitude.
            samples = sky.sample(start_mjd, np.zeros(1), LOWEST_DEG - DISC_DEG, possible=False)
            cells = hp.vec2pix(NSIDE, *samples.direction.T)
            share_per_s += np.bincount(cells, weights=samples.share_per_s, minlength=CELLS)
        in_disc, sizes = discs(DISC_DEG)
        mean = np.add.reduceat(share_per_s[in_disc], np.cumsum(sizes) - sizes) / sizes / later_min.size
        # From the mean of a cell to the sum in a field.
        share = mean * VISIT_S * np.pi * sky.radius_deg**2 / hp.nside2pixarea(NSIDE, degrees=True)
        self.counts["made"] += 1
        return self._ahead.put(key, np.maximum(sky.cost_s(share) - DEAD_BAND_S, 0.0))

    # Visits that start now -------------------------------------------------------------------------------------------

    def follow(self, survey: Any) -> None:
        """Uses the fields of a survey, which are the pointings of its visits, instead of the cells.

        The centre of a field may be 2 deg from the chosen cell. Surveys with the same fields, dithers and seed may use
        one map, because their fields are the same in each night.

        Parameters
        ----------
        survey : rubin_scheduler survey
            Survey with `fields` and `hp2fields`, such as `GreedySurvey`, that rotates its fields once per night or
            never.

        Raises
        ------
        ValueError
            The survey has no such fields, or it rotates them at each call, after the map was evaluated; or the map is
            that of later visits, which does not depend on fields.
        """
        if self.ahead_min > 0.0:
            raise ValueError(f"ahead_min is {self.ahead_min:g}, and the map does not depend on the fields of a survey; allowed: 0")
        if getattr(survey, "fields", None) is None or np.shape(getattr(survey, "hp2fields", ())) != (CELLS,):
            raise ValueError(f"{type(survey).__name__} has no fields for the cells of nside {NSIDE}; allowed: a survey with fields and hp2fields")
        if getattr(survey, "dither", None) == "call":
            raise ValueError("the survey has dither='call' and rotates its fields after the map is evaluated; allowed: dither='night' or none")
        self._survey, self._rotated_fields = survey, None

    def _fields(self, night: int) -> tuple[Any, Any]:
        """Returns the fields of the survey in a night, and the field index of each cell."""
        survey = self._survey
        if getattr(survey, "dither", None) != "night" or np.max(survey.night) == night:
            return survey.fields, survey.hp2fields
        if self._rotated_fields is None or self._rotated_fields[0] != night:
            # The survey rotates its fields when it is first chosen in a night, which is after the map was evaluated.
            tonight = copy.copy(survey)
            tonight.fields = survey.fields_init.copy()
            tonight._spin_fields(night)
            self._rotated_fields = (night, tonight.fields, tonight.hp2fields)
        return self._rotated_fields[1:]

    def _pointings(self, night: int, radius_deg: float) -> Pointings:
        """Returns the pointings of visits to the cells in a night."""
        if self._survey is None:
            return pointings_of(centres().tobytes(), np.arange(CELLS).tobytes(), radius_deg)
        fields, of_cell = self._fields(night)
        directions = hp.ang2vec(np.pi / 2.0 - fields["dec"], fields["RA"])
        return pointings_of(directions.tobytes(), np.asarray(of_cell, dtype=np.int64).tobytes(), radius_deg)

    def _cost_now_s(self, sky: Sky, now: float, conditions: Any) -> FloatArray:
        slew_s = np.broadcast_to(np.asarray(conditions.slewtime, dtype=float), (CELLS,))
        reached = np.isfinite(slew_s)
        cost = np.zeros(CELLS)
        if not reached.any():
            return cost
        radius_deg, costs = sky.radius_deg, sky.costs
        pointings = self._pointings(int(np.max(conditions.night)), radius_deg)
        of_cell, n = pointings.of_cell[reached], len(pointings.centres)
        opens_s = now * 86_400.0 + slew_s[reached] - JITTER_S
        window_s = VISIT_S + 2.0 * JITTER_S
        first, end = (np.ceil(one / STEP_S).astype(np.int64) for one in (opens_s, opens_s + window_s))
        share = np.zeros(of_cell.size)
        for number in range(first.min() // STEPS, (end.max() - 1) // STEPS + 1):
            # The shares per step are the same for all visits; only the steps of the window differ.
            cumulative = self._slots.get((sky.model, pointings), (number, costs))
            if cumulative is None:
                seconds = np.arange(0.0, SLOT_S, STEP_S)
                samples = sky.sample(number * SLOT_S / 86_400.0, seconds, LOWEST_DEG - radius_deg, possible=True)
                cumulative = self._slots.put((number, costs), _shares(samples, pointings, radius_deg))
            since, until = (np.clip(step - number * STEPS, 0, STEPS) for step in (first, end))
            share += cumulative.take(until * n + of_cell) - cumulative.take(since * n + of_cell)
        # As in the queue manager, the cost is that of the visit, without the tolerance on both sides.
        cost[reached] = sky.cost_s(share * VISIT_S / window_s)
        self.counts["made"] += 1
        return cost


def _shares(samples: Samples, pointings: Pointings, radius_deg: float) -> SingleArray:
    """Returns the cumulative share lost at each pointing before each step of a slot: ``(STEPS + 1, n_pointings)``."""
    n = len(pointings.centres)
    nearby = pointings.near[hp.vec2pix(NSIDE, *samples.direction.T)]
    cosine = (pointings.centres[nearby] @ samples.direction.astype(np.float32)[:, :, None])[..., 0]
    row, column = np.nonzero((cosine >= np.cos(np.radians(radius_deg))) & (nearby >= 0))
    cell = (samples.moment[row] + 1) * n + nearby[row, column]
    share = np.bincount(cell, weights=STEP_S * samples.share_per_s[row], minlength=(STEPS + 1) * n)
    return np.cumsum(share.reshape(STEPS + 1, n), axis=0).astype(np.float32)
