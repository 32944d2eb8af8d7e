"""Dispatched visits, common to all copies of a queue manager.

`SummitWrapper` requests a visit from a copy, discards the copy, and continues with the next copy. It marks visits as
taken by their numbers, in ascending order. The first visit of the queue is dispatched after one with a higher number if
they were exchanged, so that for the next copy it would be available again. Copies therefore use the same state.
"""

from __future__ import annotations

from typing import Any

#: Time after which a dispatched visit that was not completed is available again, days.
EXPIRY_DAY = 10.0 / 1440.0
#: Number of entries above which expired ones are deleted. Queues are shorter.
MAX_ENTRIES = 1000

#: Number, field and band of a visit. Numbers are not unique if two copies have filled their queues.
Key = tuple[int, float, float, str]


class Owner:
    """Identity of a copy that dispatches visits. Every copy has its own object."""

    def __deepcopy__(self, memo: dict[int, Any]) -> Owner:
        return Owner()


class DispatchedVisits:
    """Visits in progress. A deep copy returns the same object."""

    def __init__(self) -> None:
        self._in_progress: dict[Key, tuple[Owner, float]] = {}

    def __deepcopy__(self, memo: dict[int, Any]) -> DispatchedVisits:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        # A pickle is used in another process, which has dispatched no visit.
        return (DispatchedVisits, ())

    def add(self, visit: Any, owner: Owner, mjd: float) -> None:
        """Records a dispatched visit."""
        self._in_progress[key_of(visit)] = (owner, mjd)
        if len(self._in_progress) > MAX_ENTRIES:
            self._in_progress = {key: one for key, one in self._in_progress.items() if abs(mjd - one[1]) < EXPIRY_DAY}

    def complete(self, visit: Any) -> None:
        """Removes a completed visit."""
        self._in_progress.pop(key_of(visit), None)

    def with_others(self, owner: Owner, mjd: float) -> set[Key]:
        """Returns the keys of the visits that other copies dispatched recently."""
        entries = list(self._in_progress.items())
        return {key for key, (by, when) in entries if by is not owner and abs(mjd - when) < EXPIRY_DAY}


def key_of(visit: Any) -> Key:
    """Returns the key of a visit."""
    return (int(visit["target_id"]), float(visit["RA"]), float(visit["dec"]), str(visit["band"]))
