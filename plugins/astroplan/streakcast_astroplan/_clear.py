"""Clear starts and lost pixels of exposures with one duration, for many targets and starts.

Times are UTC seconds since 1970.
"""

from __future__ import annotations

import json
from typing import Any, Union

import numpy as np
import numpy.typing as npt
from astropy.coordinates import SkyCoord, UnitSphericalRepresentation
from astropy.time import Time
from streakcast import StreakModel

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
#: Brightest magnitude limit accepted in a policy. No satellite exceeds it.
BRIGHTEST_LIMIT_MAG = -30.0
NO_TELESCOPE = "score 'pixels' requires the width of streaks, but the model has no telescope; specify StreakModel(telescope=...), or score 'clear'"


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


def lost_on_grid(
    model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, length_s: float
) -> FloatArray:
    """Returns the fraction of pixels lost to lit satellites, [0, 1]: ``(n_targets, n_starts)``; arguments as above.

    If only a part of a crossing is inside an exposure, that part of the streak is counted. Below the horizon the
    fraction is 1.

    Raises
    ------
    ValueError
        If the model has no telescope, from which the width of streaks is computed.
    """
    lost = np.zeros((len(ra_deg), len(starts_s)))
    for begin, end in _chunks(starts_s):
        some = starts_s[begin:end]
        span_s = some[-1] + length_s - some[0]
        passes = model.passes((ra_deg, dec_deg), _mjd(some[0]), span_s, scale="utc", output="dict")
        enter_s, exit_s = _seconds(passes["enter_utc"]), _seconds(passes["exit_utc"])
        pixels = passes["lost_pixel_fraction"] * passes["probability"]
        if np.any(np.isnan(pixels)):
            raise ValueError(NO_TELESCOPE)
        first = np.searchsorted(some, enter_s - length_s, side="right")
        last = np.searchsorted(some, exit_s)
        for row in range(len(pixels)):
            starts = some[first[row] : last[row]]
            # Part of the crossing within the exposure: (min(exit, s + D) - max(enter, s)) / (exit - enter)
            seen_s = np.minimum(exit_s[row], starts + length_s) - np.maximum(enter_s[row], starts)
            part = seen_s / max(exit_s[row] - enter_s[row], TICK_S)
            lost[passes["exposure_id"][row], begin + first[row] : begin + last[row]] += pixels[row] * np.clip(part, 0.0, 1.0)
    return np.where(_above_horizon(model, ra_deg, dec_deg, starts_s, length_s), np.minimum(lost, 1.0), 1.0)


def _above_horizon(model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, starts_s: FloatArray, length_s: float) -> BoolArray:
    """Returns True for exposures above the horizon: clear starts of a model in which no satellite blocks."""
    unlimited = model.with_options(fov="1arcsec", field=None, policy={"limit_mag": BRIGHTEST_LIMIT_MAG}, limit_mag=None)
    return clear_on_grid(unlimited, ra_deg, dec_deg, starts_s, length_s, "avoid")


def require_telescope(model: StreakModel) -> None:
    """Raises an error if the model cannot compute lost pixels.

    Raises
    ------
    ValueError
        If neither the arguments nor a configuration file can specify a telescope.
    """
    setup, config = json.loads(model.key())[:2]
    if config is None and "telescope" not in setup:
        raise ValueError(NO_TELESCOPE)


def windows_of(
    model: StreakModel, ra_deg: FloatArray, dec_deg: FloatArray, start_s: Any, end_s: Any, length_s: float, blocking: Union[str, None]
) -> tuple[npt.NDArray[np.int64], FloatArray, FloatArray]:
    """Returns targets, first and last clear starts, ``(n_windows,)`` each."""
    # MJD has a resolution of a microsecond: without the tolerance, the last start could be after the end.
    windows = model.clear_windows(
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
