"""State that is common to all copies of a hook, file signatures, and distances between sites."""

from __future__ import annotations

import math
import os
import threading
import time as clock
import weakref
from collections import Counter
from collections.abc import Iterable

from ._mailbox import Mailbox
from .model import StreakModel

#: Modification time (ns), size and inode of each file; `None` for a missing file.
Signature = dict[str, tuple[int, int, int] | None]

_EARTH_KM = 6371.0


class RemoteHook:
    """Hook in another process, whose counters are read here."""

    def __init__(self, state: "weakref.ref[HookState]", mailbox: Mailbox) -> None:
        self.state, self.mailbox = state, mailbox
        self.collected: dict[str, int] = {}


class HookState:
    """State that is common to all copies of a hook."""

    def __init__(
        self,
        model: StreakModel,
        name: str,
        watch_s: float,
        counts: "Counter[str]",
        mailbox: Mailbox | None = None,
        seen: Signature | None = None,
    ) -> None:
        self.model, self.name, self.watch_s = model, name, watch_s
        self.counts, self.mailbox = counts, mailbox
        self.lock = threading.Lock()
        self.logged_kinds: set[str] = set()
        self.remote_hooks: list[RemoteHook] = []
        self.reading: threading.Thread | None = None
        self.next_check_s = clock.monotonic() + watch_s
        #: Delay before unreadable files are read again, and time of that attempt.
        self.retry_delay_s, self.retry_at_s = 0.0, math.inf
        self.seen: Signature = {} if seen is None else seen
        # An empty signature differs from files replaced after the model was made, so that the first check reads them
        # again.
        if seen is None and not model.changed_files():
            self.seen = signature(model.files)

    def loaded_signature(self) -> Signature | None:
        """Returns the signature of the files of the model; `None` while files are read, and after an error."""
        reading = self.reading is not None and self.reading.is_alive()
        return None if reading or self.retry_at_s < math.inf else self.seen


def signature(files: Iterable[str]) -> Signature:
    """Returns the current signature of the files."""
    found: Signature = {}
    for path in files:
        try:
            stat = os.stat(path)
            found[path] = (stat.st_mtime_ns, stat.st_size, stat.st_ino)
        except OSError:
            found[path] = None
    return found


def distance_km(one: tuple[float, float, float], other: tuple[float, float, float]) -> float:
    """Returns the distance of two sites, km: haversine on a sphere (error up to 0.5 %) and difference in height."""
    (lat1, lon1), (lat2, lon2) = ([math.radians(angle) for angle in site[:2]] for site in (one, other))
    # hav(d) = hav(lat2 - lat1) + cos(lat1) cos(lat2) hav(lon2 - lon1)
    hav = math.sin((lat2 - lat1) / 2) ** 2 + math.cos(lat1) * math.cos(lat2) * math.sin((lon2 - lon1) / 2) ** 2
    along_km = 2.0 * _EARTH_KM * math.asin(min(1.0, math.sqrt(hav)))
    return math.hypot(along_km, (one[2] - other[2]) / 1000.0)
