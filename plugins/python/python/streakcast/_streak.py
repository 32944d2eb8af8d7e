"""Conversion of a measured streak to a request document, as used by all interfaces of streakcast."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._quantities import directions, finite_scalar, is_of, number
from ._setup import absolute
from ._times import to_tai
from .typing import EndsLike, FloatLike, FloatOrArray, Json, PathLike, TargetLike, TimeLike

#: Ways to specify a streak.
_FORMS = "ends; place with position_angle; pixels of a frame; region; or streaks, a table"


def streak_request(
    *,
    ends: EndsLike | None,
    times: TimeLike | None,
    place: TargetLike | None,
    position_angle: FloatLike | None,
    length: FloatLike | None,
    frame: str | None,
    pixels: ArrayLike | None,
    origin: int,
    hdu: int | None,
    region: PathLike | None,
    streaks: object,
    start: TimeLike | None,
    exposure: FloatLike | None,
    whole_streak: bool,
    place_sigma: FloatLike | None,
    time_sigma: FloatLike | None,
    angle_sigma: FloatLike | None,
    scale: str | None,
) -> dict[str, Json]:
    """Returns the request document, without the table of streaks. Arguments are those of `StreakModel.identify`."""
    ways = dict(ends=ends, place=place, pixels=pixels, region=region, streaks=streaks)
    named = [name for name, value in ways.items() if value is not None]
    if len(named) != 1:
        raise ValueError(f"{' and '.join(named) or 'missing streak'}; allowed, one of: {_FORMS}")
    for name, value, needed in (
        ("position_angle", position_angle, "place"), ("length", length, "place"), ("angle_sigma", angle_sigma, "place"),
        ("times", times, "ends"),
    ):  # fmt: skip
        if value is not None and named != [needed]:
            raise ValueError(f"{name} is accepted with {needed} only, not with {named[0]}")
    if streaks is not None and origin != 1:
        raise ValueError(f"origin is {origin!r}; allowed with streaks: omitted; the kind of a table determines its origin")
    request: dict[str, Json] = {"whole_streak": bool(whole_streak)}
    if ends is not None:
        request["end"] = [",".join(one) for one in zip(*_end_coordinates(ends))]
    elif place is not None:
        if position_angle is None:
            raise ValueError("missing position_angle of the streak at place; specify position_angle=...")
        ra, dec = directions(place)
        request["ra"], request["dec"] = _plain(ra, "ra"), _plain(dec, "dec")
        request["position_angle"] = finite_scalar(position_angle, "deg", "position_angle")
        request["length"] = _positive(length, "deg", "length")
    elif pixels is not None:
        if frame is None:
            raise ValueError("missing frame of the pixels; specify frame=...")
        if origin not in (0, 1):
            raise ValueError(f"origin is {origin!r}; allowed: 0, 1")
        array = number(pixels, "pix", "pixels")
        if array.shape != (2, 2) or not np.isfinite(array).all():
            raise ValueError(f"pixels is {pixels!r}; allowed: two pairs of numbers, ((x, y), (x, y))")
        request["from_pix"], request["to_pix"] = (
            ",".join(_plain(part, "pixels") for part in pixel) for pixel in array + (1 - origin)
        )
    elif region is not None:
        request["region"] = _path(region, "region")
    if frame is not None:
        request["image"] = frame
    if hdu is not None:
        # Tables may name their frames.
        if frame is None and streaks is None:
            raise ValueError("hdu is given without frame; allowed: with frame or streaks")
        request["hdu"] = int(hdu)
    if times is not None:
        if start is not None or exposure is not None or whole_streak:
            raise ValueError("times exclude start, exposure and whole_streak; allowed: either times, or the others")
        jd1, jd2 = to_tai(times, scale, "times")
        if np.shape(jd1) != (2,):
            raise ValueError(f"times have the shape {np.shape(jd1)}; allowed: two values, one for each end")
        request["times"] = [_core.utc_text(float(one), float(two)) for one, two in zip(jd1, jd2)]
    if start is not None:
        jd1, jd2 = to_tai(start, scale, "start")
        if np.shape(jd1) != ():
            raise ValueError(f"start has the shape {np.shape(jd1)}; allowed: one time")
        request["start"] = _core.utc_text(float(jd1), float(jd2))
    if exposure is not None:
        request["exposure"] = _plain(finite_scalar(exposure, "s", "exposure"), "exposure") + "s"
    request["place_sigma"] = _positive(place_sigma, "arcsec", "place_sigma")
    request["time_sigma"] = _positive(time_sigma, "s", "time_sigma")
    request["angle_sigma"] = _positive(angle_sigma, "deg", "angle_sigma")
    return {key: value for key, value in request.items() if value is not None}


def _end_coordinates(ends: EndsLike) -> tuple[list[str], list[str]]:
    """Returns right ascensions and declinations of two ends."""
    if is_of("astropy.coordinates", "SkyCoord", ends):
        parts = directions(ends)
    elif isinstance(ends, (tuple, list)):
        both = [directions(tuple(one) if isinstance(one, np.ndarray) else one) for one in ends]
        parts = (np.array([ra for ra, _ in both]), np.array([dec for _, dec in both]))
    elif np.shape(ends) == (2, 2):
        parts = tuple(number(ends, "deg", "ends").T)
    else:
        raise TypeError(f"ends is {type(ends).__name__}; allowed: a SkyCoord of two, or two pairs (ra, dec)")
    if parts[0].shape != (2,):
        raise ValueError(f"ends have the shape {parts[0].shape}; allowed: two positions")
    ra, dec = ([_plain(one, "ends") for one in part] for part in parts)
    return ra, dec


def _positive(value: FloatLike | None, unit: str, what: str) -> str | None:
    """Returns a number above 0 as a string with its unit and all digits."""
    if value is None:
        return None
    size = finite_scalar(value, unit, what)
    if size <= 0.0:
        raise ValueError(f"{what} is {size} {unit}; allowed: above 0 {unit}")
    return _plain(size, what) + unit


def _plain(value: FloatOrArray, what: str) -> str:
    """Returns a number as a string with all digits and without exponent."""
    if np.shape(value) != () or not np.isfinite(value):
        raise ValueError(f"{what} is {value}; allowed: one number")
    return np.format_float_positional(float(value), unique=True, trim="0")


def _path(value: object, what: str) -> str:
    if not isinstance(value, (str, os.PathLike)):
        raise TypeError(f"{what} is {type(value).__name__}; allowed: a path")
    return absolute(value)
