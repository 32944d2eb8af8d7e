"""`StreakMaskBasisFunction`: NaN where a visit that begins now would be crossed, for surveys that choose visit by visit."""

from __future__ import annotations

import copy
from typing import Any, Union

import healpy as hp
import numpy as np
from streakcast import StreakModel

from ._arrays import BoolArray, FloatArray
from ._checks import above, at_least
from ._maps import CELLS, NSIDE, StreakMap
from ._questions import limit_of, see
from ._tracks import SAMPLE_S, SLOT_S, Kept, Pointings, Samples, brighter_than, cells_as_pointings, fields_as_pointings, loss_of, sectors

#: Half the side of a cell of nside 32, degrees.
HALF_CELL_DEG = 0.92
#: Nothing in a cell is farther from its middle, degrees.
CELL_REACH_DEG = float(hp.max_pixrad(NSIDE, degrees=True))
#: The fastest that crosses a field (340 km, overhead) moves so far between two samples, degrees.
FASTEST_STEP_DEG = 1.3 * SAMPLE_S
#: How much further than the field's radius from a field's own centre is looked, degrees: tracks are good to some arcminutes.
FIELD_PAD_DEG = 0.1
#: Where all of a part of the sky is crossed, cells are masked that lose so many times as much as its best tenth.
WORTH = 2.0
#: How often satellites are looked at in a slot.
STEPS = int(SLOT_S / SAMPLE_S)


class StreakMaskBasisFunction(StreakMap):
    """A mask over the sky, nside 32, RING: NaN where satellites would cross, 0 elsewhere. Weight 0.

    For each cell the window is that of a visit which begins now: slew (the map of the conditions), exposure, and `jitter_s` on both
    sides. A cell is masked where a lit satellite comes closer to its centre than the field's radius and half a cell; after `follow`,
    where one crosses the field of the survey that a visit to the cell goes to. Where more than `max_share` of the cells that the
    telescope can reach would be masked, those are left open that lose least, in every part of the sky some, and all that lose less than twice
    as much as the best tenth of their part.

    Parameters
    ----------
    model : StreakModel
        Site, satellites and field, with a telescope.
    mjd_scale : {"utc", "tai", "tt"}, optional
        Scale of the host's MJD. Must be said here or in the model.
    limit_mag : float or dict, optional
        Only satellites brighter than this are dodged, by band as ``{"g": 7, "default": 6}``; without it, and in bands that it does not
        name, all that are lit.
    damage : {"light", "pixels"}
        By what the worst cells are found: pixels lost weighed with each satellite's light, or alone.
    exptime_s : float
        Length of the visits, shutter included, seconds.
    jitter_s : float
        How much earlier or later than computed the shutter may open, seconds.
    max_share : float
        The largest share of the reachable sky that is masked, (0, 1].
    pad_deg : float
        How much further than the field's radius from a cell's centre is looked, degrees; not from a field's, after `follow`.
    bandname : str, optional
        Band of the survey, for limits by band; the band that is in where left out.
    watch_s : float
        How often the files of the model are looked at for new elements, seconds.
    nside : int
        32; there is no other.

    Attributes
    ----------
    counts : collections.Counter
        ``asked``, ``masked`` (cells), ``capped`` (maps), ``failed`` and what `streakcast.hosts.Hook` counts. A map that fails masks
        nothing.

    Raises
    ------
    ValueError
        A scale that nobody said, a model without field or telescope, an option that is out of range.
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
        self._kept: Kept[FloatArray] = Kept()
        self._survey: Any = None
        #: Tonight's fields of the survey, and which of them a visit to each cell goes to, where it has not turned them itself.
        self._turned: Union[tuple[int, Any, Any], None] = None

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_kept": Kept(), "_turned": None}

    def follow(self, survey: Any) -> None:
        """Looks at the fields of a survey, to which a visit to a cell really goes, in place of the cells.

        A field's centre may be 2 deg from the cell that was chosen. Known, it needs no margin: less sky is masked, and what is left open
        is clear. Surveys with the same fields, dithers and seed can share one mask: each stands tonight where the others do.

        Parameters
        ----------
        survey : rubin_scheduler survey
            One with `fields` and `hp2fields`, like `GreedySurvey`, that turns them once a night or never.

        Raises
        ------
        ValueError
            A survey without such fields, or one that turns them at each call, later than it asks for the mask.
        """
        if getattr(survey, "fields", None) is None or np.shape(getattr(survey, "hp2fields", ())) != (CELLS,):
            raise ValueError(f"{type(survey).__name__} has no fields for the cells of nside {NSIDE}")
        if getattr(survey, "dither", None) == "call":
            raise ValueError("the survey turns its fields at each call (dither='call'), after it has asked for the mask")
        self._survey, self._turned = survey, None

    def _fields(self, night: int) -> tuple[Any, Any]:
        """The survey's fields as they stand in a night, and which of them a visit to each cell goes to."""
        survey = self._survey
        if getattr(survey, "dither", None) != "night" or np.max(survey.night) == night:
            return survey.fields, survey.hp2fields
        if self._turned is None or self._turned[0] != night:
            # The host turns a survey's fields when it is first chosen in a night, after it has asked for the mask.
            tonight = copy.copy(survey)
            tonight.fields = survey.fields_init.copy()
            tonight._spin_fields(night)
            self._turned = (night, tonight.fields, tonight.hp2fields)
        return self._turned[1:]

    def _pointings(self, night: int) -> Pointings:
        """Where visits to the cells would point in a night."""
        # A satellite may be as far from the middle of its cell, and half a step from its sample.
        more_deg = FASTEST_STEP_DEG / 2.0 + CELL_REACH_DEG
        if self._survey is None:
            return cells_as_pointings(NSIDE, self.radius_deg + self.pad_deg, more_deg)
        # By what they hold: copies of a scheduler share what is found here.
        fields, of_cells = self._fields(night)
        places = (np.ascontiguousarray(fields[one], dtype=float).tobytes() for one in ("RA", "dec"))
        of_cell = np.ascontiguousarray(of_cells, dtype=np.int64).tobytes()
        return fields_as_pointings(NSIDE, *places, of_cell, self.radius_deg + FIELD_PAD_DEG, more_deg)

    def _map_of(self, model: StreakModel, conditions: Any) -> FloatArray:
        now = float(np.max(conditions.mjd))
        see(self.hook, conditions, self.mjd_scale)
        slew_s = np.broadcast_to(np.asarray(conditions.slewtime, dtype=float), (CELLS,))
        reached = np.isfinite(slew_s)
        answer = np.zeros(CELLS)
        if not reached.any():
            return answer
        opens, closes = slew_s[reached] - self.jitter_s, slew_s[reached] + self.exptime_s + self.jitter_s
        pointings = self._pointings(int(np.max(conditions.night)))
        of_cell, n, lost = pointings.of_cell[reached], len(pointings.centres), np.zeros(opens.size)
        sky, limit = self._sky_of(model), limit_of(self.limit_mag, self._band(conditions))
        # Steps within the window, and half a step on both sides: the track between the samples counts.
        now_s = now * 86_400.0
        first = np.ceil((now_s + opens) / SAMPLE_S - 0.5).astype(np.int64)
        end = np.maximum(np.floor((now_s + closes) / SAMPLE_S + 1.5).astype(np.int64), first)
        for number, samples in sky.over(now + opens.min() / 86_400.0, now + closes.max() / 86_400.0):
            # What is lost where and when is the same for every visit; only its window moves on.
            before = self._kept.get((sky, limit, pointings), number)
            if before is None:
                before = self._kept.put(number, self._losses(brighter_than(limit, samples), pointings))
            since, until = (np.minimum(np.maximum(step - number * STEPS, 0), STEPS) for step in (first, end))
            lost += before.take(until * n + of_cell) - before.take(since * n + of_cell)
        loss = np.zeros(CELLS)
        loss[reached] = lost
        masked = loss > 0.0
        if np.count_nonzero(masked) > int(self.max_share * np.count_nonzero(reached)):
            self.counts["capped"] += 1
            masked = _worst(loss, reached, self.max_share)
        self.counts["masked"] += int(np.count_nonzero(masked))
        answer[masked] = np.nan
        return answer

    def _losses(self, samples: Samples, pointings: Pointings) -> FloatArray:
        """What the satellites of one slot cost a visit to each pointing before each of its steps: ``(n_steps + 1, n_pointings)``."""
        n = len(pointings.centres)
        near_by = pointings.near[hp.vec2pix(NSIDE, *samples.direction.T)]
        cosine = (pointings.centres[near_by] @ samples.direction.astype(np.float32)[:, :, None])[..., 0]
        # Closest approach between the samples: d² ≤ r² + (step / 2)²
        reach = np.sqrt(np.radians(pointings.radius_deg) ** 2 + np.radians(samples.rate_deg_s * SAMPLE_S / 2.0) ** 2)
        who, column = np.nonzero((cosine >= np.cos(np.minimum(reach, np.pi))[:, None]) & (near_by >= 0))
        lost = loss_of(samples, SAMPLE_S, self.area_deg2, self.damage == "light")
        # Where no telescope tells a width, every satellite weighs the same.
        lost = np.where(lost > 0.0, lost, 1e-12)
        place = (np.rint(samples.second / SAMPLE_S).astype(np.int64)[who] + 1) * n + near_by[who, column]
        lost_at = np.bincount(place, weights=lost[who], minlength=(STEPS + 1) * n)
        before: FloatArray = np.asarray(lost_at, dtype=float).reshape(STEPS + 1, n)
        for step in range(STEPS):
            before[step + 1] += before[step]
        return before


def _worst(loss: FloatArray, reached: BoolArray, max_share: float) -> BoolArray:
    """The share of the reached cells that is masked at most, of those that are crossed.

    What stays open is spread over the sky, the least loss of each part of it first: were it the least loss of the whole sky, all of it could
    lie where a survey never points. With it stay those that lose less than `WORTH` times as much as the best tenth of their part of the sky:
    from them a slew gains little.
    """
    cells = np.flatnonzero(reached)
    sector = sectors(NSIDE)[cells]
    order = np.lexsort((loss[cells], sector))
    cells, sector = cells[order], sector[order]
    _, first, of_sector, size = np.unique(sector, return_index=True, return_inverse=True, return_counts=True)
    # How much of its own part of the sky loses less than a cell.
    share = (np.arange(cells.size) - first[of_sector] + 0.5) / size[of_sector]
    best_tenth = loss[cells][first + size // 10]
    worth = loss[cells] > WORTH * best_tenth[of_sector]
    cells, share = cells[worth], share[worth]
    masked = np.zeros(loss.size, dtype=bool)
    masked[cells[np.argsort(share, kind="stable")[::-1][: int(max_share * np.count_nonzero(reached))]]] = True
    return masked
