"""What the instants that a host hands over stand for."""

from __future__ import annotations

import enum

import numpy as np

from ._answers import FloatArray
from ._exposures import Exposures

MEANINGS = ("auto", "cell", "exposure", "block")
#: SequentialScheduler's middle is the middle to rounding, seconds.
EVEN_S = 1e-3
#: A step of this many ordinary ones is a gap (a day between two nights), not a cell.
GAP_STEPS = 2.0


class Meaning(enum.Enum):
    """What one time of a host is."""

    #: One of several times of one block: all of them have its answer.
    BLOCK = "block"
    #: The time up to the next one.
    CELL = "cell"
    #: An exposure that begins then, one of a rising grid.
    EXPOSURE = "exposure"
    #: An exposure that begins then; it has nothing to do with the others.
    ALONE = "alone"
    #: Nothing is known but the instant.
    INSTANT = "instant"


def meaning_of(starts_s: FloatArray, targets: tuple[int, ...], exposures: Exposures, each: str) -> Meaning:
    """What times mean to whom asks so.

    Parameters
    ----------
    starts_s : array
        UTC seconds of 1970, in the shape of the host's times.
    targets : tuple of int
        Shape of the targets.
    exposures : Exposures
        What is known of the exposures.
    each : {"auto", "cell", "exposure", "block"}
        What the user says.
    """
    # A grid is one axis of times; targets stand beside it, not along it.
    grid = starts_s.ndim == 1 and len(starts_s) >= 2 and (targets == () or targets[-1] == 1) and bool(np.all(np.diff(starts_s) > 0.0))
    if not grid:
        return Meaning.INSTANT if exposures.exposure_s is None else Meaning.ALONE
    if each == "block" or (each == "auto" and targets == () and _is_block(starts_s)):
        return Meaning.BLOCK
    if each == "exposure" or (each == "auto" and exposures.exposure_s is not None and exposures.n_exposures is None):
        return Meaning.EXPOSURE
    return Meaning.CELL


def _is_block(starts_s: FloatArray) -> bool:
    """Start and end, or start, middle and end."""
    steps_s = np.diff(starts_s)
    return len(steps_s) == 1 or (len(steps_s) == 2 and bool(abs(steps_s[1] - steps_s[0]) < EVEN_S))


def cells_s(starts_s: FloatArray) -> FloatArray:
    """Length of the cell that each time of a rising grid begins, seconds; the last is an ordinary one."""
    steps_s = np.diff(starts_s)
    ordinary_s = float(np.median(steps_s))
    return np.append(np.minimum(steps_s, GAP_STEPS * ordinary_s), ordinary_s)
