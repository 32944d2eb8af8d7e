"""Ratings of blocks of exposures, used by all interfaces of this package and by plugins for other schedulers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Union

import numpy as np
from streakcast import StreakModel

from ._clear import NO_TELESCOPE, FloatArray, clear_on_grid, clear_one_by_one, cost_on_grid, cost_one_by_one, has_telescope, icrs_deg, times_of, unix_s
from ._exposures import Exposures, seconds

__all__ = ["Exposures", "Rules", "default_score", "icrs_deg", "seconds", "times_of", "unix_s"]

SCORES = ("clear", "cost")
BLOCKING = ("any", "avoid")
#: Longest accepted margin, seconds.
LONGEST_MARGIN_S = 3600.0
#: Tolerance for exposures that are longer than the block, seconds. Schedulers round to seconds.
OVERLONG_TOLERANCE_S = 1.0


@dataclass(frozen=True)
class Rules:
    """Requirements for the exposures of a block.

    Parameters
    ----------
    exposures : Exposures
        Exposures of a block.
    score : {"clear", "cost"}
        Rating of an exposure: 1 if it is clear and 0 otherwise, or 1 less the cost of streaks as a fraction of the
        exposure. 0 below the horizon.
    blocking : {"any", "avoid"}, optional
        Satellites that block an exposure: all lit ones, or those that exceed a magnitude limit of the model's policy.
        Default: that of the policy.
    margin_s : float
        Time that must be clear before the shutter opens and after it closes, seconds. The cost is that of an exposure
        over this time too: an upper limit if the shutter opens earlier or later by up to the margin.
    """

    exposures: Exposures = field(default_factory=Exposures)
    score: str = "clear"
    blocking: Union[str, None] = None
    margin_s: float = 1.0

    def __post_init__(self) -> None:
        one_of("score", self.score, SCORES)
        if self.blocking is not None:
            one_of("blocking", self.blocking, BLOCKING)
        if not 0.0 <= self.margin_s <= LONGEST_MARGIN_S:
            raise ValueError(f"margin is {self.margin_s} s; allowed: 0 to {LONGEST_MARGIN_S:.0f} s")

    def check(self, model: StreakModel) -> None:
        """Checks that the model has the required inputs, so that errors occur at construction.

        Raises
        ------
        ValueError
            If the model has no field of view, or if the score is ``cost`` and the model has no telescope.
        """
        if model.field_radius_deg is None:
            raise ValueError("the model has no field of view; specify StreakModel(fov=...) or telescope=...")
        if self.score == "cost" and not has_telescope(model):
            raise ValueError(NO_TELESCOPE)

    def with_margins(self, starts_s: FloatArray, length_s: float) -> tuple[FloatArray, float]:
        """Returns starts and duration of exposures extended by the margins, seconds."""
        return starts_s - self.margin_s, length_s + 2.0 * self.margin_s

    def worth(self, model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, length_s: float) -> FloatArray:
        """Returns the ratings of exposures of one duration, [0, 1]: ``(n_targets, n_starts)``.

        Parameters
        ----------
        model : StreakModel
            Satellites, site, field of view and limits.
        ra_deg, dec_deg : array, ``(n_targets,)``
            ICRS, degrees.
        starts_s : array, ``(n_starts,)``
            Shutter openings, UTC seconds since 1970, ascending.
        length_s : float
            Duration of the exposures, seconds.
        """
        early_s, long_s = self.with_margins(starts_s, length_s)
        if self.score == "cost":
            return np.asarray(1.0 - cost_on_grid(model, ra_deg, dec_deg, early_s, long_s))
        return clear_on_grid(model, ra_deg, dec_deg, early_s, long_s, self.blocking).astype(float)

    def worth_of_each(self, model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, length_s: float) -> FloatArray:
        """Same as `worth` for single exposures, with one target per start; returns ``(n,)``."""
        early_s, long_s = self.with_margins(starts_s, length_s)
        if self.score == "cost":
            return np.asarray(1.0 - cost_one_by_one(model, ra_deg, dec_deg, early_s, long_s))
        return clear_one_by_one(model, ra_deg, dec_deg, early_s, long_s, self.blocking).astype(float)

    def worth_of_block(self, model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, start_s: float, block_s: float) -> FloatArray:
        """Returns the mean rating of the exposures of a block, [0, 1]: ``(n_targets,)``; 1 only if all are clear."""
        offsets_s, length_s = self.exposures.in_block(block_s)
        return np.asarray(self.worth(model, ra_deg, dec_deg, start_s + offsets_s, length_s).mean(axis=1))

    def overlong_s(self, block_s: float) -> float:
        """Returns the total duration of the exposures, seconds, if it exceeds the block; 0 if they fit."""
        offsets_s, length_s = self.exposures.in_block(block_s)
        needed_s = float(offsets_s[-1]) + length_s
        return needed_s if needed_s > block_s + OVERLONG_TOLERANCE_S else 0.0


def default_score(model: StreakModel) -> str:
    """Returns ``cost`` if the model has a telescope, otherwise ``clear``."""
    return "cost" if has_telescope(model) else "clear"


def one_of(what: str, value: str, allowed: tuple[str, ...]) -> None:
    """Raises ValueError if a value is not one of the allowed values."""
    if value not in allowed:
        raise ValueError(f"{what} is {value!r}; allowed: {', '.join(allowed)}")
