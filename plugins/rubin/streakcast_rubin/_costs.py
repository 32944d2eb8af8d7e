"""Cost of streaks of visits of rubin_scheduler."""

from __future__ import annotations

from typing import Any, NamedTuple, Union

import numpy as np
from streakcast import StreakModel, UnknownPositionsError

from ._arrays import FloatArray, IntArray, Visits
from ._checks import limits
from ._mount import Openings
from ._verdicts import pointings

#: Tolerance of the predicted shutter opening, seconds.
JITTER_S = 1.0
NO_TELESCOPE = "the model has no telescope, from which the cost of streaks is computed; specify StreakModel(telescope=...)"


class Costs(NamedTuple):
    """Costs of streaks of visits."""

    #: Expected cost, seconds of open shutter, ``(n,)``; NaN for visits that cannot be judged.
    cost_s: FloatArray
    n_streaks: IntArray
    brightest_mag: FloatArray


def with_costs(model: StreakModel, bright_share: Union[float, None], limit_mag: Any) -> StreakModel:
    """Returns the model with the given share and limit.

    Raises
    ------
    ValueError
        The model has no telescope, or a value is out of range.
    """
    if model.cost_parameters() is None:
        raise ValueError(NO_TELESCOPE)
    changes = {"bright_share": bright_share, "limit_mag": limits(limit_mag)}
    return model.with_options(**{name: value for name, value in changes.items() if value is not None})


def costs_of(model: StreakModel, visits: Visits, openings: Openings, scale: str) -> Costs:
    """Computes the costs of streaks from `JITTER_S` before shutter opening until `JITTER_S` after closing, as costs of
    the exposures.

    Raises
    ------
    UnknownPositionsError
        The elements are too old to predict positions.
    """
    target, rotation, bands = pointings(visits)
    long_s = openings.length_s + 2.0 * JITTER_S
    found = model.assess(target, openings.start_mjd - JITTER_S / 86_400.0, long_s, rotation=rotation, band=bands, scale=scale)
    if (np.asarray(found.verdict) == "unknown").any():
        raise UnknownPositionsError("the elements are too old to predict positions")
    cost_s = np.asarray(found.streak_cost_s, dtype=float) * openings.length_s / long_s
    return Costs(cost_s, np.asarray(found.n_streaks), np.asarray(found.brightest_mag, dtype=float))
