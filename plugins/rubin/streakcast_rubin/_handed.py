"""What copies of one queue manager have given out: `SummitWrapper` asks a copy, throws it away, and asks the next one.

The wrapper counts visits as taken by their numbers, in rising order. A visit that we put off goes out after a higher number, and the
next copy would be told that it is still to be had. So copies tell one another.
"""

from __future__ import annotations

from typing import Any

#: After so long a visit that never came back can be had again, days: it was lost.
LOST_DAY = 10.0 / 1440.0

#: Number, field and band: the numbers alone may be given twice, by two copies that filled their queues.
Key = tuple[int, float, float, str]


class Owner:
    """Who gave something out: a new one in every copy."""

    def __deepcopy__(self, memo: dict[int, Any]) -> Owner:
        return Owner()


class Handed:
    """Visits that are under way; deep copies are the same object."""

    def __init__(self) -> None:
        self._out: dict[Key, tuple[Owner, float]] = {}

    def __deepcopy__(self, memo: dict[int, Any]) -> Handed:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        # A pickle is another process, which gave out nothing yet.
        return (Handed, ())

    def out(self, visit: Any, owner: Owner, mjd: float) -> None:
        """A visit goes out."""
        self._out[key_of(visit)] = (owner, mjd)
        if len(self._out) > 1000:
            self._out = {key: one for key, one in self._out.items() if abs(mjd - one[1]) < LOST_DAY}

    def back(self, visit: Any) -> None:
        """A visit is done."""
        self._out.pop(key_of(visit), None)

    def by_others(self, visit: Any, owner: Owner, mjd: float) -> bool:
        """Whether another copy gave it out, not long ago."""
        who = self._out.get(key_of(visit))
        return who is not None and who[0] is not owner and abs(mjd - who[1]) < LOST_DAY


def key_of(visit: Any) -> Key:
    """What makes a visit itself."""
    return (int(visit["target_id"]), float(visit["RA"]), float(visit["dec"]), str(visit["band"]))
