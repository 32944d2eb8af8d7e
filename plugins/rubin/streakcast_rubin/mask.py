"""`StreakMaskBasisFunction`: NaN where a visit that begins now would be crossed, for surveys that choose visit by visit."""

from __future__ import annotations

from typing import Any, Union

import healpy as hp
import numpy as np
from streakcast import StreakModel

from ._arrays import FloatArray
from ._checks import above, at_least
from ._maps import CELLS, NSIDE, StreakMap
from ._questions import limit_of, see
from ._tracks import SAMPLE_S, SLOT_S, Kept, Samples, brighter_than, centres_of, loss_of, neighbours

#: Half the side of a cell of nside 32, degrees.
HALF_CELL_DEG = 0.92
#: The fastest that crosses a field (340 km, overhead) moves so far between two samples, degrees.
FASTEST_STEP_DEG = 1.3 * SAMPLE_S
#: Seconds after a slot's beginning at which satellites are looked at.
STEPS_S = np.arange(0.0, SLOT_S, SAMPLE_S)


class StreakMaskBasisFunction(StreakMap):
    """A mask over the sky, nside 32, RING: NaN where satellites would cross, 0 elsewhere. Weight 0.

    For each cell the window is that of a visit which begins now: slew (the map of the conditions), exposure, and `jitter_s` on both
    sides. A cell is masked where a lit satellite comes closer to its centre than the field's radius and half a cell. Where more than
    `max_share` of the cells that the telescope can reach would be masked, only those that would lose most are.

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
        How much further than the field's radius from a cell's centre is looked, degrees.
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
        max_share: float = 0.5,
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

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_kept": Kept()}

    def _map_of(self, model: StreakModel, conditions: Any) -> FloatArray:
        now = float(np.max(conditions.mjd))
        see(self.hook, conditions, self.mjd_scale)
        slew_s = np.broadcast_to(np.asarray(conditions.slewtime, dtype=float), (CELLS,))
        reached = np.isfinite(slew_s)
        answer = np.zeros(CELLS)
        if not reached.any():
            return answer
        zenith_deg = (float(np.max(conditions.lmst)) * 15.0 % 360.0, float(conditions.site.latitude))
        opens = np.where(reached, slew_s - self.jitter_s, np.inf)
        closes = np.where(reached, slew_s + self.exptime_s + self.jitter_s, -np.inf)
        loss = np.zeros(CELLS)
        sky, limit = self._sky_of(model), limit_of(self.limit_mag, self._band(conditions))
        for number, samples in sky.over(now + opens.min() / 86_400.0, now + closes.max() / 86_400.0, zenith_deg):
            # What is lost where and when is the same for every visit; only its window moves on.
            by_step = self._kept.get((sky, limit), number)
            if by_step is None:
                by_step = self._kept.put(number, self._losses(brighter_than(limit, samples)))
            when = STEPS_S + (number * SLOT_S / 86_400.0 - now) * 86_400.0
            # Half a step on both sides: the track between the samples counts.
            inside = (when[:, None] + SAMPLE_S / 2.0 >= opens) & (when[:, None] - SAMPLE_S / 2.0 <= closes)
            loss += np.einsum("ij,ij->j", by_step, inside)
        masked = loss > 0.0
        most = int(self.max_share * np.count_nonzero(reached))
        if np.count_nonzero(masked) > most:
            self.counts["capped"] += 1
            worst = np.argsort(loss, kind="stable")[::-1][:most]
            masked = np.zeros(CELLS, dtype=bool)
            masked[worst] = True
        self.counts["masked"] += int(np.count_nonzero(masked))
        answer[masked] = np.nan
        return answer

    def _losses(self, samples: Samples) -> FloatArray:
        """What the satellites of one slot cost a visit to each cell at each of its steps: ``(n_steps, n_cells)``."""
        if samples.second.size == 0:
            return np.zeros((STEPS_S.size, CELLS))
        radius_deg = self.radius_deg + self.pad_deg
        # A cell's own centre may be a diagonal away from a satellite in it, and the satellite half a step from its sample.
        table = neighbours(NSIDE, round(radius_deg + FASTEST_STEP_DEG / 2.0 + 1.5 * HALF_CELL_DEG, 3))
        cells = table[hp.vec2pix(NSIDE, *samples.direction.T)]
        who, column = np.nonzero(cells >= 0)
        cell = cells[who, column]
        cosine = np.einsum("ij,ij->i", samples.direction[who], centres_of(NSIDE)[cell])
        # Closest approach between the samples: d² ≤ r² + (step / 2)²
        reach = np.sqrt(np.radians(radius_deg) ** 2 + np.radians(samples.rate_deg_s * SAMPLE_S / 2.0) ** 2)
        near = cosine >= np.cos(np.minimum(reach, np.pi))[who]
        lost = loss_of(samples, SAMPLE_S, self.area_deg2, self.damage == "light")
        # Where no telescope tells a width, every satellite weighs the same.
        lost = np.where(lost > 0.0, lost, 1e-12)
        who, cell = who[near], cell[near]
        place = np.rint(samples.second / SAMPLE_S).astype(np.int64)[who] * CELLS + cell
        summed = np.bincount(place, weights=lost[who], minlength=STEPS_S.size * CELLS)
        return np.asarray(summed.reshape(STEPS_S.size, CELLS), dtype=float)
