"""Satellite streaks as a constraint for M4OPT."""

from __future__ import annotations

from typing import Any, Union

import numpy as np
import numpy.typing as npt
from streakcast import StreakModel
from streakcast.hosts import Hook

from .constraint import SatelliteStreakConstraint

try:
    from m4opt.constraints import Constraint
except ImportError:
    Constraint = object


class SatelliteStreaks(Constraint):  # type: ignore[misc]
    """Constraint that an exposure which starts at the given time is clear.

    M4OPT combines constraints with ``&``, ``|`` and ``~``.

    Parameters
    ----------
    model : StreakModel or Hook
        Satellites, site, field of view and limits.
    exposure : `~astropy.units.Quantity` or float
        Duration of one exposure; seconds if it has no unit.
    **options
        ``blocking`` and ``margin``, as for `SatelliteStreakConstraint`.
    """

    def __init__(self, model: Union[StreakModel, Hook], exposure: Any, **options: Any) -> None:
        self.constraint = SatelliteStreakConstraint(model, exposure, each="exposure", **options)

    def __call__(self, observer_location: Any, target_coord: Any, obstime: Any) -> npt.NDArray[np.bool_]:
        """Evaluates the constraint. Targets and times are broadcast against each other."""
        self.constraint.hook.check_site(lambda: observer_location[0] if observer_location.shape else observer_location)
        return np.asarray(self.constraint.compute_constraint(obstime, None, target_coord), dtype=bool)
