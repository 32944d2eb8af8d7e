"""`StreakRewardBasisFunction`: where satellites will cost most in the next hour, for surveys that plan that far ahead."""

from __future__ import annotations

import math
from typing import Any, Union

import numpy as np
from streakcast import StreakModel

from ._arrays import FloatArray
from ._checks import at_least
from ._maps import CELLS, NSIDE, StreakMap
from ._questions import limit_of, see
from ._tracks import SAMPLE_S, Samples, brighter_than, centres_of, loss_of

#: Cells that are smoothed at once: two rings, so that only what stands in their band of declination is looked at.
ROWS = 256


class StreakRewardBasisFunction(StreakMap):
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
        Only satellites brighter than this count, by band as ``{"g": 7, "default": 6}``; without it, and in bands that it does not
        name, all that are lit.
    damage : {"light", "pixels"}
        Pixels weighed with the satellites' light (1 at 7 mag, 2.5 times as much a magnitude), or alone.
    look_ahead_min : float
        How far ahead, minutes; 720 at most.
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
        super().__init__(
            model, mjd_scale=mjd_scale, limit_mag=limit_mag, damage=damage, bandname=bandname, watch_s=watch_s, nside=nside
        )
        # What was observed changes nothing.
        self.update_on_newobs = False
        self.look_ahead_min = at_least("look_ahead_min", look_ahead_min, 0.1, most=720.0)
        self.samples = int(at_least("samples", samples, 1, most=1000))
        self.smoothing_deg = at_least("smoothing_deg", smoothing_deg, 2.0, most=90.0)
        self.exptime_s = at_least("exptime_s", exptime_s, 0.1, most=3600.0)
        self.pixel_scale_arcsec = at_least("pixel_scale_arcsec", pixel_scale_arcsec, 1e-3)
        self.cache_s = at_least("cache_s", cache_s, 0.0)
        self._made: Union[tuple[float, Any, FloatArray], None] = None

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_made": None}

    def _map_of(self, model: StreakModel, conditions: Any) -> FloatArray:
        now = float(np.max(conditions.mjd))
        # Limits go by band, so does the map.
        limit = limit_of(self.limit_mag, self._band(conditions))
        key = (model.key(), limit)
        made = self._made
        if made is not None and made[1] == key and 0.0 <= (now - made[0]) * 86_400.0 <= self.cache_s:
            return made[2]
        see(self.hook, conditions, self.mjd_scale)
        ahead_h = np.linspace(0.0, self.look_ahead_min / 60.0, self.samples)
        sky = self._sky_of(model)
        seen = [sky.ask(now + later_h / 24.0, SAMPLE_S) for later_h in ahead_h]
        value = -self._lost_mpx([brighter_than(limit, one) for one in seen])
        self._made = (now, key, value)
        self.counts["made"] += 1
        return value

    def _lost_mpx(self, seen: list[Samples]) -> FloatArray:
        """Pixels expected lost in a visit to each cell, millions."""
        direction = np.concatenate([one.direction for one in seen])
        # Share of a field, were all of the streak in it.
        share = np.concatenate([loss_of(one, self.exptime_s, self.area_deg2, self.damage == "light") for one in seen])
        smoothing = math.radians(self.smoothing_deg)
        reach = math.cos(smoothing)
        declination, height = (np.arcsin(np.clip(one[:, 2], -1.0, 1.0)) for one in (direction, centres_of(NSIDE)))
        lost = np.zeros(CELLS)
        for first in range(0, CELLS, ROWS):
            rows = slice(first, first + ROWS)
            # RING: from north to south.
            band = (declination <= height[first] + smoothing) & (declination >= height[rows][-1] - smoothing)
            lost[rows] = (centres_of(NSIDE)[rows] @ direction[band].T > reach) @ share[band]
        # In the disc stand Σ; a field of area A has A / (π s²) of them, and of each streak what lies in it.
        disc_deg2 = 2.0 * np.pi * (1.0 - reach) * np.degrees(1.0) ** 2
        pixels = self.area_deg2 * (3600.0 / self.pixel_scale_arcsec) ** 2
        return np.asarray(lost * self.area_deg2 / disc_deg2 / len(seen) * pixels / 1e6, dtype=float)
