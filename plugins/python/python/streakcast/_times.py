"""Conversion of times of all accepted types to two-part Julian dates, TAI."""

from __future__ import annotations

import datetime
import sys
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from ._quantities import check_unmasked, is_quantity, number
from .typing import FloatArray, TimeLike

#: MJD in the years of which streakcast knows the time scales.
MJD_RANGE = (35_840.0, 88_068.0)
_ALLOWED = (
    "allowed: an astropy Time, a string that ends in Z, an aware datetime, or numbers (MJD) with "
    'scale="utc", "tai" or "tt"; in the wrong scale they are 37 s off, and a satellite crosses a field within seconds'
)


class TwoPartTai(NamedTuple):
    """Times that are already two-part Julian dates, TAI."""

    #: Integer or half-integer part, days.
    jd1: FloatArray
    #: Remainder, days.
    jd2: FloatArray


def is_time(value: object) -> bool:
    """Returns True if the value is an `astropy.time.Time`. Does not import astropy."""
    module = sys.modules.get("astropy.time")
    return module is not None and isinstance(value, module.Time)


def to_tai(value: TimeLike, scale: str | None, what: str = "time") -> tuple[FloatArray, FloatArray]:
    """Returns two-part Julian dates, TAI, in the shape of the value."""
    if isinstance(value, TwoPartTai):
        return value.jd1, value.jd2
    check_unmasked(value, what, "allowed: unmasked times")
    if is_time(value):
        if getattr(value, "scale") == "local":
            raise TypeError(f"{what} is a Time of the scale local, which is not related to others; {_ALLOWED}")
        tai = getattr(value, "tai")
        return np.asarray(tai.jd1, dtype=np.float64), np.asarray(tai.jd2, dtype=np.float64)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return _from_mjd(np.asarray(value, dtype=np.float64), scale, what)
    if isinstance(value, (str, datetime.datetime)):
        return _from_text(np.asarray(_text(value, what)), scale, what)
    if scale is not None:
        _check_precision(value, what)
    if is_quantity(value):
        value = number(value, "d", what)
    array = np.asarray(value)
    if array.size == 0:
        return np.zeros(array.shape), np.zeros(array.shape)
    if array.dtype.kind in "iuf":
        return _from_mjd(array.astype(np.float64), scale, what)
    if array.dtype.kind == "M":
        if scale is None:
            raise TypeError(f"{what} is numpy.datetime64 without a time scale; {_ALLOWED}")
        return _from_text(np.datetime_as_string(array), scale, what)
    if array.dtype.kind == "U":
        return _from_text(array, scale, what)
    if array.dtype.kind == "O":
        if any(is_time(item) for item in array.flat):
            parts = [to_tai(item, scale, f"{what}[{index}]") for index, item in enumerate(array.flat)]
            return np.reshape([jd1 for jd1, _ in parts], array.shape), np.reshape([jd2 for _, jd2 in parts], array.shape)
        if all(isinstance(item, (int, float, np.integer)) and not isinstance(item, bool) for item in array.flat):
            return to_tai(array.astype(np.float64), scale, what)
        texts = np.array([_text(item, what) for item in array.ravel()]).reshape(array.shape)
        return _from_text(texts, scale, what)
    raise TypeError(f"{what} is {type(value).__name__}, not a time; {_ALLOWED}")


def to_tai_or_nan(value: TimeLike, scale: str | None, what: str) -> tuple[FloatArray, FloatArray]:
    """Returns the same as `to_tai`; NaN for missing MJD (masked or `None`) and MJD out of range."""
    if not _is_mjd(value):
        return to_tai(value, scale, what)
    _check_precision(value, what)
    mjd = number(value, "d", what, keep_missing=True)
    known = (mjd > MJD_RANGE[0]) & (mjd < MJD_RANGE[1])
    parts = np.full((2, *mjd.shape), np.nan)
    parts[:, known] = to_tai(mjd[known], scale, what)
    return np.asarray(parts[0]), np.asarray(parts[1])


def _is_mjd(value: object) -> bool:
    """Returns true for numbers, which are MJD; also if some, or all, are missing."""
    if is_time(value) or isinstance(value, TwoPartTai):
        return False
    array = np.asarray(value)
    times = (str, datetime.datetime, np.datetime64)
    return array.dtype.kind in "iuf" or array.dtype.kind == "O" and not any(is_time(one) or isinstance(one, times) for one in array.flat)


def _check_precision(value: object, what: str) -> None:
    """Raises an error if an array has numbers of a type that is too coarse for MJD."""
    given = np.asarray(getattr(value, "value", value))
    if given.size > 0 and given.dtype.kind == "f" and given.dtype.itemsize < 8:
        raise TypeError(
            f"{what} is {given.dtype}, which has MJD in steps of {_step_s(given):.0f} s; allowed: float64, or a Time"
        )


def _step_s(array: npt.NDArray[np.generic]) -> float:
    """Returns the distance of neighbouring numbers of the type of an array at an MJD of today, seconds."""
    return float(np.spacing(np.asarray(61_000.0, array.dtype))) * 86_400.0


def _text(value: object, what: str) -> str:
    if isinstance(value, datetime.datetime):
        return value.isoformat()
    if isinstance(value, str):
        return value
    raise TypeError(f"{what} contains {type(value).__name__}, not a time; {_ALLOWED}")


def _from_mjd(array: FloatArray, scale: str | None, what: str) -> tuple[FloatArray, FloatArray]:
    if scale is None:
        raise TypeError(f"{what} is a bare number without a time scale; {_ALLOWED}")
    jd1, jd2 = _core.times_from_mjd(array.ravel(), scale)
    return jd1.reshape(array.shape), jd2.reshape(array.shape)


def _from_text(array: npt.NDArray[np.str_], scale: str | None, what: str) -> tuple[FloatArray, FloatArray]:
    texts = array.ravel().tolist()
    if scale is None:
        for index, text in enumerate(texts):
            if not _has_scale(text):
                raise TypeError(f"{what}[{index}] '{text}' has no time scale; {_ALLOWED}")
    jd1, jd2 = _core.times_from_text(texts, scale)
    return jd1.reshape(array.shape), jd2.reshape(array.shape)


def _has_scale(text: str) -> bool:
    """Returns False for a valid time without a scale. For other text it returns True; the library rejects it later."""
    try:
        _core.times_from_text([text], None)
        return True
    except ValueError:
        pass
    try:
        _core.times_from_text([text], "utc")
        return False
    except ValueError:
        return True
