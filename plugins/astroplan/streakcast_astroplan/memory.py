"""Cache of clear windows for dispatch schedulers, which evaluate all tasks at every step."""

from __future__ import annotations

from collections import OrderedDict
from threading import Lock
from typing import Union

import numpy as np
from streakcast import StreakModel

from ._clear import TICK_S, FloatArray, windows_of
from .blocks import Rules

#: Time span of one cached computation, seconds. One hour contains twelve steps of five minutes, and takes as long as
#: computations for three single steps.
SPAN_S = 3600.0
#: Number of cached time spans. Each needs at most one kilobyte.
CACHED_SPANS = 4096


class ClearStarts:
    """Ratings of blocks of single targets, from cached windows. Thread-safe. A new model clears the cache."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._model: Union[StreakModel, None] = None
        self._cache: OrderedDict[tuple[float, float, float, Union[str, None], int], tuple[FloatArray, FloatArray]] = OrderedDict()

    def worth_of_block(self, model: StreakModel, rules: Rules, ra_deg: float, dec_deg: float, start_s: float, block_s: float) -> float:
        """Returns the rating of a block of one target, [0, 1], as `Rules.worth_of_block`.

        Parameters
        ----------
        model : StreakModel
            Satellites, site, field of view and limits.
        rules : Rules
            Requirements for exposures.
        ra_deg, dec_deg : float
            ICRS, degrees.
        start_s : float
            Start of the block, UTC seconds since 1970.
        block_s : float
            Length of the block, seconds.
        """
        offsets_s, length_s = rules.exposures.in_block(block_s)
        if rules.score != "clear":
            return float(rules.worth_of_block(model, np.array([ra_deg]), np.array([dec_deg]), start_s, block_s)[0])
        starts_s, length_s = rules.with_margins(start_s + offsets_s, length_s)
        clear = np.zeros(len(starts_s), dtype=bool)
        spans = np.floor(starts_s / SPAN_S).astype(int)
        for span in range(spans[0], spans[-1] + 1):
            opens_s, closes_s = self._windows(model, (ra_deg, dec_deg, length_s, rules.blocking, span))
            # Last window that opens before a start: the start is clear if it is before the end of this window.
            index = np.searchsorted(opens_s - TICK_S, starts_s, side="right") - 1
            if len(opens_s):
                clear |= (spans == span) & (index >= 0) & (starts_s <= closes_s[index] + TICK_S)
        return float(clear.mean())

    def _windows(self, model: StreakModel, key: tuple[float, float, float, Union[str, None], int]) -> tuple[FloatArray, FloatArray]:
        with self._lock:
            if self._model is not model:
                self._model = model
                self._cache.clear()
            cached = self._cache.get(key)
        if cached is not None:
            return cached
        ra_deg, dec_deg, length_s, blocking, span = key
        first_s = span * SPAN_S
        last_s = first_s + SPAN_S + length_s
        found = windows_of(model, np.array([ra_deg]), np.array([dec_deg]), first_s, last_s, length_s, blocking)[1:]
        with self._lock:
            if self._model is model:
                self._cache[key] = found
                while len(self._cache) > CACHED_SPANS:
                    self._cache.popitem(last=False)
        return found
