"""What copies of one queue manager have given out and put off: `SummitWrapper` asks a copy, throws it away, and asks the next one.

The wrapper counts visits as taken by their numbers, in rising order. A visit that we put off goes out after a higher number, and the
next copy would be told that it is still to be had, and not that it was put off. So copies tell one another.
"""

from __future__ import annotations

from typing import Any

#: After so long a visit that never came back can be had again, days: it was lost.
LOST_DAY = 10.0 / 1440.0
#: A visit that was not put off for so long begins anew, days: no queue is as old.
FORGOTTEN_DAY = 0.25
#: When what is too old is looked for: no queue is as long.
MOST_KEPT = 1000

#: Number, field and band: the numbers alone may be given twice, by two copies that filled their queues.
Key = tuple[int, float, float, str]


class Owner:
    """Who gave something out: a new one in every copy."""

    def __deepcopy__(self, memo: dict[int, Any]) -> Owner:
        return Owner()


class Handed:
    """Visits that are under way, and how often which was put off; deep copies are the same object."""

    def __init__(self, deferred: dict[Key, tuple[int, float]] | None = None) -> None:
        self._out: dict[Key, tuple[Owner, float]] = {}
        self._deferred: dict[Key, tuple[int, float]] = {} if deferred is None else deferred

    def __deepcopy__(self, memo: dict[int, Any]) -> Handed:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        # A pickle is another process, which gave out nothing yet; what was put off stays so.
        return (Handed, (dict(self._deferred),))

    def out(self, visit: Any, owner: Owner, mjd: float) -> None:
        """A visit goes out."""
        self._out[key_of(visit)] = (owner, mjd)
        if len(self._out) > MOST_KEPT:
            self._out = {key: one for key, one in self._out.items() if abs(mjd - one[1]) < LOST_DAY}

    def back(self, visit: Any) -> None:
        """A visit is done."""
        self._out.pop(key_of(visit), None)

    def put_off(self, visit: Any, mjd: float) -> None:
        """A visit waits once more."""
        self._deferred[key_of(visit)] = (self.deferred(visit, mjd) + 1, mjd)
        if len(self._deferred) > MOST_KEPT:
            self._deferred = {key: one for key, one in self._deferred.items() if abs(mjd - one[1]) < FORGOTTEN_DAY}

    def deferred(self, visit: Any, mjd: float) -> int:
        """How often a visit was put off, by all copies together."""
        count, last = self._deferred.get(key_of(visit), (0, mjd))
        return count if abs(mjd - last) < FORGOTTEN_DAY else 0

    def taken(self, visit: Any) -> None:
        """A visit waits no longer."""
        self._deferred.pop(key_of(visit), None)

    def by_others(self, visit: Any, owner: Owner, mjd: float) -> bool:
        """Whether another copy gave it out, not long ago."""
        who = self._out.get(key_of(visit))
        return who is not None and who[0] is not owner and abs(mjd - who[1]) < LOST_DAY


def key_of(visit: Any) -> Key:
    """What makes a visit itself."""
    return (int(visit["target_id"]), float(visit["RA"]), float(visit["dec"]), str(visit["band"]))
