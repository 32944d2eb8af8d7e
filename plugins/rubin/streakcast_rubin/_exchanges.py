"""Table of the exchanges of a queue manager, and their assignment to the visits of a survey."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt
from astropy.table import Table
from streakcast import StreakcastWarning

from ._arrays import FloatArray

#: Largest number of exchanges that a queue manager keeps; ten years of Rubin have 100 to 200 thousand.
MOST_EXCHANGES = 500_000
#: Largest difference between the predicted shutter opening of an exchanged visit and its start, seconds: for visits with
#: the same ``target_id``, and for those without, which are matched by time. Successive visits start 40 s apart.
SAME_TARGET_S, NEAREST_S = 60.0, 10.0

Columns = Mapping[str, Any]


class Exchange(NamedTuple):
    """Exchange of two visits of the queue."""

    #: Predicted shutter opening of the dispatched visit, MJD in the scale of the scheduler.
    mjd: float
    target_id: int
    band: str
    #: Visit that was first in the queue.
    first_target_id: int
    #: Cost of the streaks of the first visit, seconds of open shutter.
    first_cost_s: float
    #: Cost of the streaks of the dispatched visit, seconds of open shutter.
    cost_s: float
    #: Detour of the whole path, seconds of the night.
    detour_s: float

    @property
    def saved_s(self) -> float:
        """Saved cost, seconds of open shutter."""
        return self.first_cost_s - self.cost_s


TYPES = {"mjd": float, "target_id": int, "band": str, "first_target_id": int, "first_cost_s": float, "cost_s": float, "detour_s": float}
UNITS = {"mjd": "d", "first_cost_s": "s", "cost_s": "s", "detour_s": "s", "saved_s": "s"}


def table_of(exchanges: Iterable[Exchange]) -> dict[str, npt.NDArray[Any]]:
    """Returns exchanges as columns, with the column ``saved_s``."""
    rows = list(exchanges)
    table: dict[str, npt.NDArray[Any]] = {name: np.array([getattr(row, name) for row in rows], dtype=of) for name, of in TYPES.items()}
    return {**table, "saved_s": table["first_cost_s"] - table["cost_s"]}


def write(table: Columns, path: Union[str, "os.PathLike[str]"]) -> None:
    """Writes a table of exchanges as ECSV."""
    Table(dict(table), units={name: UNITS.get(name) for name in table}).write(os.fspath(path), format="ascii.ecsv", overwrite=True)


def of_visits(
    exchanges: Union[Columns, str, "os.PathLike[str]"],
    start_mjd: FloatArray,
    band: npt.NDArray[Any],
    target_id: Optional[FloatArray] = None,
) -> dict[str, FloatArray]:
    """Returns the number of exchanges, their saved time and detour for each visit: an exchange is that of the visit with its
    `target_id`, if the visits have different ones, or else of the nearest visit of its band.

    Raises
    ------
    ValueError
        The file is missing or invalid, or a column is missing.
    """
    table: Columns
    if isinstance(exchanges, Mapping):
        table = exchanges
    else:
        path = os.fspath(exchanges)
        try:
            table = dict(Table.read(path, format="ascii.ecsv").columns)
        except (OSError, ValueError) as error:
            raise ValueError(f"{path} is not a table of exchanges ({error}); allowed: a file of write_exchanges") from error
    missing = [name for name in ("mjd", "band", "saved_s", "detour_s") if name not in table]
    if missing:
        raise ValueError(f"the exchanges lack the column {', '.join(missing)}; allowed: StreakQueueManager.exchanges, or a file of write_exchanges")
    mjd, bands, saved_s, detour_s = (np.asarray(table[name]) for name in ("mjd", "band", "saved_s", "detour_s"))
    start_mjd, band = np.asarray(start_mjd, dtype=float), np.asarray(band)
    has_targets = "target_id" in table and target_id is not None and np.unique(target_id).size == len(start_mjd)
    targets = np.asarray(table["target_id"]) if has_targets else None
    most_s = SAME_TARGET_S if has_targets else NEAREST_S
    found = {name: np.zeros(len(start_mjd)) for name in ("exchanged_visits", "saved_s", "detour_s")}
    assigned = 0
    for one in np.unique(bands):
        visits = np.flatnonzero((band == one) & np.isfinite(start_mjd))
        if not visits.size:
            continue
        visits = visits[np.argsort(start_mjd[visits], kind="stable")]
        of_band = np.flatnonzero(bands == one)
        if targets is not None and target_id is not None:
            # Visits with another identifier are not the same, whatever their time.
            visits = visits[np.argsort(target_id[visits])]
            nearest = visits[np.clip(np.searchsorted(target_id[visits], targets[of_band]), 0, visits.size - 1)]
            same = target_id[nearest] == targets[of_band]
        else:
            after = np.searchsorted(start_mjd[visits], mjd[of_band])
            neighbours = np.clip(np.stack([after - 1, after]), 0, visits.size - 1)
            apart = np.abs(start_mjd[visits[neighbours]] - mjd[of_band])
            nearest = visits[np.take_along_axis(neighbours, apart.argmin(axis=0)[None], axis=0)[0]]
            same = np.ones(nearest.shape, dtype=bool)
        same &= np.abs(start_mjd[nearest] - mjd[of_band]) <= most_s / 86_400.0
        assigned += int(same.sum())
        np.add.at(found["exchanged_visits"], nearest[same], 1.0)
        np.add.at(found["saved_s"], nearest[same], saved_s[of_band][same])
        np.add.at(found["detour_s"], nearest[same], detour_s[of_band][same])
    if assigned < len(mjd):
        of_target = " with the target_id" if has_targets else ""
        count = f"{len(mjd) - assigned} of {len(mjd)} exchanges are of no visit of the survey"
        message = f"{count}: no visit of the band{of_target} starts within {most_s:.0f} s"
        warnings.warn(message, StreakcastWarning, stacklevel=3)
    return found
