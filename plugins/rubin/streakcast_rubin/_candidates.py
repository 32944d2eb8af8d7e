"""Which visits of a queue may be taken next without disturbing what the survey asked for, and which of them is best."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ._arrays import BoolArray, FloatArray, IntArray, Visits

#: What a place further back in the queue counts for, as seconds of slew: the survey's order is a short way through the sky.
PLACE_S = 0.3

#: For a visit that is crossed all the same no longer way is gone than this, seconds, and none that does not halve the damage: else
#: under a sky without gaps the telescope would wander.
LEAST_BAD_SLEW_S = 5.0
WORTH_SHARE = 0.5


class Choice(NamedTuple):
    """Which of the candidates goes next, and why."""

    #: Its place among the candidates.
    place: int
    #: ``clear`` (nothing crosses it), ``due`` (the first one was put off as often as allowed) or ``least`` (all are crossed).
    why: str


def candidates(queue: Visits, valid: IntArray, look_ahead: int) -> IntArray:
    """The first visits that may trade places: places in the queue, in its order.

    They are of the band of the first one (a filter exchange costs minutes, and the second halves of pairs stand behind it), and no
    visit goes before an earlier one of the same field: the halves of a pair, and the visits of a sequence, keep their order.
    """
    taken: list[int] = []
    seen: set[tuple[float, float]] = set()
    rows = queue[valid[: 4 * look_ahead]]
    for place, band, field in zip(valid.tolist(), rows["band"].tolist(), zip(rows["RA"].tolist(), rows["dec"].tolist())):
        if band != rows["band"][0] or len(taken) == look_ahead:
            break
        if field not in seen:
            taken.append(place)
        seen.add(field)
    return np.array(taken, dtype=np.int64)


def choose(
    blocked: BoolArray, damage: FloatArray, slew_s: FloatArray, deferred: IntArray, max_extra_slew_s: float, max_defer: int
) -> Choice:
    """The next of several candidates, in the order of the queue.

    Parameters
    ----------
    blocked : array of bool, ``(n,)``
        Whether a satellite forbids it now.
    damage : array, ``(n,)``
        What it would lose, were it taken all the same.
    slew_s : array, ``(n,)``
        The way to it, seconds; NaN where the telescope cannot go.
    deferred : array of int, ``(n,)``
        How often it was put off already.
    max_extra_slew_s : float
        How much longer than to the first candidate the way may be.
    max_defer : int
        How often a visit may be put off.
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
        # The nearest loses least time; of two as near, the one that the survey wanted earlier.
        return Choice(int(np.argmin(np.where(clear, slew_s + PLACE_S * np.arange(slew_s.size), np.inf))), "clear")
    worth = reached & (slew_s <= first_s + LEAST_BAD_SLEW_S) & (damage <= WORTH_SHARE * damage[0])
    return Choice(int(np.argmin(np.where(worth, damage, np.inf))) if worth.any() else 0, "least")
