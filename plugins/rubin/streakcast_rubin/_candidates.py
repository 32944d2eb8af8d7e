"""Candidates for the next visit of a queue, and choice among them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ._arrays import BoolArray, FloatArray, IntArray, Visits

#: Penalty per position in the queue, in seconds of slew: the order of the survey is a short path over the sky.
POSITION_PENALTY_S = 0.3

#: If all visits are crossed, another one is preferred to the first only if its slew is longer by at most this time,
#: seconds, and its damage is at most this fraction, so that long slews are avoided.
CROSSED_EXTRA_SLEW_S = 5.0
CROSSED_DAMAGE_FRACTION = 0.5


class Choice(NamedTuple):
    """Chosen candidate, and reason of the choice."""

    #: Index among the candidates.
    candidate: int
    #: ``clear`` (not crossed), ``due`` (the first visit was deferred the largest number of times) or ``least`` (all are
    #: crossed).
    reason: str


def candidates(queue: Visits, valid: IntArray, look_ahead: int) -> IntArray:
    """Returns the queue indices of the first visits that may be exchanged, in queue order.

    They have the band of the first visit, because a filter exchange takes minutes and the second visits of pairs follow
    it. No visit is moved before an earlier one of the same field, so that pairs and sequences keep their order.
    """
    chosen: list[int] = []
    seen: set[tuple[float, float]] = set()
    rows = queue[valid[: 4 * look_ahead]]
    for index, band, field in zip(valid.tolist(), rows["band"].tolist(), zip(rows["RA"].tolist(), rows["dec"].tolist())):
        if band != rows["band"][0] or len(chosen) == look_ahead:
            break
        if field not in seen:
            chosen.append(index)
        seen.add(field)
    return np.array(chosen, dtype=np.int64)


def choose(
    blocked: BoolArray, damage: FloatArray, slew_s: FloatArray, deferred: IntArray, max_extra_slew_s: float, max_defer: int
) -> Choice:
    """Chooses the next visit among candidates in queue order.

    Parameters
    ----------
    blocked : array of bool, ``(n,)``
        Whether a satellite blocks the visit now.
    damage : array, ``(n,)``
        Damage if the visit is dispatched now.
    slew_s : array, ``(n,)``
        Slew time, seconds; NaN if the telescope cannot reach the visit.
    deferred : array of int, ``(n,)``
        Number of previous deferrals.
    max_extra_slew_s : float
        Largest slew time in excess of that to the first candidate.
    max_defer : int
        Largest number of deferrals of a visit.
    """
    if deferred[0] >= max_defer:
        return Choice(0, "due" if blocked[0] else "clear")
    first_s = slew_s[0] if np.isfinite(slew_s[0]) else np.inf
    reached = np.isfinite(slew_s) & (slew_s <= first_s + max_extra_slew_s)
    reached[0] = True
    clear = reached & ~blocked
    if clear[0]:
        return Choice(0, "clear")
    if clear.any():
        # The nearest visit needs the shortest slew; of equally near visits the first in the queue is used.
        return Choice(int(np.argmin(np.where(clear, slew_s + POSITION_PENALTY_S * np.arange(slew_s.size), np.inf))), "clear")
    worth = reached & (slew_s <= first_s + CROSSED_EXTRA_SLEW_S) & (damage <= CROSSED_DAMAGE_FRACTION * damage[0])
    return Choice(int(np.argmin(np.where(worth, damage, np.inf))) if worth.any() else 0, "least")
