"""Dispatched and deferred visits, common to all copies of a queue manager.

`SummitWrapper` requests a visit from a copy, discards the copy, and continues with the next copy. It marks visits as
taken by their numbers, in ascending order. A deferred visit is dispatched after a visit with a higher number, so that
for the next copy it would be available and not deferred. Copies therefore use the same state.
"""

from __future__ import annotations

from typing import Any

#: Time after which a dispatched visit that was not completed is available again, days.
EXPIRY_DAY = 10.0 / 1440.0
#: Time after which deferrals are no longer counted, days. Queues are never this old.
DEFERRAL_EXPIRY_DAY = 0.25
#: Number of entries above which expired ones are deleted. Queues are shorter.
MAX_ENTRIES = 1000

#: Number, field and band of a visit. Numbers are not unique if two copies have filled their queues.
Key = tuple[int, float, float, str]


class Owner:
    """Identity of a copy that dispatches visits. Every copy has its own object."""

    def __deepcopy__(self, memo: dict[int, Any]) -> Owner:
        return Owner()


class DispatchedVisits:
    """Visits in progress and numbers of deferrals. A deep copy returns the same object."""

    def __init__(self, deferred: dict[Key, tuple[int, float]] | None = None) -> None:
        self._in_progress: dict[Key, tuple[Owner, float]] = {}
        self._deferred: dict[Key, tuple[int, float]] = {} if deferred is None else deferred

    def __deepcopy__(self, memo: dict[int, Any]) -> DispatchedVisits:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        # A pickle is used in another process, which has dispatched no visit. Only deferrals are kept.
        return (DispatchedVisits, (dict(self._deferred),))

    def add(self, visit: Any, owner: Owner, mjd: float) -> None:
        """Records a dispatched visit."""
        self._in_progress[key_of(visit)] = (owner, mjd)
        if len(self._in_progress) > MAX_ENTRIES:
            self._in_progress = {key: one for key, one in self._in_progress.items() if abs(mjd - one[1]) < EXPIRY_DAY}

    def complete(self, visit: Any) -> None:
        """Removes a completed visit."""
        self._in_progress.pop(key_of(visit), None)

    def defer(self, visit: Any, mjd: float) -> None:
        """Counts a deferral of a visit."""
        self._deferred[key_of(visit)] = (self.deferred(visit, mjd) + 1, mjd)
        if len(self._deferred) > MAX_ENTRIES:
            self._deferred = {key: one for key, one in self._deferred.items() if abs(mjd - one[1]) < DEFERRAL_EXPIRY_DAY}

    def deferred(self, visit: Any, mjd: float) -> int:
        """Returns the number of deferrals of a visit in all copies."""
        count, last = self._deferred.get(key_of(visit), (0, mjd))
        return count if abs(mjd - last) < DEFERRAL_EXPIRY_DAY else 0

    def clear_deferrals(self, visit: Any) -> None:
        """Deletes the deferrals of a visit that was dispatched."""
        self._deferred.pop(key_of(visit), None)

    def is_with_another(self, visit: Any, owner: Owner, mjd: float) -> bool:
        """Returns True if another copy dispatched the visit recently."""
        dispatched = self._in_progress.get(key_of(visit))
        return dispatched is not None and dispatched[0] is not owner and abs(mjd - dispatched[1]) < EXPIRY_DAY


def key_of(visit: Any) -> Key:
    """Returns the key of a visit."""
    return (int(visit["target_id"]), float(visit["RA"]), float(visit["dec"]), str(visit["band"]))
