"""Base class of the two sky maps: options, hook, satellite tracks, and a zero map after errors."""

from __future__ import annotations

from collections import Counter
from typing import Any, Union

import numpy as np
from rubin_scheduler.scheduler.basis_functions import BaseBasisFunction
from streakcast import StreakModel
from streakcast.hosts import Hook

from ._arrays import FloatArray
from ._checks import limits, one_of
from ._verdicts import DAMAGES, limit_values, scale_of
from ._tracks import Sky

NSIDE = 32
CELLS = 12 * NSIDE * NSIDE


class StreakMap(BaseBasisFunction):
    """Basis function with a map of nside 32, RING, which `_map_of` computes.

    The parameters are those of `StreakMaskBasisFunction`.
    """

    def __init__(
        self,
        model: StreakModel,
        *,
        mjd_scale: Union[str, None],
        limit_mag: Any,
        damage: str,
        bandname: Union[str, None],
        watch_s: float,
        nside: int,
    ) -> None:
        super().__init__(nside=nside, bandname=bandname)
        if nside != NSIDE:
            raise ValueError(f"nside is {nside}; allowed: {NSIDE}")
        self.mjd_scale = scale_of(model, mjd_scale)
        self.limit_mag = limits(limit_mag)
        self.damage = one_of("damage", damage, DAMAGES)
        if model.field_radius_deg is None or model.field_area_deg2 is None:
            raise ValueError("the model has no field of view; specify StreakModel(telescope=...) or fov=...")
        self.radius_deg, self.area_deg2 = model.field_radius_deg, model.field_area_deg2
        self.hook = Hook(model, "rubin", watch_s=watch_s)
        self._sky: Union[Sky, None] = None

    @property
    def counts(self) -> Counter[str]:
        """Counts of events."""
        return self.hook.counts

    def __getstate__(self) -> dict[str, Any]:
        # Tracks and the last map (98 kB) are not pickled. They are computed again on first use.
        return {**self.__dict__, "_sky": None, "value": 0, "recalc": True}

    def _calc_value(self, conditions: Any, indx: Any = None, **_: Any) -> FloatArray:
        """Returns the map at the time of the conditions, or zeros after an error."""
        self.value = self.hook.evaluate(lambda model: self._map_of(model, conditions), np.zeros(CELLS))
        self.mjd_last = conditions.mjd + 0
        self.recalc = False
        return self.value

    def _map_of(self, model: StreakModel, conditions: Any) -> FloatArray:
        raise NotImplementedError

    def _sky_of(self, model: StreakModel) -> Sky:
        """Returns the satellite tracks of a model."""
        if self._sky is None or self._sky.model is not model:
            light = self.damage == "light" or self.limit_mag is not None
            self._sky = Sky(model, self.mjd_scale, light=light, limits_mag=limit_values(self.limit_mag))
        return self._sky

    def _band(self, conditions: Any) -> Union[str, None]:
        """Returns the band whose magnitude limit applies."""
        band: Union[str, None] = self.bandname if self.bandname is not None else conditions.current_band
        return band
