"""What a block of exposures is worth: the rules that all faces of this package, and other hosts' plugins, share."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from streakcast import StreakModel

from ._answers import FloatArray, clear_on_grid, clear_one_by_one, icrs_deg, lost_on_grid, refuse_without_telescope, times_of, unix_s
from ._exposures import Exposures, seconds

__all__ = ["Exposures", "Rules", "icrs_deg", "seconds", "times_of", "unix_s"]

SCORES = ("clear", "pixels")
BLOCKING = ("any", "avoid")
#: Nobody keeps more than an hour clear on both sides.
LONGEST_MARGIN_S = 3600.0
#: A block may be asked about that is this much shorter than its exposures: schedulers round to seconds.
SHORT_S = 1.0


@dataclass(frozen=True)
class Rules:
    """What is asked of exposures.

    Parameters
    ----------
    exposures : Exposures
        What a block consists of.
    score : {"clear", "pixels"}
        Worth of an exposure: 1 where it is clear, else 0; or the share of its pixels that are left. 0 below the horizon.
    blocking : {"any", "avoid"}
        What keeps it from being clear: every lit satellite, or those that break a limit of magnitude of the model's policy.
    margin_s : float
        Kept clear before the shutter opens and after it closes, seconds.
    """

    exposures: Exposures = field(default_factory=Exposures)
    score: str = "clear"
    blocking: str = "any"
    margin_s: float = 1.0

    def __post_init__(self) -> None:
        one_of("score", self.score, SCORES)
        one_of("blocking", self.blocking, BLOCKING)
        if not 0.0 <= self.margin_s <= LONGEST_MARGIN_S:
            raise ValueError(f"margin is {self.margin_s} s; allowed: 0 to {LONGEST_MARGIN_S:.0f} s")

    def check(self, model: StreakModel) -> None:
        """Says at construction what a model can never answer.

        Raises
        ------
        ValueError
            A model without a field of view; lost pixels without a telescope.
        """
        if model.field_radius_deg is None:
            raise ValueError("the model has no field of view; give StreakModel(fov=...) or telescope=...")
        if self.score == "pixels":
            refuse_without_telescope(model)

    def with_margins(self, starts_s: FloatArray, length_s: float) -> tuple[FloatArray, float]:
        """What is kept clear of exposures: its beginnings, and how long it lasts."""
        return starts_s - self.margin_s, length_s + 2.0 * self.margin_s

    def worth(self, model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, length_s: float) -> FloatArray:
        """Worth of exposures of one length, [0, 1]: ``(n_targets, n_starts)``.

        Parameters
        ----------
        model : StreakModel
            What is asked.
        ra_deg, dec_deg : array, ``(n_targets,)``
            ICRS, degrees.
        starts_s : array, ``(n_starts,)``
            Shutter openings, UTC seconds of 1970, rising.
        length_s : float
            Length of the exposures, seconds.
        """
        early_s, long_s = self.with_margins(starts_s, length_s)
        if self.score == "clear":
            return clear_on_grid(model, ra_deg, dec_deg, early_s, long_s, self.blocking).astype(float)
        return 1.0 - lost_on_grid(model, ra_deg, dec_deg, early_s, long_s)

    def worth_of_each(self, model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, length_s: float) -> FloatArray:
        """The same for exposures each with its own start: ``(n,)``, all arrays ``(n,)``."""
        early_s, long_s = self.with_margins(starts_s, length_s)
        if self.score == "clear":
            return clear_one_by_one(model, ra_deg, dec_deg, early_s, long_s, self.blocking).astype(float)
        ones = [lost_on_grid(model, ra_deg[i : i + 1], dec_deg[i : i + 1], early_s[i : i + 1], long_s) for i in range(len(ra_deg))]
        return 1.0 - np.array([one[0, 0] for one in ones])

    def worth_of_block(self, model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, start_s: float, block_s: float) -> FloatArray:
        """Worth of a block that begins then, the mean over its exposures, [0, 1]: ``(n_targets,)``. 1 only where every one is clear."""
        offsets_s, length_s = self.exposures.in_block(block_s)
        return np.asarray(self.worth(model, ra_deg, dec_deg, start_s + offsets_s, length_s).mean(axis=1))

    def overlong_s(self, block_s: float) -> float:
        """How long the exposures of a block last, seconds, where that is more than the block; 0 where they fit."""
        offsets_s, length_s = self.exposures.in_block(block_s)
        needed_s = float(offsets_s[-1]) + length_s
        return needed_s if needed_s > block_s + SHORT_S else 0.0


def one_of(what: str, value: str, allowed: tuple[str, ...]) -> None:
    """Refuses what is not in a list."""
    if value not in allowed:
        raise ValueError(f"{what} is {value!r}; allowed: {', '.join(allowed)}")
