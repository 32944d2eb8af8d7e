"""Candidates for the next visit of a queue, and the choice among them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ._arrays import BoolArray, FloatArray, IntArray, Visits

#: Penalty per position in the queue, as seconds of slew, because the survey's order is a short path over the sky.
POSITION_PENALTY_S = 0.3

#: A crossed visit is preferred to the first one only if its slew is at most this much longer, seconds, and its damage
#: is at most this fraction, so that the telescope makes no long slews if every visit is crossed.
CROSSED_EXTRA_SLEW_S = 5.0
CROSSED_DAMAGE_FRACTION = 0.5


class Choice(NamedTuple):
    """The chosen candidate and the reason."""

    #: Index among the candidates.
    candidate: int
    #: ``clear`` (not crossed), ``due`` (the first one has reached the maximum number of deferrals) or ``least`` (all
    #: are crossed).
    reason: str


def candidates(queue: Visits, valid: IntArray, look_ahead: int) -> IntArray:
    """Returns the queue indices of the first visits that may be exchanged, in the order of the queue.

    They have the band of the first one (a filter exchange costs minutes, and the second halves of pairs follow it), and
    no visit overtakes an earlier one of the same field, so pairs and sequences keep their order.
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
    """Chooses the next visit among candidates in the order of the queue.

    Parameters
    ----------
    blocked : array of bool, ``(n,)``
        Whether a satellite blocks the visit now.
    damage : array, ``(n,)``
        Damage if the visit is taken now.
    slew_s : array, ``(n,)``
        Slew time, seconds; NaN if the telescope cannot reach the visit.
    deferred : array of int, ``(n,)``
        Number of previous deferrals.
    max_extra_slew_s : float
        Maximum slew time in excess of that to the first candidate.
    max_defer : int
        Maximum number of deferrals of a visit.
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
        # The nearest visit loses least time; among equally near ones the earlier one in the queue is taken.
        return Choice(int(np.argmin(np.where(clear, slew_s + POSITION_PENALTY_S * np.arange(slew_s.size), np.inf))), "clear")
    worth = reached & (slew_s <= first_s + CROSSED_EXTRA_SLEW_S) & (damage <= CROSSED_DAMAGE_FRACTION * damage[0])
    return Choice(int(np.argmin(np.where(worth, damage, np.inf))) if worth.any() else 0, "least")
