"""What all copies of a hook share, and what it sees of files and places."""

from __future__ import annotations

import math
import os
import threading
import time as clock
import weakref
from collections import Counter
from typing import Any, Union

from ._mailbox import Mailbox
from .model import StreakModel

#: Time of change (ns), size and inode of each file; `None` where there is none.
Signature = dict[str, Union[tuple[int, int, int], None]]

_EARTH_KM = 6371.0


class Lent:
    """A hook of another process, as seen from here."""

    def __init__(self, state: "weakref.ref[HookState]", mailbox: Mailbox) -> None:
        self.state, self.mailbox = state, mailbox
        self.taken: dict[str, int] = {}


class HookState:
    """What all copies of a hook share."""

    def __init__(
        self,
        model: StreakModel,
        name: str,
        watch_s: float,
        counts: "Counter[str]",
        mailbox: Union[Mailbox, None] = None,
        seen: Union[Signature, None] = None,
    ) -> None:
        self.model, self.name, self.watch_s = model, name, watch_s
        self.counts, self.mailbox = counts, mailbox
        self.lock = threading.Lock()
        self.said: set[str] = set()
        self.lent: list[Lent] = []
        self.reading: Union[threading.Thread, None] = None
        self.next_look_s = clock.monotonic() + watch_s
        #: How long until files that could not be read are tried again, and when that is.
        self.wait_s, self.again_at_s = 0.0, math.inf
        self.seen: Signature = {} if seen is None else seen
        # Files that were replaced since the model was made differ from this at the first look.
        if seen is None and not model.changed_files():
            self.seen = signature(model.files)

    def taken(self) -> Union[Signature, None]:
        """The files that the model is of; `None` where they are being read, or could not be: then the model may be of older ones."""
        reading = self.reading is not None and self.reading.is_alive()
        return None if reading or self.again_at_s < math.inf else self.seen


def signature(files: dict[str, Any]) -> Signature:
    """The files as they are now."""
    answer: Signature = {}
    for path in files:
        try:
            stat = os.stat(path)
            answer[path] = (stat.st_mtime_ns, stat.st_size, stat.st_ino)
        except OSError:
            answer[path] = None
    return answer


def distance_km(one: tuple[float, float, float], other: tuple[float, float, float]) -> float:
    """Between two places, kilometres: the haversine on a sphere (0.5 % of the truth at most), and the heights."""
    (lat1, lon1), (lat2, lon2) = ([math.radians(angle) for angle in place[:2]] for place in (one, other))
    # hav(d) = hav(lat2 - lat1) + cos(lat1) cos(lat2) hav(lon2 - lon1)
    hav = math.sin((lat2 - lat1) / 2) ** 2 + math.cos(lat1) * math.cos(lat2) * math.sin((lon2 - lon1) / 2) ** 2
    along_km = 2.0 * _EARTH_KM * math.asin(min(1.0, math.sqrt(hav)))
    return math.hypot(along_km, (one[2] - other[2]) / 1000.0)
