"""`StreakRewardBasisFunction`: expected loss to satellites in the next hour, for surveys that plan ahead."""

from __future__ import annotations

import math
from typing import Any, Union

import numpy as np
from streakcast import StreakModel

from ._arrays import FloatArray
from ._checks import at_least
from ._maps import CELLS, NSIDE, StreakMap
from ._verdicts import limit_of, check_conditions
from ._tracks import SAMPLE_S, Samples, centres_of, loss_of

#: Number of cells that are smoothed together: two rings, so that only satellites at their declinations are used.
ROWS = 256


class StreakRewardBasisFunction(StreakMap):
    """Expected pixel loss of a visit with a minus sign, as a map of nside 32, RING.

    Which satellites will cross a visit in forty minutes is unknown, because its start is unknown, but number,
    brightness and speed of the satellites in each part of the sky are known. Satellites are sampled `samples` times
    over the next `look_ahead_min`, and spread over discs of radius `smoothing_deg`:

        reward = - N_pix Σ_satellites ω t w / (π s²) / n_samples

    where ω t w is the area of each streak, s the radius of the discs, and N_pix the number of pixels. The unit is a
    million pixels per visit; each satellite may be weighted by its brightness. The map is cached for `cache_s`.

    Parameters
    ----------
    model : StreakModel
        Site, satellites and field, with a telescope.
    mjd_scale : {"utc", "tai", "tt"}, optional
        Scale of the scheduler's MJD. It must be given here or in the model.
    limit_mag : float or dict, optional
        Each satellite is weighted with the probability of being brighter than this; by band as ``{"g": 7, "default":
        6}``. Without it, and in bands without a limit, all lit satellites have weight 1.
    damage : {"light", "pixels"}
        Lost pixels weighted by brightness (1 at 7 mag, a factor of 2.5 per magnitude), or not weighted.
    look_ahead_min : float
        Length of the time span, minutes; at most 720.
    samples : int
        Number of samples in that time.
    smoothing_deg : float
        Radius of the discs, degrees.
    exptime_s : float
        Duration of the visits, seconds.
    pixel_scale_arcsec : float
        Side of a pixel.
    cache_s : float
        Time for which a map is cached, seconds.
    bandname : str, optional
        Band of the survey, for limits by band; default: the current band.
    watch_s : float
        Interval between checks of the model's files for new element sets, seconds.
    nside : int
        Must be 32.

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
        # The map does not depend on completed visits.
        self.update_on_newobs = False
        self.look_ahead_min = at_least("look_ahead_min", look_ahead_min, 0.1, most=720.0)
        self.samples = int(at_least("samples", samples, 1, most=1000))
        self.smoothing_deg = at_least("smoothing_deg", smoothing_deg, 2.0, most=90.0)
        self.exptime_s = at_least("exptime_s", exptime_s, 0.1, most=3600.0)
        self.pixel_scale_arcsec = at_least("pixel_scale_arcsec", pixel_scale_arcsec, 1e-3)
        self.cache_s = at_least("cache_s", cache_s, 0.0)
        self._cached: Union[tuple[float, Any, FloatArray], None] = None

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_cached": None}

    def _map_of(self, model: StreakModel, conditions: Any) -> FloatArray:
        now = float(np.max(conditions.mjd))
        # The map depends on the magnitude limit of the band.
        limit = limit_of(self.limit_mag, self._band(conditions))
        key = (model.key(), limit)
        cached = self._cached
        if cached is not None and cached[1] == key and 0.0 <= (now - cached[0]) * 86_400.0 <= self.cache_s:
            return cached[2]
        check_conditions(self.hook, conditions, self.mjd_scale)
        ahead_h = np.linspace(0.0, self.look_ahead_min / 60.0, self.samples)
        sky = self._sky_of(model)
        samples = [sky.sample(now + later_h / 24.0, SAMPLE_S) for later_h in ahead_h]
        value = -self._lost_mpx(samples, [sky.probability_brighter(limit, one) for one in samples])
        self._cached = (now, key, value)
        self.counts["made"] += 1
        return value

    def _lost_mpx(self, samples: list[Samples], counts: list[FloatArray]) -> FloatArray:
        """Returns the expected pixel loss of a visit to each cell, millions, weighted by probabilities."""
        direction = np.concatenate([one.direction for one in samples])
        # Lost fraction of a field that contains the whole streak.
        weighted = self.damage == "light"
        share = np.concatenate(
            [loss_of(one, self.exptime_s, self.area_deg2, weighted) * p for one, p in zip(samples, counts)]
        )
        smoothing = math.radians(self.smoothing_deg)
        reach = math.cos(smoothing)
        declination, height = (np.arcsin(np.clip(one[:, 2], -1.0, 1.0)) for one in (direction, centres_of(NSIDE)))
        lost = np.zeros(CELLS)
        for first in range(0, CELLS, ROWS):
            rows = slice(first, first + ROWS)
            # RING cells are ordered from north to south.
            band = (declination <= height[first] + smoothing) & (declination >= height[rows][-1] - smoothing)
            lost[rows] = (centres_of(NSIDE)[rows] @ direction[band].T > reach) @ share[band]
        # A disc contains the sum; a field of area A contains the fraction A / (π s²) of it.
        disc_deg2 = 2.0 * np.pi * (1.0 - reach) * np.degrees(1.0) ** 2
        pixels = self.area_deg2 * (3600.0 / self.pixel_scale_arcsec) ** 2
        return np.asarray(lost * self.area_deg2 / disc_deg2 / len(samples) * pixels / 1e6, dtype=float)
