"""Exposures within a block."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Union

import numpy as np
import numpy.typing as npt
from astropy import units as u

FloatArray = npt.NDArray[np.float64]

#: Longest exposure accepted by the model, seconds.
LONGEST_S = 86_400.0
#: Largest number of exposures in a block. Larger numbers are caused by wrong units.
MOST_EXPOSURES = 100_000
#: Tolerance for rounding of block lengths, seconds.
ROUNDING_S = 1e-3


@dataclass(frozen=True)
class Exposures:
    """Exposures of a block. All have the same duration and are followed by a readout.

    Parameters
    ----------
    exposure_s : float or None
        Duration of one exposure, seconds; `None` if the block is one continuous exposure.
    readout_s : float
        Time from the closing of the shutter to its next opening, seconds.
    n_exposures : int or None
        Number of exposures in a block; `None` for as many as fit.
    """

    exposure_s: Union[float, None] = None
    readout_s: float = 0.0
    n_exposures: Union[int, None] = None

    def __post_init__(self) -> None:
        if self.exposure_s is None:
            if self.readout_s != 0.0 or self.n_exposures is not None:
                raise ValueError("readout and n_exposures are given without exposure; allowed: only together with exposure")
        elif not 0.0 < self.exposure_s <= LONGEST_S:
            raise ValueError(f"exposure is {self.exposure_s} s; allowed: above 0, at most {LONGEST_S:.0f} s")
        if not 0.0 <= self.readout_s <= LONGEST_S:
            raise ValueError(f"readout is {self.readout_s} s; allowed: 0 to {LONGEST_S:.0f} s")
        count = self.n_exposures
        if count is not None and not (isinstance(count, int) and 1 <= count <= MOST_EXPOSURES):
            raise ValueError(f"n_exposures is {count}; allowed: 1 to {MOST_EXPOSURES}")

    @property
    def step_s(self) -> float:
        """Time from one shutter opening to the next, seconds; 0 if the block is one continuous exposure."""
        return 0.0 if self.exposure_s is None else self.exposure_s + self.readout_s

    def in_block(self, block_s: float) -> tuple[FloatArray, float]:
        """Returns shutter openings after the start of the block, ``(n_exposures,)``, and the duration, in seconds."""
        if self.exposure_s is None:
            return np.zeros(1), block_s
        count = self.n_exposures
        if count is None:
            # n E + (n - 1) R <= B: the last readout may end after the block.
            count = max(1, int((block_s + self.readout_s + ROUNDING_S) / self.step_s))
        return np.arange(count, dtype=np.float64) * self.step_s, self.exposure_s

    def starts_in_cell(self, cell_s: float) -> tuple[FloatArray, float]:
        """Returns shutter openings within a time cell, ``(n,)``, and the duration, in seconds."""
        if self.exposure_s is None:
            return np.zeros(1), cell_s
        count = max(1, int(np.ceil((cell_s - ROUNDING_S) / self.step_s)))
        return np.arange(count, dtype=np.float64) * self.step_s, self.exposure_s


def seconds(value: Any, what: str) -> float:
    """Returns a duration in seconds, from a `~astropy.units.Quantity` or a number of seconds."""
    try:
        number = float(u.Quantity(value, u.s).value)
    except (TypeError, ValueError, u.UnitConversionError) as error:
        raise ValueError(f"{what} is {value!r}: {error}; allowed: a Quantity of time, or a number of seconds") from None
    if not np.isfinite(number):
        raise ValueError(f"{what} is {number}; allowed: a finite time")
    return number
