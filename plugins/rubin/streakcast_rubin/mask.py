"""`StreakMaskBasisFunction`: NaN where satellites cross a visit that starts now, for greedy surveys."""

from __future__ import annotations

import copy
from typing import Any, Union

import healpy as hp
import numpy as np
from streakcast import StreakModel

from ._arrays import BoolArray, FloatArray
from ._checks import above, at_least
from ._maps import CELLS, NSIDE, StreakMap
from ._verdicts import limit_of, check_conditions
from ._tracks import SAMPLE_S, SLOT_S, Pointings, Samples, SlotCache, cells_as_pointings, fields_as_pointings, loss_of, sectors

#: Half of the side of a cell of nside 32, degrees.
HALF_CELL_DEG = 0.92
#: Largest distance of a point in a cell from its centre, degrees.
CELL_REACH_DEG = float(hp.max_pixrad(NSIDE, degrees=True))
#: Motion of the fastest satellites (at 340 km in the zenith) between two samples, degrees.
FASTEST_STEP_DEG = 1.3 * SAMPLE_S
#: Margin added to the radius of fields, degrees. Tracks have errors of some arcminutes.
FIELD_PAD_DEG = 0.1
#: If at least nine tenths of a sector are crossed, cells are masked whose loss exceeds that of the best tenth of the
#: sector by this factor.
MASK_RATIO = 2.0
#: Number of samples in a slot.
STEPS = int(SLOT_S / SAMPLE_S)


class StreakMaskBasisFunction(StreakMap):
    """Sky mask, nside 32, RING: NaN where satellites would cross, 0 elsewhere. Weight 0.

    The time window of each cell is that of a visit which starts now: slew (map of the conditions), exposure, and
    `jitter_s` on both sides. A cell is masked if the distance of a lit satellite from its centre is less than the field
    radius plus half a cell or, after `follow`, if a satellite crosses the field of the survey to which the cell
    belongs. If more than `max_share` of the reachable cells would be masked, the cells with the smallest loss are not
    masked: some in every sector of the sky, and all whose loss is less than twice that of the best tenth of their
    sector.

    Parameters
    ----------
    model : StreakModel
        Site, satellites and field, with a telescope.
    mjd_scale : {"utc", "tai", "tt"}, optional
        Scale of the scheduler's MJD. It must be given here or in the model.
    limit_mag : float or dict, optional
        Only satellites that are brighter with a probability of at least 0.5 are avoided; by band as ``{"g": 7,
        "default": 6}``. Without it, and in bands without a limit, all lit satellites are avoided.
    damage : {"light", "pixels"}
        Measure of the loss in a cell: lost pixels, weighted by the brightness of each satellite or not.
    exptime_s : float
        Duration of the visits, including shutter motion, seconds.
    jitter_s : float
        Tolerance of the predicted shutter opening, seconds.
    max_share : float
        Largest fraction of the reachable sky that is masked, (0, 1].
    pad_deg : float
        Margin added to the field radius around the centre of a cell, degrees; not used after `follow`.
    bandname : str, optional
        Band of the survey, for limits by band; default: the current band.
    watch_s : float
        Interval between checks of the model's files for new element sets, seconds.
    nside : int
        Must be 32.

    Attributes
    ----------
    counts : collections.Counter
        ``asked``, ``masked`` (cells), ``capped`` (maps), ``failed`` and the counters of `streakcast.hosts.Hook`. After
        an error no cell is masked.

    Raises
    ------
    ValueError
        The scale is missing, the model has no field or telescope, or an option is out of range.
    """

    def __init__(
        self,
        model: StreakModel,
        *,
        mjd_scale: Union[str, None] = None,
        limit_mag: Any = None,
        damage: str = "light",
        exptime_s: float = 31.0,
        jitter_s: float = 3.0,
        max_share: float = 0.9,
        pad_deg: float = HALF_CELL_DEG,
        bandname: Union[str, None] = None,
        watch_s: float = 60.0,
        nside: int = NSIDE,
    ) -> None:
        super().__init__(
            model, mjd_scale=mjd_scale, limit_mag=limit_mag, damage=damage, bandname=bandname, watch_s=watch_s, nside=nside
        )
        self.exptime_s = at_least("exptime_s", exptime_s, 0.0, most=3600.0)
        self.jitter_s = at_least("jitter_s", jitter_s, 0.0, most=3600.0)
        self.max_share = above("max_share", max_share, 0.0, most=1.0)
        self.pad_deg = at_least("pad_deg", pad_deg, 0.0, most=90.0)
        self._cache: SlotCache[FloatArray] = SlotCache()
        self._survey: Any = None
        #: Night, fields of the survey, and field index of each cell, if the survey has not yet rotated its fields for
        #: the night.
        self._rotated_fields: Union[tuple[int, Any, Any], None] = None

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_cache": SlotCache(), "_rotated_fields": None}

    def follow(self, survey: Any) -> None:
        """Uses the fields of a survey, which are the pointings of its visits, instead of the cells.

        The centre of a field may be 2 deg from the chosen cell. With known fields no margin is needed: less sky is
        masked, and visits to cells that are not masked are clear. Surveys with the same fields, dithers and seed may
        use one mask, because their fields are the same in each night.

        Parameters
        ----------
        survey : rubin_scheduler survey
            Survey with `fields` and `hp2fields`, such as `GreedySurvey`, that rotates its fields once per night or
            never.

        Raises
        ------
        ValueError
            The survey has no such fields, or it rotates them at each call, after the mask was evaluated.
        """
        if getattr(survey, "fields", None) is None or np.shape(getattr(survey, "hp2fields", ())) != (CELLS,):
            raise ValueError(f"{type(survey).__name__} has no fields for the cells of nside {NSIDE}; allowed: a survey with fields and hp2fields")
        if getattr(survey, "dither", None) == "call":
            raise ValueError("the survey has dither='call' and rotates its fields after the mask is evaluated; allowed: dither='night' or none")
        self._survey, self._rotated_fields = survey, None

    def _fields(self, night: int) -> tuple[Any, Any]:
        """Returns the fields of the survey in a night, and the field index of each cell."""
        survey = self._survey
        if getattr(survey, "dither", None) != "night" or np.max(survey.night) == night:
            return survey.fields, survey.hp2fields
        if self._rotated_fields is None or self._rotated_fields[0] != night:
            # The survey rotates its fields when it is first chosen in a night, which is after the mask was evaluated.
            tonight = copy.copy(survey)
            tonight.fields = survey.fields_init.copy()
            tonight._spin_fields(night)
            self._rotated_fields = (night, tonight.fields, tonight.hp2fields)
        return self._rotated_fields[1:]

    def _pointings(self, night: int) -> Pointings:
        """Returns the pointings of visits to the cells in a night."""
        # Largest distance of a satellite from the centre of its cell, plus half of its motion in one step.
        more_deg = FASTEST_STEP_DEG / 2.0 + CELL_REACH_DEG
        if self._survey is None:
            return cells_as_pointings(NSIDE, self.radius_deg + self.pad_deg, more_deg)
        # The arrays are part of the cache key, so that copies of a scheduler use the same result.
        fields, of_cells = self._fields(night)
        coordinates = (np.ascontiguousarray(fields[one], dtype=float).tobytes() for one in ("RA", "dec"))
        of_cell = np.ascontiguousarray(of_cells, dtype=np.int64).tobytes()
        return fields_as_pointings(NSIDE, *coordinates, of_cell, self.radius_deg + FIELD_PAD_DEG, more_deg)

    def _map_of(self, model: StreakModel, conditions: Any) -> FloatArray:
        now = float(np.max(conditions.mjd))
        check_conditions(self.hook, conditions, self.mjd_scale)
        slew_s = np.broadcast_to(np.asarray(conditions.slewtime, dtype=float), (CELLS,))
        reached = np.isfinite(slew_s)
        mask = np.zeros(CELLS)
        if not reached.any():
            return mask
        opens, closes = slew_s[reached] - self.jitter_s, slew_s[reached] + self.exptime_s + self.jitter_s
        pointings = self._pointings(int(np.max(conditions.night)))
        of_cell, n, lost = pointings.of_cell[reached], len(pointings.centres), np.zeros(opens.size)
        sky, limit = self._sky_of(model), limit_of(self.limit_mag, self._band(conditions))
        # Steps within the window, and half a step on both sides to include the track between samples.
        now_s = now * 86_400.0
        first = np.ceil((now_s + opens) / SAMPLE_S - 0.5).astype(np.int64)
        end = np.maximum(np.floor((now_s + closes) / SAMPLE_S + 1.5).astype(np.int64), first)
        for number, samples in sky.over(now + opens.min() / 86_400.0, now + closes.max() / 86_400.0):
            # The losses per step are the same for all visits; only the steps of the window differ.
            cumulative = self._cache.get((sky, limit, pointings), number)
            if cumulative is None:
                cumulative = self._cache.put(number, self._losses(sky.probably_brighter(limit, samples), pointings))
            since, until = (np.minimum(np.maximum(step - number * STEPS, 0), STEPS) for step in (first, end))
            lost += cumulative.take(until * n + of_cell) - cumulative.take(since * n + of_cell)
        loss = np.zeros(CELLS)
        loss[reached] = lost
        masked = loss > 0.0
        if np.count_nonzero(masked) > int(self.max_share * np.count_nonzero(reached)):
            self.counts["capped"] += 1
            masked = _cells_to_mask(loss, reached, self.max_share)
        self.counts["masked"] += int(np.count_nonzero(masked))
        mask[masked] = np.nan
        return mask

    def _losses(self, samples: Samples, pointings: Pointings) -> FloatArray:
        """Returns the cumulative loss at each pointing before each step of a slot: ``(n_steps + 1, n_pointings)``."""
        n = len(pointings.centres)
        nearby = pointings.near[hp.vec2pix(NSIDE, *samples.direction.T)]
        cosine = (pointings.centres[nearby] @ samples.direction.astype(np.float32)[:, :, None])[..., 0]
        # Closest approach between the samples: d² ≤ r² + (step / 2)²
        reach = np.sqrt(np.radians(pointings.radius_deg) ** 2 + np.radians(samples.rate_deg_s * SAMPLE_S / 2.0) ** 2)
        row, column = np.nonzero((cosine >= np.cos(np.minimum(reach, np.pi))[:, None]) & (nearby >= 0))
        lost = loss_of(samples, SAMPLE_S, self.area_deg2, self.damage == "light")
        # Without a telescope all satellites have the same small loss.
        lost = np.where(lost > 0.0, lost, 1e-12)
        cell = (np.rint(samples.second / SAMPLE_S).astype(np.int64)[row] + 1) * n + nearby[row, column]
        lost_at = np.bincount(cell, weights=lost[row], minlength=(STEPS + 1) * n)
        cumulative: FloatArray = np.asarray(lost_at, dtype=float).reshape(STEPS + 1, n)
        for step in range(STEPS):
            cumulative[step + 1] += cumulative[step]
        return cumulative


def _cells_to_mask(loss: FloatArray, reached: BoolArray, max_share: float) -> BoolArray:
    """Returns which crossed cells are masked, at most a fraction `max_share` of the reached cells.

    In each sector the cells with the smallest loss are not masked, so that these are spread over the sky: the smallest
    loss of the whole sky may be where a survey never points. Cells whose loss is less than `MASK_RATIO` times that of
    the best tenth of their sector are not masked either, because a slew to another cell would gain little.
    """
    cells = np.flatnonzero(reached)
    sector = sectors(NSIDE)[cells]
    order = np.lexsort((loss[cells], sector))
    cells, sector = cells[order], sector[order]
    _, first, of_sector, size = np.unique(sector, return_index=True, return_inverse=True, return_counts=True)
    # Fraction of the sector whose loss is smaller than that of the cell.
    share = (np.arange(cells.size) - first[of_sector] + 0.5) / size[of_sector]
    best_tenth = loss[cells][first + size // 10]
    is_bad = loss[cells] > MASK_RATIO * best_tenth[of_sector]
    cells, share = cells[is_bad], share[is_bad]
    masked = np.zeros(loss.size, dtype=bool)
    masked[cells[np.argsort(share, kind="stable")[::-1][: int(max_share * np.count_nonzero(reached))]]] = True
    return masked
