"""Which exposures a block holds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Union

import numpy as np
import numpy.typing as npt
from astropy import units as u

FloatArray = npt.NDArray[np.float64]

#: The longest exposure that a model is asked about, seconds.
LONGEST_S = 86_400.0
#: Exposures of one block; more are a slip of units.
MOST_EXPOSURES = 100_000
#: Blocks are laid to the second; what is shorter than this is rounding.
ROUNDING_S = 1e-3


@dataclass(frozen=True)
class Exposures:
    """What a block consists of: exposures of one length, each followed by a readout.

    Parameters
    ----------
    exposure_s : float or None
        Length of one exposure, seconds; `None` where a block is exposed throughout.
    readout_s : float
        From the closing of the shutter to its next opening, seconds.
    n_exposures : int or None
        How many a block holds; `None` for as many as fit.
    """

    exposure_s: Union[float, None] = None
    readout_s: float = 0.0
    n_exposures: Union[int, None] = None

    def __post_init__(self) -> None:
        if self.exposure_s is None:
            if self.readout_s != 0.0 or self.n_exposures is not None:
                raise ValueError("readout and n_exposures are given without exposure; allowed: all, or exposure alone")
        elif not 0.0 < self.exposure_s <= LONGEST_S:
            raise ValueError(f"exposure is {self.exposure_s} s; allowed: above 0, at most {LONGEST_S:.0f} s")
        if not 0.0 <= self.readout_s <= LONGEST_S:
            raise ValueError(f"readout is {self.readout_s} s; allowed: 0 to {LONGEST_S:.0f} s")
        count = self.n_exposures
        if count is not None and not (isinstance(count, int) and 1 <= count <= MOST_EXPOSURES):
            raise ValueError(f"n_exposures is {count}; allowed: 1 to {MOST_EXPOSURES}")

    @property
    def step_s(self) -> float:
        """From one opening of the shutter to the next, seconds; 0 where a block is exposed throughout."""
        return 0.0 if self.exposure_s is None else self.exposure_s + self.readout_s

    def in_block(self, block_s: float) -> tuple[FloatArray, float]:
        """Openings of the shutter after the block's beginning, and how long it stays open: ``(n_exposures,)``, seconds."""
        if self.exposure_s is None:
            return np.zeros(1), block_s
        count = self.n_exposures
        if count is None:
            # n E + (n - 1) R <= B: the last readout may fall into what comes after.
            count = max(1, int((block_s + self.readout_s + ROUNDING_S) / self.step_s))
        return np.arange(count, dtype=np.float64) * self.step_s, self.exposure_s

    def begun_in(self, cell_s: float) -> tuple[FloatArray, float]:
        """Openings of the shutter from the beginning of a cell of time until before its end: ``(n,)``, seconds."""
        if self.exposure_s is None:
            return np.zeros(1), cell_s
        count = max(1, int(np.ceil((cell_s - ROUNDING_S) / self.step_s)))
        return np.arange(count, dtype=np.float64) * self.step_s, self.exposure_s


def seconds(value: Any, what: str) -> float:
    """One length of time: a `~astropy.units.Quantity`, or a number of seconds."""
    try:
        number = float(u.Quantity(value, u.s).value)
    except (TypeError, ValueError, u.UnitConversionError) as error:
        raise ValueError(f"{what} is {value!r}: {error}; allowed: a Quantity of time, or a number of seconds") from None
    if not np.isfinite(number):
        raise ValueError(f"{what} is {number}; allowed: a finite time")
    return number
