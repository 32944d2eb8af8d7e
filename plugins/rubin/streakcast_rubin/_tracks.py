"""Tracks of all lit satellites above the site, computed and cached in time slots of 40 s."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Generic, NamedTuple, TypeVar, Union

import healpy as hp
import numpy as np
from streakcast import StreakModel

from ._arrays import FloatArray, IntArray, SingleArray
from ._verdicts import LEAST_PROBABILITY, weight_of_light

#: Length of a time slot, seconds, which is about the time between visits.
SLOT_S = 40.0
#: Interval between samples of a track, seconds; a satellite moves by one or two degrees in that time (see
#: `Samples.rate_deg_s`).
SAMPLE_S = 2.0
#: Smallest altitude of satellites, degrees.
LOWEST_DEG = 18.0
#: Number of cached slots, for ten minutes.
CACHED_SLOTS = 15
Value = TypeVar("Value")


class Samples(NamedTuple):
    """Lit satellites at sampled times, one row per satellite and time."""

    #: Directions, ICRS, ``(n, 3)``.
    direction: FloatArray
    #: Time, seconds after the start of the slot, ``(n,)``.
    second: FloatArray
    #: Angular rate, degrees per second, ``(n,)``.
    rate_deg_s: FloatArray
    #: Width of the pixels lost to a streak, arcseconds, ``(n,)``.
    lost_width_arcsec: FloatArray
    #: Magnitude, ``(n,)``; NaN where unknown.
    magnitude: FloatArray
    #: Probability of being brighter than each limit of the `Sky`, ``(n, n_limits)``.
    p_brighter: FloatArray


class SlotCache(Generic[Value]):
    """Cache of values for the most recently used time slots, all computed from one source."""

    def __init__(self, max_slots: int = CACHED_SLOTS) -> None:
        self._max_slots = max_slots
        self._source: Any = None
        self._slots: OrderedDict[int, Value] = OrderedDict()

    def get(self, source: Any, number: int) -> Union[Value, None]:
        """Returns the value of a slot; `None` if it is not cached. Another source clears the cache."""
        if source != self._source:
            self._source = source
            self._slots.clear()
        if number in self._slots:
            self._slots.move_to_end(number)
        return self._slots.get(number)

    def put(self, number: int, value: Value) -> Value:
        """Stores a value and removes the least recently used one if the cache is full."""
        self._slots[number] = value
        while len(self._slots) > self._max_slots:
            self._slots.popitem(last=False)
        return value


class Sky:
    """Lit satellites of a model, in time slots."""

    def __init__(self, model: StreakModel, scale: str, light: bool, limits_mag: tuple[float, ...] = ()) -> None:
        self.model = model
        self._scale = scale
        self._light = light
        #: Magnitude limits of the columns of `Samples.p_brighter`.
        self.limits_mag = limits_mag
        self._cache: SlotCache[Samples] = SlotCache()

    def over(self, start_mjd: float, end_mjd: float) -> list[tuple[int, Samples]]:
        """Returns the slots of a time span, with their numbers. A slot starts ``number * SLOT_S`` after MJD 0."""
        found = []
        for number in range(int(start_mjd * 86_400.0 // SLOT_S), int(end_mjd * 86_400.0 // SLOT_S) + 1):
            samples = self._cache.get(self.model, number)
            if samples is None:
                samples = self._cache.put(number, self.sample(number * (SLOT_S / 86_400.0), SLOT_S))
            found.append((number, samples))
        return found

    def sample(self, start_mjd: float, length_s: float) -> Samples:
        """Computes the satellites above the site in a time span."""
        steps = np.arange(0.0, length_s, SAMPLE_S)
        found = self.model.overhead(
            start_mjd, steps, min_altitude=LOWEST_DEG, light=self._light, limit_mag=self.limits_mag, scale=self._scale
        )
        # The width is 0 without a telescope.
        width = np.nan_to_num(found.lost_width_arcsec)
        return Samples(
            found.direction, steps[found.moment], found.angular_rate_deg_s, width, found.magnitude, found.p_brighter
        )

    def probability_brighter(self, limit_mag: float | None, samples: Samples) -> FloatArray:
        """Returns the probability of each sample of being brighter than a limit; 1 without a limit."""
        if limit_mag is None:
            return np.ones(samples.magnitude.size)
        return samples.p_brighter[:, self.limits_mag.index(limit_mag)]

    def probably_brighter(self, limit_mag: float | None, samples: Samples) -> Samples:
        """Returns the samples with a probability of at least 0.5 of being brighter than a limit, if any."""
        keep = self.probability_brighter(limit_mag, samples) >= LEAST_PROBABILITY
        return Samples(*(column[keep] for column in samples))


def _unit(ra_rad: FloatArray, dec_rad: FloatArray) -> FloatArray:
    return np.stack([np.cos(dec_rad) * np.cos(ra_rad), np.cos(dec_rad) * np.sin(ra_rad), np.sin(dec_rad)], axis=-1)


@lru_cache(maxsize=4)
def centres_of(nside: int) -> FloatArray:
    """Returns the directions of the centres of all cells (RING), ``(12 nside², 3)``."""
    return np.column_stack(hp.pix2vec(nside, np.arange(12 * nside * nside)))


@lru_cache(maxsize=4)
def sectors(nside: int) -> IntArray:
    """Returns for each cell (RING) the index of its sector, one of 192 sectors with sides of 15 degrees."""
    return np.asarray(hp.ring2nest(nside, np.arange(12 * nside * nside)) // (nside // 4) ** 2, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Pointings:
    """Pointings of visits (fields of a survey in one night, or cells), with an index of those near each cell."""

    #: Directions, ICRS, ``(n, 3)``. In single precision they have errors of some arcseconds.
    centres: SingleArray
    #: For each cell (RING) the index of the pointing of a visit to it.
    of_cell: IntArray
    #: For each cell the pointings that a satellite in it may cross, padded with -1, ``(n_cells, m)``.
    near: IntArray
    #: Radius around a pointing within which a satellite crosses, degrees.
    radius_deg: float

    @classmethod
    def of(cls, nside: int, centres: FloatArray, of_cell: IntArray, radius_deg: float, more_deg: float) -> Pointings:
        """Creates the index. `more_deg` allows for the position of satellites in a cell and for their motion."""
        lists = [hp.query_disc(nside, centre, np.radians(radius_deg + more_deg)) for centre in centres]
        cell, pointing = np.concatenate(lists), np.repeat(np.arange(len(lists)), [len(one) for one in lists])
        order = np.argsort(cell, kind="stable")
        cell, pointing = cell[order], pointing[order]
        counts = np.bincount(cell, minlength=12 * nside * nside)
        near = np.full((counts.size, counts.max()), -1, dtype=np.int32)
        near[cell, np.arange(cell.size) - np.repeat(np.cumsum(counts) - counts, counts)] = pointing
        return cls(centres.astype(np.float32), np.asarray(of_cell), near, radius_deg)


@lru_cache(maxsize=4)
def cells_as_pointings(nside: int, radius_deg: float, more_deg: float) -> Pointings:
    """Returns the centres of all cells as pointings."""
    centres = centres_of(nside)
    return Pointings.of(nside, centres, np.arange(len(centres)), radius_deg, more_deg)


@lru_cache(maxsize=16)
def fields_as_pointings(nside: int, ra_rad: bytes, dec_rad: bytes, of_cell: bytes, radius_deg: float, more_deg: float) -> Pointings:
    """Returns the fields of a survey as pointings, with the field of each cell; arrays as (hashable) bytes."""
    ra, dec = np.frombuffer(ra_rad), np.frombuffer(dec_rad)
    return Pointings.of(nside, _unit(ra, dec), np.frombuffer(of_cell, dtype=np.int64), radius_deg, more_deg)


def loss_of(samples: Samples, seconds: float, area_deg2: float, weighted: bool) -> FloatArray:
    """Returns the fraction of pixels lost to a satellite, length x width / area, optionally weighted by brightness."""
    lost = samples.rate_deg_s * seconds * samples.lost_width_arcsec / 3600.0 / area_deg2
    return np.asarray(lost * weight_of_light(samples.magnitude) if weighted else lost, dtype=float)
