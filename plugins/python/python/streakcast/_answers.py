"""What a model answers with."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._quantities import FloatArray

#: The verdicts in the order of their codes.
VERDICTS = np.array(["clear", "streaked", "avoid", "invalid"])


class Site(NamedTuple):
    """A place on the Earth."""

    #: Name.
    name: str
    #: Geodetic latitude (WGS84), degrees, north positive.
    latitude_deg: float
    #: Longitude, degrees, east positive.
    longitude_deg: float
    #: Height above the ellipsoid, metres.
    height_m: float


class Assessment(NamedTuple):
    """What satellites do to exposures: numbers for one exposure, arrays in the shape of the question for many."""

    #: ``clear``, ``streaked``, ``avoid`` (a limit of the policy is broken) or ``invalid`` (the pointing is below the horizon).
    verdict: Any
    #: Whether a lit satellite crosses the field.
    crosses: Any
    #: How many lit satellites do.
    n_streaks: Any
    #: The brightest magnitude that any of them reaches in the field; NaN without any.
    brightest_mag: Any
    #: Share of the field's pixels expected lost, [0, 1], near misses weighed with their probability; NaN without a telescope.
    lost_fraction: Any
    #: Probability that at least one lit satellite crosses, given the errors of the elements; NaN where invalid.
    p_any: Any
    #: Length of all lit streaks in the field, degrees; NaN where invalid.
    streak_length_deg: Any
    #: Whether ``p_any`` and ``lost_fraction`` are lower limits: elements are so old that delays beyond 300 s, which are not searched, are probable.
    p_any_is_lower_limit: Any = False

    @property
    def avoid(self) -> Any:
        """Whether a limit of the policy is broken."""
        return self.verdict == "avoid"

    @property
    def clear(self) -> Any:
        """Whether nothing lit crosses."""
        return self.verdict == "clear"


class ClearWindows(NamedTuple):
    """Stretches of clear starts, in order of target and time; each field has the shape ``(n_windows,)``."""

    #: The target's place in the question (flat).
    target: npt.NDArray[np.int64]
    #: First clear start: `astropy.time.Time` where astropy is there, else ``datetime64[ns]``, UTC.
    first_start: Any
    #: Last clear start.
    last_start: Any
    #: Length from the first to the last start, seconds.
    length_s: FloatArray


class Overhead(NamedTuple):
    """Satellites above a site, a row a satellite and moment, in order of satellite and time; ``(n_rows,)`` where no other shape is said."""

    #: Which of the moments, from 0.
    moment: npt.NDArray[np.int64]
    #: NORAD catalogue number.
    norad_id: npt.NDArray[np.int64]
    #: Direction as a unit vector, ICRS, astrometric topocentric, ``(n_rows, 3)``.
    direction: FloatArray
    #: Distance, km; this and all that follows stands for all of a satellite's rows, and is of the middle one of them.
    range_km: FloatArray
    #: Speed among the stars, degrees a second.
    angular_rate_deg_s: FloatArray
    #: Width of what its streak makes useless, arcseconds; NaN without a telescope.
    lost_width_arcsec: FloatArray
    #: Magnitude; NaN in the umbra, where a model sees nothing, and without ``light``.
    magnitude: FloatArray


class Forecast(NamedTuple):
    """The visible passes of one or several nights."""

    #: One row a pass, by the moment from which it can be seen: ``night`` (row of ``nights``), rise, culmination and set, shadow entry and
    #: exit, the visible part (``begin``, ``highest``, ``end`` and by what it begins and ends), peak magnitude with sigma, source, place and
    #: range, age of the elements, and ``samples`` where asked for.
    passes: Any
    #: One row a night: when it is dark, the Sun at its lowest, how many passes were left out and why, and ``why_empty``.
    nights: Any


class Identification(NamedTuple):
    """Whose streak it may be."""

    #: One row a candidate, the most probable first: offsets along and across the track with their sigmas, angle, length, chi square,
    #: probability, place, magnitude, age of the elements.
    candidates: Any
    #: The streak as it was understood, one row.
    streak: Any
    #: How many candidates there are, listed or not.
    n_candidates: int
    #: Probability that it is none of them, but a satellite without elements here.
    unknown_probability: float
