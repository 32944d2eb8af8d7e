"""Clear starts and costs of exposures with one duration, for many targets and starts.

Times are UTC seconds since 1970.
"""

from __future__ import annotations

import json
from typing import Any, Union

import numpy as np
import numpy.typing as npt
from astropy.coordinates import SkyCoord, UnitSphericalRepresentation
from astropy.time import Time
from streakcast import StreakModel, UnknownPositionsError

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

DAY_S = 86_400.0
_UNIX_EPOCH_JD = 2_440_587.5
_UNIX_EPOCH_MJD = 40_587.0
#: Longest time span of one call of the model, seconds. The model accepts a day, and uses one selection of element sets
#: per night.
CHUNK_S = 43_200.0
#: Tolerance at the ends of windows, seconds. Windows are rounded to milliseconds and end 1 to 2 ms before a satellite
#: enters the field.
TICK_S = 2e-3
NO_TELESCOPE = "the model has no telescope, which score 'cost' requires; specify StreakModel(telescope=...), or score 'clear'"


def unix_s(times: Time) -> FloatArray:
    """Converts times to UTC seconds since 1970, with a resolution of a microsecond. Leap seconds are not counted.

    Raises
    ------
    ValueError
        A time is masked.
    """
    if np.any(times.mask):
        raise ValueError("a time is masked; allowed: unmasked times")
    utc = times.utc
    return np.asarray((utc.jd1 - _UNIX_EPOCH_JD) * DAY_S + utc.jd2 * DAY_S, dtype=np.float64)


def times_of(unix: Any) -> Time:
    """Converts UTC seconds since 1970 to times."""
    return Time(_UNIX_EPOCH_MJD, np.asarray(unix) / DAY_S, format="mjd", scale="utc")


def icrs_deg(coordinates: SkyCoord) -> tuple[FloatArray, FloatArray]:
    """Returns right ascension and declination, ICRS, degrees, in the shape of the coordinates.

    Distances are ignored: the barycentric direction of a nearby body differs from its direction at the site.
    """
    frame = coordinates.frame
    if frame.name != "icrs":
        direction = frame.realize_frame(frame.data.represent_as(UnitSphericalRepresentation))
        frame = SkyCoord(direction).icrs.frame
    data = frame.data if hasattr(frame.data, "lon") else frame.data.represent_as(UnitSphericalRepresentation)
    return np.asarray(data.lon.deg, dtype=np.float64), np.asarray(data.lat.deg, dtype=np.float64)


def clear_on_grid(
    model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, length_s: float, blocking: Union[str, None]
) -> BoolArray:
    """Returns an array ``(n_targets, n_starts)``: True where exposures are clear, False below the horizon.

    Calls the model once per target and night, independent of the number of starts.

    Parameters
    ----------
    model : StreakModel
        Satellites, site, field of view and limits.
    ra_deg, dec_deg : array, ``(n_targets,)``
        ICRS, degrees.
    starts_s : array, ``(n_starts,)``
        Shutter openings, UTC seconds since 1970, ascending.
    length_s : float
        Duration of each exposure, seconds.
    blocking : {"any", "avoid"}, optional
        Satellites that block an exposure: all lit ones, or those that exceed a magnitude limit of the policy. Default:
        that of the policy.
    """
    clear = np.zeros((len(ra_deg), len(starts_s)), dtype=bool)
    for begin, end in _chunks(starts_s):
        some = starts_s[begin:end]
        windows = windows_of(model, ra_deg, dec_deg, some[0], some[-1] + length_s, length_s, blocking)
        first = np.searchsorted(some, windows[1] - TICK_S)
        last = np.searchsorted(some, windows[2] + TICK_S, side="right")
        for target, start, stop in zip(windows[0], first, last):
            clear[target, begin + start : begin + stop] = True
    return clear


def clear_one_by_one(
    model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, length_s: float, blocking: Union[str, None]
) -> BoolArray:
    """Same as `clear_on_grid` for single exposures of one duration, with one target per start; returns ``(n,)``."""
    clear = np.zeros(len(ra_deg), dtype=bool)
    clear[windows_of(model, ra_deg, dec_deg, starts_s, starts_s + length_s, length_s, blocking)[0]] = True
    return clear


def cost_on_grid(
    model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, length_s: float
) -> FloatArray:
    """Returns the cost of streaks as a fraction of the exposure, [0, 1]: ``(n_targets, n_starts)``; arguments as above.

    Below the horizon the fraction is 1.

    Raises
    ------
    ValueError
        If the model has no telescope, from which the cost is computed.
    UnknownPositionsError
        If the positions of the satellites are unknown at a start.
    """
    return _cost(model, ra_deg[:, np.newaxis], dec_deg[:, np.newaxis], starts_s, length_s)


def cost_one_by_one(
    model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, length_s: float
) -> FloatArray:
    """Same as `cost_on_grid` for single exposures of one duration, with one target per start; returns ``(n,)``."""
    return _cost(model, ra_deg, dec_deg, starts_s, length_s)


def _cost(model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, length_s: float) -> FloatArray:
    found = model.assess((ra_deg, dec_deg), _mjd(starts_s), length_s, scale="utc")
    verdict, cost_s = np.asarray(found.verdict), np.asarray(found.streak_cost_s)
    if np.any(verdict == "unknown"):
        raise UnknownPositionsError("positions of satellites are unknown: the elements are too old")
    judged = verdict != "invalid"
    if np.any(np.isnan(cost_s[judged])):
        raise ValueError(NO_TELESCOPE)
    if length_s == 0.0:
        return np.where(judged, 0.0, 1.0)
    return np.where(judged, np.minimum(cost_s / length_s, 1.0), 1.0)


def has_telescope(model: StreakModel) -> bool:
    """Returns True if the arguments of the model or its configuration file may specify a telescope."""
    setup, config = json.loads(model.key())[:2]
    return config is not None or "telescope" in setup


def windows_of(
    model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, start_s: Any, end_s: Any, length_s: float, blocking: Union[str, None]
) -> tuple[npt.NDArray[np.int64], FloatArray, FloatArray]:
    """Returns targets, first and last clear starts, ``(n_windows,)`` each."""
    # MJD has a resolution of a microsecond: without the tolerance, the last start could be after the end.
    windows = model.windows(
        (ra_deg, dec_deg), _mjd(start_s), _mjd(end_s + TICK_S), length_s, blocking=blocking, scale="utc", output="dict"
    )
    return windows.target, _seconds(windows.first_start), _seconds(windows.last_start)


def _chunks(starts_s: FloatArray) -> list[tuple[int, int]]:
    """Returns index ranges of groups of starts that span at most half a day."""
    if len(starts_s) == 0:
        return []
    number = np.floor((starts_s - starts_s[0]) / CHUNK_S)
    edges = np.flatnonzero(np.diff(number)) + 1
    return list(zip([0, *edges], [*edges, len(starts_s)]))


def _mjd(unix: Any) -> Any:
    return _UNIX_EPOCH_MJD + unix / DAY_S


def _seconds(moments: npt.NDArray[np.datetime64]) -> FloatArray:
    return np.asarray(moments.astype("datetime64[ns]").astype(np.int64) * 1e-9, dtype=np.float64)
