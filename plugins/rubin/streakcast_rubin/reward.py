"""`StreakRewardBasisFunction`: where satellites will cost most in the next hour, for surveys that plan that far ahead."""

from __future__ import annotations

from collections import Counter
from typing import Any, Union

import numpy as np
from rubin_scheduler.scheduler.basis_functions import BaseBasisFunction
from streakcast import StreakModel
from streakcast.hosts import Hook

from ._arrays import FloatArray
from ._checks import at_least, limits, one_of
from ._questions import DAMAGES, scale_of
from ._tracks import SAMPLE_S, Samples, Sky, brighter_than, centres_of, loss_of
from ._warnings import told
from .mask import NSIDE


class StreakRewardBasisFunction(BaseBasisFunction):
    """Minus the pixels that a visit is expected to lose, as a map of nside 32, RING.

    Which satellite crosses which visit in forty minutes nobody knows, for nobody knows when the visit begins. How many there are, how
    bright and how fast in which part of the sky is known: satellites are looked at `samples` times over the next `look_ahead_min`,
    and spread over discs of `smoothing_deg`,

        reward = - N_pix Σ_satellites ω t w / (π s²) / n_samples            with ω t w the area that each streak costs, s the smoothing,

    in millions of pixels a visit, each satellite weighed with its light. The map is kept for `cache_s`.

    Parameters
    ----------
    model : StreakModel
        Site, satellites and field, with a telescope.
    mjd_scale : {"utc", "tai", "tt"}, optional
        Scale of the host's MJD. Must be said here or in the model.
    limit_mag : float or dict, optional
        Only satellites brighter than this count, by band as ``{"g": 7, "default": 6}``.
    damage : {"light", "pixels"}
        Pixels weighed with the satellites' light (1 at 7 mag, 2.5 times as much a magnitude), or alone.
    look_ahead_min : float
        How far ahead, minutes.
    samples : int
        How often the sky is looked at in that time.
    smoothing_deg : float
        Radius of the discs, degrees.
    exptime_s : float
        Length of the visits, seconds.
    pixel_scale_arcsec : float
        Side of a pixel.
    cache_s : float
        How long a map is used, seconds.
    bandname : str, optional
        Band of the survey, for limits by band; the band that is in where left out.
    watch_s : float
        How often the files of the model are looked at for new elements, seconds.
    nside : int
        32; there is no other.

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
        look_ahead_min: float = 45.0,
        samples: int = 10,
        smoothing_deg: float = 10.0,
        exptime_s: float = 30.0,
        pixel_scale_arcsec: float = 0.2,
        cache_s: float = 300.0,
        bandname: Union[str, None] = None,
        watch_s: float = 60.0,
        nside: int = NSIDE,
    ) -> None:
        super().__init__(nside=nside, bandname=bandname)
        # What was observed changes nothing.
        self.update_on_newobs = False
        if nside != NSIDE:
            raise ValueError(f"nside is {nside}; allowed: {NSIDE}")
        self.mjd_scale = scale_of(model, mjd_scale)
        self.limit_mag = limits(limit_mag)
        self.damage = one_of("damage", damage, DAMAGES)
        self.look_ahead_min = at_least("look_ahead_min", look_ahead_min, 0.1)
        self.samples = int(at_least("samples", samples, 1))
        self.smoothing_deg = at_least("smoothing_deg", smoothing_deg, 2.0, most=90.0)
        self.exptime_s = at_least("exptime_s", exptime_s, 0.1)
        self.pixel_scale_arcsec = at_least("pixel_scale_arcsec", pixel_scale_arcsec, 1e-3)
        self.cache_s = at_least("cache_s", cache_s, 0.0)
        area_deg2 = model.field_area_deg2
        if area_deg2 is None:
            raise ValueError("the model has no field of view: give it telescope= or fov=")
        self.area_deg2 = area_deg2
        self.hook = Hook(model, "rubin", watch_s=watch_s)
        self._sky: Union[Sky, None] = None
        self._made: Union[tuple[float, Any, FloatArray], None] = None

    @property
    def counts(self) -> Counter[str]:
        """How often what happened."""
        return self.hook.counts

    def __getstate__(self) -> dict[str, Any]:
        # A map of 98 kB that is made again on first use.
        return {**self.__dict__, "_sky": None, "_made": None, "value": 0, "recalc": True}

    def _calc_value(self, conditions: Any, indx: Any = None, **_: Any) -> FloatArray:
        """The map of the next while; all zero where the question fails."""
        self.value = self.hook.ask(lambda model: self._kept(model, conditions), np.zeros(12 * NSIDE * NSIDE))
        self.mjd_last = conditions.mjd + 0
        self.recalc = False
        return self.value

    def _kept(self, model: StreakModel, conditions: Any) -> FloatArray:
        now = float(np.max(conditions.mjd))
        band = self.bandname if self.bandname is not None else conditions.current_band
        # Limits go by band, so does the map.
        key = (model.key(), band if isinstance(self.limit_mag, dict) else None)
        made = self._made
        if made is not None and made[1] == key and 0.0 <= (now - made[0]) * 86_400.0 <= self.cache_s:
            return made[2]
        site = conditions.site
        self.hook.see_site((site.latitude, site.longitude, site.height))
        self.hook.see_clock(now, self.mjd_scale)
        moments = now + np.linspace(0.0, self.look_ahead_min / 1440.0, self.samples)
        # The sky turns by 15 degrees an hour; the zenith of the middle holds for all.
        zenith_deg = ((float(np.max(conditions.lmst)) + self.look_ahead_min / 120.0) * 15.0 % 360.0, float(site.latitude))
        with told(self.hook):
            if self._sky is None or self._sky.model is not model:
                self._sky = Sky(model, self.mjd_scale)
            seen = self._sky.ask(moments, SAMPLE_S, zenith_deg)
        value = -self._lost_mpx([brighter_than(self.limit_mag, band, one) for one in seen])
        self._made = (now, key, value)
        self.counts["made"] += 1
        return value

    def _lost_mpx(self, seen: list[Samples]) -> FloatArray:
        """Pixels expected lost in a visit to each cell, millions."""
        lost = np.zeros(12 * NSIDE * NSIDE)
        reach = np.cos(np.radians(self.smoothing_deg))
        for samples in seen:
            # Share of a field, were all of the streak in it.
            share = loss_of(samples, self.exptime_s, self.area_deg2, self.damage == "light")
            lost += (centres_of(NSIDE) @ samples.direction.T > reach) @ share
        # In the disc stand Σ; a field of area A has A / (π s²) of them, and of each streak what lies in it.
        disc_deg2 = 2.0 * np.pi * (1.0 - reach) * np.degrees(1.0) ** 2
        pixels = self.area_deg2 * (3600.0 / self.pixel_scale_arcsec) ** 2
        return np.asarray(lost * self.area_deg2 / disc_deg2 / len(seen) * pixels / 1e6, dtype=float)
