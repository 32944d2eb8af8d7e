"""Conversion of numbers, with or without astropy units, to plain arrays."""

from __future__ import annotations

import sys
from typing import Any, Union

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


def is_of(module_name: str, class_name: str, value: object) -> bool:
    """Returns True if the value is an instance of an astropy class. Does not import astropy."""
    module = sys.modules.get(module_name)
    return module is not None and isinstance(value, getattr(module, class_name))


def aligned(array: npt.NDArray[Any], dtype: Union[npt.DTypeLike, None] = None) -> npt.NDArray[Any]:
    """Returns the array; copied only if it is not contiguous or not aligned (as after transfer by Dask)."""
    return np.require(array, dtype, ["C_CONTIGUOUS", "ALIGNED"])


def number(value: Any, unit: str, what: str) -> FloatArray:
    """Returns a number or array in the given unit. A number without a unit is taken to be in this unit."""
    if is_of("astropy.units", "Quantity", value):
        try:
            value = value.to_value(unit)
        except Exception as error:
            raise ValueError(f"{what}: {error}; allowed: a number of {unit} or a Quantity") from None
    if isinstance(value, np.ma.MaskedArray) and np.any(value.mask):
        index = int(np.flatnonzero(np.ravel(np.ma.getmaskarray(value)))[0])
        raise ValueError(f"{what}[{index}] is masked; allowed: a number of {unit}")
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iuf":
            raise TypeError
        return array.astype(np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{what} is {type(value).__name__}; allowed: a number of {unit} or a Quantity") from None


def scalar(value: Any, unit: str, what: str) -> float:
    """Returns one number in the given unit."""
    array = number(value, unit, what)
    if array.shape != ():
        raise ValueError(f"{what} has the shape {array.shape}; allowed: one number")
    return float(array)


def directions(target: Any) -> tuple[FloatArray, FloatArray]:
    """Returns right ascension and declination, ICRS, degrees, of a `SkyCoord` in any frame or of a pair."""
    if is_of("astropy.coordinates", "SkyCoord", target):
        icrs = target.icrs
        return np.asarray(icrs.ra.deg, dtype=np.float64), np.asarray(icrs.dec.deg, dtype=np.float64)
    if not isinstance(target, (tuple, list)) or len(target) != 2:
        raise TypeError(f"target is {type(target).__name__}; allowed: a SkyCoord, or a pair (ra, dec) of degrees or Quantity")
    return number(target[0], "deg", "ra"), number(target[1], "deg", "dec")
