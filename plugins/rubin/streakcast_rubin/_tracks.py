"""All lit satellites over a sky, second by second: asked once for everything above the horizon, kept in slots of 40 s."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Generic, NamedTuple, TypeVar, Union

import healpy as hp
import numpy as np
from streakcast import StreakModel

from ._arrays import FloatArray, IntArray, SingleArray
from ._questions import weight_of_light

#: What is asked in one go, seconds: about as long as from one visit to the next.
SLOT_S = 40.0
#: Between two samples of a track a satellite moves by a degree or two; `Samples.rate_deg_s` says by how much.
SAMPLE_S = 2.0
#: How far down satellites are looked at, degrees of altitude.
LOWEST_DEG = 18.0
#: Slots that are kept: ten minutes.
KEPT = 15
Value = TypeVar("Value")


class Samples(NamedTuple):
    """Lit satellites at moments, a row a satellite and moment."""

    #: Directions, ICRS, ``(n, 3)``.
    direction: FloatArray
    #: Moment, seconds after the slot's beginning, ``(n,)``.
    second: FloatArray
    #: Angular rate, degrees a second, ``(n,)``.
    rate_deg_s: FloatArray
    #: Width of what a streak makes useless, arcseconds, ``(n,)``.
    lost_width_arcsec: FloatArray
    #: Magnitude, ``(n,)``; NaN where unknown.
    magnitude: FloatArray


class Kept(Generic[Value]):
    """What was found for slots of time, the last ones that were asked for, all of one origin."""

    def __init__(self, most: int = KEPT) -> None:
        self._most = most
        self._of: Any = None
        self._slots: OrderedDict[int, Value] = OrderedDict()

    def get(self, of: Any, number: int) -> Union[Value, None]:
        """What is known of a slot; what was found of another origin is forgotten."""
        if of != self._of:
            self._of = of
            self._slots.clear()
        if number in self._slots:
            self._slots.move_to_end(number)
        return self._slots.get(number)

    def put(self, number: int, value: Value) -> Value:
        """Keeps what was found; the one that nobody asked for the longest goes."""
        self._slots[number] = value
        while len(self._slots) > self._most:
            self._slots.popitem(last=False)
        return value


class Sky:
    """The lit satellites of a model, by slots of time."""

    def __init__(self, model: StreakModel, scale: str, light: bool) -> None:
        self.model = model
        self._scale = scale
        self._light = light
        self._kept: Kept[Samples] = Kept()

    def over(self, start_mjd: float, end_mjd: float) -> list[tuple[int, Samples]]:
        """Slots that cover a stretch, in the host's scale, each with its number: it begins ``number * SLOT_S`` after MJD 0."""
        found = []
        for number in range(int(start_mjd * 86_400.0 // SLOT_S), int(end_mjd * 86_400.0 // SLOT_S) + 1):
            samples = self._kept.get(self.model, number)
            if samples is None:
                samples = self._kept.put(number, self.ask(number * (SLOT_S / 86_400.0), SLOT_S))
            found.append((number, samples))
        return found

    def ask(self, start_mjd: float, length_s: float) -> Samples:
        """What stands in the sky from a moment on, for some seconds."""
        steps = np.arange(0.0, length_s, SAMPLE_S)
        found = self.model.overhead(start_mjd, steps, min_altitude=LOWEST_DEG, light=self._light, scale=self._scale)
        # No width where no telescope says what is lost.
        width = np.nan_to_num(found.lost_width_arcsec)
        return Samples(found.direction, steps[found.moment], found.angular_rate_deg_s, width, found.magnitude)


def _unit(ra_rad: FloatArray, dec_rad: FloatArray) -> FloatArray:
    return np.stack([np.cos(dec_rad) * np.cos(ra_rad), np.cos(dec_rad) * np.sin(ra_rad), np.sin(dec_rad)], axis=-1)


@lru_cache(maxsize=4)
def centres_of(nside: int) -> FloatArray:
    """Directions of the centres of all cells (RING), ``(12 nside², 3)``."""
    return np.column_stack(hp.pix2vec(nside, np.arange(12 * nside * nside)))


@lru_cache(maxsize=4)
def sectors(nside: int) -> IntArray:
    """For each cell (RING) the part of the sky it is in, 192 parts of 15 degrees."""
    return np.asarray(hp.ring2nest(nside, np.arange(12 * nside * nside)) // (nside // 4) ** 2, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Pointings:
    """Where visits point, and which of them a satellite may cross: those of one night of a survey, or the cells themselves."""

    #: Directions, ICRS, ``(n, 3)``; single precision is good to some arcseconds.
    centres: SingleArray
    #: For each cell (RING) the pointing of a visit to it.
    of_cell: IntArray
    #: For each cell the pointings that a satellite in it may come close to, filled up with -1, ``(n_cells, m)``.
    near: IntArray
    #: How close counts, degrees.
    radius_deg: float

    @classmethod
    def of(cls, nside: int, centres: FloatArray, of_cell: IntArray, radius_deg: float, more_deg: float) -> Pointings:
        """The list is made for `more_deg` around the radius: where in its cell a satellite is, and how far it goes, is not known there."""
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
    """Each cell's own centre."""
    centres = centres_of(nside)
    return Pointings.of(nside, centres, np.arange(len(centres)), radius_deg, more_deg)


@lru_cache(maxsize=16)
def fields_as_pointings(nside: int, ra_rad: bytes, dec_rad: bytes, of_cell: bytes, radius_deg: float, more_deg: float) -> Pointings:
    """The fields of a survey, and which of them a visit to a cell goes to; arrays as bytes, which can be looked up."""
    ra, dec = np.frombuffer(ra_rad), np.frombuffer(dec_rad)
    return Pointings.of(nside, _unit(ra, dec), np.frombuffer(of_cell, dtype=np.int64), radius_deg, more_deg)


def loss_of(samples: Samples, seconds: float, area_deg2: float, weighted: bool) -> FloatArray:
    """Share of a field's pixels that a satellite costs in some seconds: length x width / area, weighed with its light where asked."""
    lost = samples.rate_deg_s * seconds * samples.lost_width_arcsec / 3600.0 / area_deg2
    return np.asarray(lost * weight_of_light(samples.magnitude) if weighted else lost, dtype=float)


def brighter_than(limit_mag: float | None, samples: Samples) -> Samples:
    """Those brighter than a limit; all where there is none. As in a policy, what has no magnitude breaks no limit."""
    if limit_mag is None:
        return samples
    keep = samples.magnitude < limit_mag
    return Samples(*(column[keep] for column in samples))
