"""Lit satellites above the site at sampled times, costs of their streaks, and pointings of visits."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Generic, Hashable, NamedTuple, TypeVar, Union

import healpy as hp
import numpy as np
from streakcast import CostParameters, StreakModel

from ._arrays import FloatArray, IntArray, SingleArray
from ._costs import NO_TELESCOPE

NSIDE = 32
CELLS = 12 * NSIDE * NSIDE
#: Length of visits with the motion of the shutter, seconds.
VISIT_S = 31.0
Value = TypeVar("Value")


class Samples(NamedTuple):
    """Lit satellites at sampled times, one row per position and time."""

    #: Directions, ICRS, ``(n, 3)``.
    direction: FloatArray
    #: Index of the time, ``(n,)``.
    moment: IntArray
    #: Expected share of a visit that is lost per second in the field, ``(n,)``.
    share_per_s: FloatArray


class Cache(Generic[Value]):
    """Cache of the most recently used values, all computed from one source."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._source: Any = None
        self._values: OrderedDict[Hashable, Value] = OrderedDict()

    def get(self, source: Any, key: Hashable) -> Union[Value, None]:
        """Returns a value; `None` if it is not cached. Another source clears the cache."""
        if source != self._source:
            self._source = source
            self._values.clear()
        if key in self._values:
            self._values.move_to_end(key)
        return self._values.get(key)

    def put(self, key: Hashable, value: Value) -> Value:
        """Stores a value and removes the least recently used one if the cache is full."""
        self._values[key] = value
        while len(self._values) > self._most:
            self._values.popitem(last=False)
        return value


@dataclass(frozen=True)
class Sky:
    """Lit satellites of a model, and the costs of their streaks in visits in one band."""

    model: StreakModel
    #: Scale of MJDs.
    scale: str
    band: Union[str, None]

    @property
    def costs(self) -> CostParameters:
        """Parameters of the costs."""
        costs = self.model.cost_parameters(self.band)
        if costs is None:
            raise ValueError(NO_TELESCOPE)
        return costs

    @property
    def radius_deg(self) -> float:
        """Radius of a circle with the area of the field."""
        return float(np.sqrt((self.model.field_area_deg2 or np.nan) / np.pi))

    def sample(self, start_mjd: float, seconds: FloatArray, min_altitude_deg: float, *, possible: bool) -> Samples:
        """Computes the satellites above an altitude at times after a start, at their possible or predicted positions."""
        costs, diameter_deg = self.costs, 2.0 * self.radius_deg
        found = self.model.overhead(
            start_mjd, seconds, min_altitude=min_altitude_deg, possible=possible, limit_mag=() if costs.limit_mag is None else costs.limit_mag,
            band=self.band, scale=self.scale,
        )  # fmt: skip
        p_above = found.p_brighter.max(axis=1, initial=0.0)
        # A satellite above the limit costs max(1, b) visits, however long its streak is. The mean length of the chords of
        # a circle is π/4 times its diameter.
        mean_length_deg = np.minimum(np.pi / 4.0 * diameter_deg, found.angular_rate_deg_s * VISIT_S)
        share_per_deg = (
            (1.0 - p_above) * found.lost_width_arcsec / 3600.0 / (np.pi * self.radius_deg**2)
            + np.maximum(found.q_bright - p_above, 0.0) * costs.bright_share / diameter_deg
            + p_above * max(1.0, costs.bright_share) / mean_length_deg
        )
        return Samples(found.direction, found.moment, found.probability * share_per_deg * found.angular_rate_deg_s)

    def cost_s(self, share: FloatArray) -> FloatArray:
        """Returns the cost of visits, seconds of open shutter, for the sum of the shares of all satellites."""
        return np.asarray(VISIT_S * np.minimum(share, max(1.0, self.costs.bright_share)), dtype=float)


@lru_cache(maxsize=1)
def centres() -> FloatArray:
    """Returns the directions of the centres of all cells (RING), ``(CELLS, 3)``."""
    return np.column_stack(hp.pix2vec(NSIDE, np.arange(CELLS)))


@lru_cache(maxsize=1)
def discs(radius_deg: float) -> tuple[IntArray, IntArray]:
    """Returns the cells of the disc around each cell, one disc after another, and the number of cells of each disc."""
    lists = [hp.query_disc(NSIDE, centre, np.radians(radius_deg)) for centre in centres()]
    return np.concatenate(lists), np.array([len(one) for one in lists])


@dataclass(frozen=True, eq=False)
class Pointings:
    """Pointings of visits (fields of a survey in one night, or cells), with an index of those near each cell."""

    #: Directions, ICRS, ``(n, 3)``. In single precision they have errors of some arcseconds.
    centres: SingleArray
    #: For each cell (RING) the index of the pointing of a visit to it.
    of_cell: IntArray
    #: For each cell the pointings that a satellite in it may cross, padded with -1, ``(CELLS, m)``.
    near: IntArray


@lru_cache(maxsize=16)
def pointings_of(directions: bytes, of_cell: bytes, radius_deg: float) -> Pointings:
    """Creates the index for fields of a radius. The arrays are given as (hashable) bytes, so that copies of a scheduler
    use the same result."""
    where = np.frombuffer(directions).reshape(-1, 3)
    reach = np.radians(radius_deg) + hp.max_pixrad(NSIDE)
    lists = [hp.query_disc(NSIDE, one, reach) for one in where]
    cell, pointing = np.concatenate(lists), np.repeat(np.arange(len(lists)), [len(one) for one in lists])
    order = np.argsort(cell, kind="stable")
    cell, pointing = cell[order], pointing[order]
    counts = np.bincount(cell, minlength=CELLS)
    near = np.full((CELLS, counts.max()), -1, dtype=np.int32)
    near[cell, np.arange(cell.size) - np.repeat(np.cumsum(counts) - counts, counts)] = pointing
    return Pointings(where.astype(np.float32), np.frombuffer(of_cell, dtype=np.int64), near)
