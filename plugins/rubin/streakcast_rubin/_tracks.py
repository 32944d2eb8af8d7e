"""All lit satellites over a sky, second by second: asked once for everything above the horizon, kept in slots of 20 s."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Generic, NamedTuple, TypeVar, Union

import healpy as hp
import numpy as np
from astropy.time import Time
from streakcast import StreakModel

from ._arrays import FloatArray, IntArray
from ._questions import weight_of_light

#: What is asked in one go, seconds: over so short a stretch a parabola through three points is good to some arcminutes.
SLOT_S = 20.0
#: Between two samples of a track a satellite moves by a degree or two; `Samples.step_deg` says by how much.
SAMPLE_S = 2.0
#: The sky down to 18 degrees of altitude, as one round field.
SKY_DEG = 144.0
#: Slots that are kept: ten minutes.
KEPT = 30
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
    #: Peak magnitude, ``(n,)``; NaN where unknown.
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

    def __init__(self, model: StreakModel, scale: str) -> None:
        self.model = model
        self._wide = model.with_options(fov=f"{SKY_DEG} deg", field=None)
        self._scale = scale
        self._kept: Kept[Samples] = Kept()

    def over(self, start_mjd: float, end_mjd: float, zenith_deg: tuple[float, float]) -> list[tuple[int, Samples]]:
        """Slots that cover a stretch, each with its number: it begins ``number * SLOT_S`` after MJD 0.

        Parameters
        ----------
        start_mjd, end_mjd : float
            The stretch, in the host's scale.
        zenith_deg : pair
            Right ascension and declination of the zenith, to a degree or so.
        """
        numbers = range(int(start_mjd * 86_400.0 // SLOT_S), int(end_mjd * 86_400.0 // SLOT_S) + 1)
        known = {number: self._kept.get(self.model, number) for number in numbers}
        missing = [number for number, samples in known.items() if samples is None]
        if missing:
            found = self.ask(np.array(missing) * (SLOT_S / 86_400.0), SLOT_S, zenith_deg)
            known |= {number: self._kept.put(number, samples) for number, samples in zip(missing, found)}
        return [(number, samples) for number, samples in known.items() if samples is not None]

    def ask(self, starts_mjd: FloatArray, length_s: float, zenith_deg: tuple[float | FloatArray, float]) -> list[Samples]:
        """What stands in the sky from each of several moments on, for some seconds; the zenith is one for all, or one for each."""
        passes = self._wide.passes(zenith_deg, starts_mjd, length_s, scale=self._scale, output="dict")
        begun = np.asarray(Time(starts_mjd, format="mjd", scale=self._scale).utc.datetime64, dtype="datetime64[ns]")
        which = np.asarray(passes["exposure_id"], dtype=np.int64)
        knots = ("enter", "mid", "exit")
        seconds = [(np.asarray(passes[f"{one}_utc"]) - begun[which]) / np.timedelta64(1, "s") for one in knots]
        places = [_unit(*(np.asarray(passes[f"{one}_{angle}_deg"], dtype=float) for angle in ("ra", "dec"))) for one in knots]
        # share = length x width / area; 0 where no telescope says what is lost.
        share, length_deg = (np.asarray(passes[one], dtype=float) for one in ("lost_pixel_fraction", "streak_length_deg"))
        with np.errstate(divide="ignore", invalid="ignore"):
            width = np.nan_to_num(share * (self._wide.field_area_deg2 or 0.0) * 3600.0 / length_deg, posinf=0.0)
        rate, magnitude = np.asarray(passes["angular_rate_deg_s"], float), np.asarray(passes["magnitude_peak"], float)
        answer = []
        steps = np.arange(0.0, length_s, SAMPLE_S)
        for one in range(starts_mjd.size):
            row = np.flatnonzero(which == one)
            enter, middle, leave = (second[row, None] for second in seconds)
            inside = (steps >= enter - 1e-6) & (steps <= leave + 1e-6)
            if length_s <= SAMPLE_S:
                direction = places[1][row][:, None, :].repeat(steps.size, axis=1)
            else:
                direction = _parabola((enter, middle, leave), tuple(place[row] for place in places), steps)
            who, when = np.nonzero(inside)
            answer.append(Samples(direction[who, when], steps[when], rate[row][who], width[row][who], magnitude[row][who]))
        return answer


def _unit(ra_deg: FloatArray, dec_deg: FloatArray) -> FloatArray:
    ra, dec = np.radians(ra_deg), np.radians(dec_deg)
    return np.stack([np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)], axis=-1)


def _parabola(knots: tuple[FloatArray, FloatArray, FloatArray], places: tuple[FloatArray, ...], at: FloatArray) -> FloatArray:
    """Lagrange's parabola through three places, put back on the sphere: ``(n_tracks, n_moments, 3)``."""
    one, two, three = knots
    weights = (_basis(at, one, two, three), _basis(at, two, one, three), _basis(at, three, one, two))
    summed = np.zeros((one.shape[0], at.size, 3))
    for weight, place in zip(weights, places):
        # A track of no length has three equal knots, and stands still.
        summed += np.where(np.isfinite(weight), weight, 1.0 / 3.0)[..., None] * place[:, None, :]
    return np.asarray(summed / np.linalg.norm(summed, axis=-1, keepdims=True), dtype=float)


def _basis(at: FloatArray, own: FloatArray, one: FloatArray, two: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((at - one) * (at - two) / ((own - one) * (own - two)), dtype=float)


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

    #: Directions, ICRS, ``(n, 3)``.
    centres: FloatArray
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
        near = np.full((counts.size, counts.max()), -1, dtype=np.int64)
        near[cell, np.arange(cell.size) - np.repeat(np.cumsum(counts) - counts, counts)] = pointing
        return cls(centres, np.asarray(of_cell), near, radius_deg)


@lru_cache(maxsize=4)
def cells_as_pointings(nside: int, radius_deg: float, more_deg: float) -> Pointings:
    """Each cell's own centre."""
    centres = centres_of(nside)
    return Pointings.of(nside, centres, np.arange(len(centres)), radius_deg, more_deg)


@lru_cache(maxsize=16)
def fields_as_pointings(nside: int, ra_rad: bytes, dec_rad: bytes, of_cell: bytes, radius_deg: float, more_deg: float) -> Pointings:
    """The fields of a survey, and which of them a visit to a cell goes to; arrays as bytes, which can be looked up."""
    ra, dec = np.frombuffer(ra_rad), np.frombuffer(dec_rad)
    return Pointings.of(nside, _unit(np.degrees(ra), np.degrees(dec)), np.frombuffer(of_cell, dtype=np.int64), radius_deg, more_deg)


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
