"""Clear starts that are asked for again and again: a dispatch scheduler weighs every task at every step."""

from __future__ import annotations

from collections import OrderedDict
from threading import Lock
from typing import Union

import numpy as np
from streakcast import StreakModel

from ._answers import TICK_S, FloatArray, windows_of
from .blocks import Rules

#: Windows are found for as long at once, seconds: a dozen steps of five minutes for the price of three.
STRETCH_S = 3600.0
#: Stretches that are kept; one takes a kilobyte at most.
KEPT_STRETCHES = 4096


class ClearStarts:
    """Worth of blocks of single targets, from windows that are kept. Safe in threads; a new model begins anew."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._model: Union[StreakModel, None] = None
        self._kept: OrderedDict[tuple[float, float, float, str, int], tuple[FloatArray, FloatArray]] = OrderedDict()

    def worth_of_block(self, model: StreakModel, rules: Rules, ra_deg: float, dec_deg: float, start_s: float, block_s: float) -> float:
        """Worth of one target's block that begins then, [0, 1]: `Rules.worth_of_block`, with a memory.

        Parameters
        ----------
        model : StreakModel
            What is asked.
        rules : Rules
            What is asked of exposures.
        ra_deg, dec_deg : float
            ICRS, degrees.
        start_s : float
            Beginning of the block, UTC seconds of 1970.
        block_s : float
            Its length, seconds.
        """
        offsets_s, length_s = rules.exposures.in_block(block_s)
        if rules.score != "clear":
            return float(rules.worth_of_block(model, np.array([ra_deg]), np.array([dec_deg]), start_s, block_s)[0])
        starts_s, length_s = rules.with_margins(start_s + offsets_s, length_s)
        clear = np.zeros(len(starts_s), dtype=bool)
        stretches = np.floor(starts_s / STRETCH_S).astype(int)
        for stretch in range(stretches[0], stretches[-1] + 1):
            opens_s, closes_s = self._windows(model, (ra_deg, dec_deg, length_s, rules.blocking, stretch))
            # The last window that opens before the start, and whether it is open still.
            place = np.searchsorted(opens_s - TICK_S, starts_s, side="right") - 1
            if len(opens_s):
                clear |= (stretches == stretch) & (place >= 0) & (starts_s <= closes_s[place] + TICK_S)
        return float(clear.mean())

    def _windows(self, model: StreakModel, key: tuple[float, float, float, str, int]) -> tuple[FloatArray, FloatArray]:
        with self._lock:
            if self._model is not model:
                self._model = model
                self._kept.clear()
            known = self._kept.get(key)
        if known is not None:
            return known
        ra_deg, dec_deg, length_s, blocking, stretch = key
        first_s = stretch * STRETCH_S
        last_s = first_s + STRETCH_S + length_s
        found = windows_of(model, np.array([ra_deg]), np.array([dec_deg]), first_s, last_s, length_s, blocking)[1:]
        with self._lock:
            if self._model is model:
                self._kept[key] = found
                while len(self._kept) > KEPT_STRETCHES:
                    self._kept.popitem(last=False)
        return found
