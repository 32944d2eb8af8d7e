"""Result types of `StreakModel`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .typing import BoolOrArray, FloatArray, FloatOrArray, Table, TextOrArray, TimeResult, WholeArray, WholeOrArray

#: Verdicts in the order of their codes.
VERDICTS = np.array(["clear", "streaked", "avoid", "invalid", "unknown"])

#: Verdicts of exposures that cannot be judged, the last ones: there is no number of streaks.
UNJUDGED = ("invalid", "unknown")
#: Code of the first of them.
FIRST_UNJUDGED = len(VERDICTS) - len(UNJUDGED)


class Site(NamedTuple):
    """Location of an observer on the Earth."""

    #: Name.
    name: str
    #: Geodetic latitude (WGS84), degrees, north positive.
    latitude_deg: float
    #: Longitude, degrees, east positive.
    longitude_deg: float
    #: Height above the ellipsoid, metres.
    height_m: float


class CostParameters(NamedTuple):
    """Values that determine the cost of streaks."""

    #: Share of an exposure that is lost to a bright streak across the whole field.
    bright_share: float
    #: Magnitude at 550 km, without motion, above whose light per pixel a streak is bright.
    bright_mag: float
    #: Apparent magnitude limit, above which a satellite costs the exposure; `None` without a limit.
    limit_mag: float | None


class Assessment(NamedTuple):
    """Effects of satellites on exposures: numbers for one exposure, arrays in the broadcast shape for several."""

    #: ``clear``, ``streaked``, ``avoid`` (a limit of the policy is exceeded), ``unknown`` (the elements are too old to
    #: predict positions) or ``invalid`` (the pointing is below the horizon).
    verdict: TextOrArray
    #: Whether a lit satellite crosses the field; `None` (in arrays: masked) where invalid or unknown.
    crosses: BoolOrArray | None
    #: Number of lit satellites that cross the field; `None` (in arrays: masked) where invalid or unknown.
    n_streaks: WholeOrArray | None
    #: Brightest magnitude of these satellites inside the field; NaN if there are none.
    brightest_mag: FloatOrArray
    #: Expected fraction of pixels lost, [0, 1], including near misses with their probability; NaN without a telescope.
    lost_fraction: FloatOrArray
    #: Probability that at least one lit satellite crosses and is brighter than a limit of the policy, given the errors
    #: of element sets and magnitudes; equal to ``p_crossing`` without a limit; NaN where invalid or unknown.
    p_any: FloatOrArray
    #: Total length of the lit streaks in the field, degrees; NaN where invalid.
    streak_length_deg: FloatOrArray
    #: Whether ``p_any``, ``p_crossing``, ``lost_fraction`` and ``streak_cost_s`` are lower limits: for a satellite, more than
    #: 10 % of the possible delays are outside the range searched (3.5 sigmas without manoeuvres, at most 300 s), or more than 10 % of
    #: the satellites are of unknown position.
    p_any_is_lower_limit: BoolOrArray = False
    #: Probability that at least one lit satellite of any brightness crosses; NaN where invalid or unknown.
    p_crossing: FloatOrArray = float("nan")
    #: Age of the elements of the satellites that decide the verdict (median), days; NaN where invalid.
    elements_age_days: FloatOrArray = float("nan")
    #: Lateness of these satellites, seconds: the median of the half widths that contain 68 % of the delays; NaN where
    #: it is unknown.
    late_s: FloatOrArray = float("nan")
    #: Expected cost of the streaks, seconds of open shutter, including near misses with their probability; NaN without a
    #: telescope, and where invalid or unknown.
    streak_cost_s: FloatOrArray = float("nan")

    @property
    def avoid(self) -> BoolOrArray:
        """Whether a limit of the policy is exceeded."""
        return self.verdict == "avoid"

    @property
    def clear(self) -> BoolOrArray:
        """Whether no lit satellite crosses."""
        return self.verdict == "clear"


class ClearWindows(NamedTuple):
    """Intervals in which exposures can start, ordered by target and time; each field has the shape ``(n_windows,)``."""

    #: Flat index of the target.
    target: WholeArray
    #: First start: `astropy.time.Time` if astropy is installed, otherwise ``datetime64[ns]``, UTC.
    first_start: TimeResult
    #: Last start.
    last_start: TimeResult
    #: Time from the first to the last start, seconds.
    length_s: FloatArray


class Overhead(NamedTuple):
    """Satellites above a site: one row per satellite and time, or per possible position, grouped by satellite, in time
    order.

    Fields have the shape ``(n_rows,)`` if not stated.
    """

    #: Index of the time, from 0.
    moment: WholeArray
    #: NORAD catalogue number.
    norad_id: WholeArray
    #: Direction as a unit vector, ICRS, astrometric topocentric, ``(n_rows, 3)``.
    direction: FloatArray
    #: Probability of this position at this time; 1 without ``possible=True``.
    probability: FloatArray
    #: Range, km. This and the columns after the angular rate are computed for the middle row of each satellite, and repeated
    #: in its other rows.
    range_km: FloatArray
    #: Angular rate relative to the stars at this position, degrees per second.
    angular_rate_deg_s: FloatArray
    #: Width of the strip of pixels lost to the streak, arcseconds; NaN without a telescope.
    lost_width_arcsec: FloatArray
    #: Magnitude; NaN in the umbra, where the model predicts no light, and with ``light=False``.
    magnitude: FloatArray
    #: Probability of being brighter than each value of ``limit_mag``, ``(n_rows, n_limits)``; 0 without a magnitude.
    p_brighter: FloatArray
    #: Probability that the streak is brighter per pixel than that of a satellite of the telescope's ``bright_mag`` at 550
    #: km, for the cost of streaks; 0 in the umbra, NaN without a telescope and with ``light=False``.
    q_bright: FloatArray


class Forecast(NamedTuple):
    """The visible passes of one or several nights."""

    #: One row per pass, sorted by the start of visibility: ``night`` (row of ``nights``), rise, culmination and set,
    #: shadow entry and exit, visible part (``begin``, ``highest``, ``end`` and why it begins and ends), peak magnitude
    #: with sigma, source, position and range, age of the element set, and ``samples`` if requested.
    passes: Table
    #: One row per night: hours of darkness, lowest Sun altitude, number of omitted passes by reason, and ``why_empty``.
    nights: Table


class Identification(NamedTuple):
    """Candidate satellites for a measured streak, or for the streaks of a table: numbers for one streak, arrays of shape
    ``(n_streaks,)`` for those of a table."""

    #: One row per candidate, in order of decreasing probability: along-track and cross-track offsets with sigmas,
    #: angle, length, chi square, probability, position, magnitude, age of the element set. A streak that no candidate
    #: fits has no row. Those of a table begin with ``streak``, the name of the streak, and ``image``.
    candidates: Table
    #: One row per measured streak. Those of a table have ``streak``, ``image``, ``candidates`` and
    #: ``unknown_probability``, too; rows of the table that cannot be used are left out.
    streak: Table
    #: Number of candidates, including those that are not listed.
    n_candidates: WholeOrArray
    #: Probability that the streak is of a satellite that is missing in the element sets.
    unknown_probability: FloatOrArray
    #: Remarks about the columns of a table, and about the headers of its frames.
    remarks: tuple[str, ...] = ()
