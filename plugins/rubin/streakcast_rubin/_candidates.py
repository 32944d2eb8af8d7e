"""Candidates for the next visit of a queue, and choice among them."""

from __future__ import annotations

import numpy as np

from ._arrays import FloatArray, IntArray, Visits

#: Open shutter per second of the night. A longer slew costs this share of its time.
OPEN_SHARE = 0.77


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


def detours_s(slew_s: FloatArray, between_s: FloatArray) -> FloatArray:
    """Returns by how much the path through the candidates becomes longer if one of them is visited first.

    The telescope goes to candidate k, returns to the first one, and later goes from k - 1 to k + 1.

    Parameters
    ----------
    slew_s : array, ``(n,)``
        Slew times from the current position to the candidates in queue order, seconds.
    between_s : array, ``(n, n)``
        Slew times between candidates, seconds.

    Returns
    -------
    array, ``(n,)``
        Detours, seconds; 0 for the first candidate, negative if the path becomes shorter.
    """
    n = len(slew_s)
    k = np.arange(1, n)
    # s(now,k) + s(k,0) - s(now,0) - s(k-1,k) + s(k-1,k+1) - s(k,k+1), without the last two at the end of the list
    detour_s = slew_s[k] + between_s[k, 0] - slew_s[0] - between_s[k - 1, k]
    inner = k[:-1]
    detour_s[:-1] += between_s[inner - 1, inner + 1] - between_s[inner, inner + 1]
    return np.concatenate([[0.0], detour_s])


def choose(cost_s: FloatArray, detour_s: FloatArray) -> int:
    """Returns the candidate with the least sum of the cost of streaks and the cost of the detour.

    Parameters
    ----------
    cost_s : array, ``(n,)``
        Costs of streaks, seconds of open shutter; NaN for candidates that cannot be judged.
    detour_s : array, ``(n,)``
        Detours, seconds of the night; NaN for candidates that cannot be reached.
    """
    total_s = cost_s + OPEN_SHARE * np.maximum(detour_s, 0.0)
    return int(np.argmin(np.where(np.isfinite(total_s), total_s, np.inf)))
