"""`StreakMaskBasisFunction`: NaN where a visit that begins now would be crossed, for surveys that choose visit by visit."""

from __future__ import annotations

from collections import Counter
from typing import Any, Union

import healpy as hp
import numpy as np
from rubin_scheduler.scheduler.basis_functions import BaseBasisFunction
from streakcast import StreakModel
from streakcast.hosts import Hook

from ._arrays import FloatArray
from ._checks import at_least, limits, one_of
from ._questions import DAMAGES, scale_of
from ._tracks import SAMPLE_S, Sky, brighter_than, centres_of, loss_of, neighbours
from ._warnings import told

NSIDE = 32
#: Half the side of a cell of nside 32, degrees.
HALF_CELL_DEG = 0.92
#: The fastest that crosses a field (340 km, overhead) moves so far between two samples, degrees.
FASTEST_STEP_DEG = 1.3 * SAMPLE_S


class StreakMaskBasisFunction(BaseBasisFunction):
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
        Only satellites brighter than this are dodged, by band as ``{"g": 7, "default": 6}``; without it all that are lit.
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
        super().__init__(nside=nside, bandname=bandname)
        if nside != NSIDE:
            raise ValueError(f"nside is {nside}; allowed: {NSIDE}")
        self.mjd_scale = scale_of(model, mjd_scale)
        self.damage = one_of("damage", damage, DAMAGES)
        self.exptime_s = at_least("exptime_s", exptime_s, 0.0)
        self.jitter_s = at_least("jitter_s", jitter_s, 0.0)
        self.max_share = at_least("max_share", max_share, 0.0, most=1.0)
        self.pad_deg = at_least("pad_deg", pad_deg, 0.0)
        self.limit_mag = limits(limit_mag)
        if model.field_radius_deg is None or model.field_area_deg2 is None:
            raise ValueError("the model has no field of view: give it telescope= or fov=")
        self.radius_deg, self.area_deg2 = model.field_radius_deg, model.field_area_deg2
        self.hook = Hook(model, "rubin", watch_s=watch_s)
        self._sky: Union[Sky, None] = None

    @property
    def counts(self) -> Counter[str]:
        """How often what happened."""
        return self.hook.counts

    def __getstate__(self) -> dict[str, Any]:
        # Tracks are found again on first use; a map of the last call is not worth 98 kB.
        return {**self.__dict__, "_sky": None, "value": 0, "recalc": True}

    def _calc_value(self, conditions: Any, indx: Any = None, **_: Any) -> FloatArray:
        """The map of now."""
        clear = np.zeros(12 * NSIDE * NSIDE)
        self.value = self.hook.ask(lambda model: self._mask(model, conditions), clear)
        self.mjd_last = conditions.mjd + 0
        self.recalc = False
        return self.value

    def _mask(self, model: StreakModel, conditions: Any) -> FloatArray:
        site = conditions.site
        now = float(np.max(conditions.mjd))
        self.hook.see_site((site.latitude, site.longitude, site.height))
        self.hook.see_clock(now, self.mjd_scale)
        slew_s = np.broadcast_to(np.asarray(conditions.slewtime, dtype=float), (12 * NSIDE * NSIDE,))
        reached = np.isfinite(slew_s)
        answer = np.zeros(slew_s.size)
        if not reached.any():
            return answer
        if self._sky is None or self._sky.model is not model:
            self._sky = Sky(model, self.mjd_scale)
        zenith_deg = (float(np.max(conditions.lmst)) * 15.0 % 360.0, float(site.latitude))
        opens = np.where(reached, slew_s - self.jitter_s, np.inf)
        closes = np.where(reached, slew_s + self.exptime_s + self.jitter_s, -np.inf)
        loss = np.zeros(slew_s.size)
        with told(self.hook):
            slots = self._sky.over(now + opens.min() / 86_400.0, now + closes.max() / 86_400.0, zenith_deg)
        for begun, samples in slots:
            band = self.bandname if self.bandname is not None else conditions.current_band
            samples = brighter_than(self.limit_mag, band, samples)
            if samples.second.size:
                loss += self._losses(samples, (begun - now) * 86_400.0, opens, closes)
        masked = loss > 0.0
        most = int(self.max_share * np.count_nonzero(reached))
        if np.count_nonzero(masked) > most:
            self.counts["capped"] += 1
            worst = np.argsort(loss, kind="stable")[::-1][:most]
            masked = np.zeros(slew_s.size, dtype=bool)
            masked[worst] = True
        self.counts["masked"] += int(np.count_nonzero(masked))
        answer[masked] = np.nan
        return answer

    def _losses(self, samples: Any, ahead_s: float, opens: FloatArray, closes: FloatArray) -> FloatArray:
        """What the satellites of one slot cost the visits of all cells."""
        radius_deg = self.radius_deg + self.pad_deg
        # A cell's own centre may be a diagonal away from a satellite in it, and the satellite half a step from its sample.
        table = neighbours(NSIDE, round(radius_deg + FASTEST_STEP_DEG / 2.0 + 1.5 * HALF_CELL_DEG, 3))
        cells = table[hp.vec2pix(NSIDE, *samples.direction.T)]
        who, column = np.nonzero(cells >= 0)
        cell = cells[who, column]
        when = ahead_s + samples.second[who]
        # Half a step on both sides: the track between the samples counts.
        inside = (when + SAMPLE_S / 2.0 >= opens[cell]) & (when - SAMPLE_S / 2.0 <= closes[cell])
        who, cell = who[inside], cell[inside]
        cosine = np.einsum("ij,ij->i", samples.direction[who], centres_of(NSIDE)[cell])
        half_step = np.radians(samples.rate_deg_s[who] * SAMPLE_S / 2.0)
        # Closest approach between the samples: d² ≤ r² + (step / 2)²
        near = np.arccos(np.clip(cosine, -1.0, 1.0)) ** 2 <= np.radians(radius_deg) ** 2 + half_step**2
        lost = loss_of(samples, SAMPLE_S, self.area_deg2, self.damage == "light")
        # Where no telescope tells a width, every satellite weighs the same.
        lost = np.where(lost > 0.0, lost, 1e-12)
        return np.bincount(cell[near], weights=lost[who[near]], minlength=opens.size).astype(np.float64)
