"""Meaning of the times that a scheduler passes: blocks, cells or exposures."""

from __future__ import annotations

import enum

import numpy as np

from ._clear import FloatArray
from ._exposures import Exposures

MEANINGS = ("auto", "cell", "exposure", "block")
#: Tolerance for rounding of the middle time of SequentialScheduler, seconds.
MIDDLE_TOLERANCE_S = 1e-3
#: A step longer than this many median steps is a gap (for example the day between two nights) and not a cell.
GAP_STEPS = 2.0


class Meaning(enum.Enum):
    """Meaning of one time passed by a scheduler."""

    #: One of several times of one block, which all have the same result.
    BLOCK = "block"
    #: Interval up to the next time.
    CELL = "cell"
    #: Start of an exposure, on an ascending grid of times.
    EXPOSURE = "exposure"
    #: Start of an exposure that is independent of the other times.
    ALONE = "alone"
    #: Single time without a known duration.
    INSTANT = "instant"


def meaning_of(starts_s: FloatArray, targets: tuple[int, ...], exposures: Exposures, each: str) -> Meaning:
    """Returns the meaning of the times.

    Parameters
    ----------
    starts_s : array
        UTC seconds since 1970, in the shape of the times passed by the scheduler.
    targets : tuple of int
        Shape of the targets.
    exposures : Exposures
        Exposures of a block, as far as known.
    each : {"auto", "cell", "exposure", "block"}
        Setting of the user.
    """
    # A grid has one axis of times, and targets are on the other axis.
    grid = starts_s.ndim == 1 and len(starts_s) >= 2 and (targets == () or targets[-1] == 1) and bool(np.all(np.diff(starts_s) > 0.0))
    if not grid:
        return Meaning.INSTANT if exposures.exposure_s is None else Meaning.ALONE
    if each == "block" or (each == "auto" and targets == () and _is_block(starts_s)):
        return Meaning.BLOCK
    if each == "exposure" or (each == "auto" and exposures.exposure_s is not None and exposures.n_exposures is None):
        return Meaning.EXPOSURE
    return Meaning.CELL


def _is_block(starts_s: FloatArray) -> bool:
    """Returns True for two times (start and end) or three evenly spaced times (start, middle, end) of a block."""
    steps_s = np.diff(starts_s)
    return len(steps_s) == 1 or (len(steps_s) == 2 and bool(abs(steps_s[1] - steps_s[0]) < MIDDLE_TOLERANCE_S))


def cells_s(starts_s: FloatArray) -> FloatArray:
    """Returns the lengths of the cells between ascending times, seconds. The last one is their median."""
    steps_s = np.diff(starts_s)
    median_s = float(np.median(steps_s))
    return np.append(np.minimum(steps_s, GAP_STEPS * median_s), median_s)
