"""Conversion of numbers, with or without astropy units, to plain arrays."""

from __future__ import annotations

import operator
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np
import numpy.typing as npt

from .typing import FloatArray, FloatLike

if TYPE_CHECKING:
    from typing import TypeVar

    Scalar = TypeVar("Scalar", bound=np.generic)

#: Units with the same numbers as another one: AB magnitudes (in the magnitude system of the call), and counts.
_SAME_NUMBERS = {"mag": ("mag(AB)",), "electron / adu": ("electron / ct", "electron / DN")}


def is_of(module_name: str, class_name: str, value: object) -> bool:
    """Returns True if the value is an instance of an astropy class. Does not import astropy."""
    module = sys.modules.get(module_name)
    return module is not None and isinstance(value, getattr(module, class_name))


def is_quantity(value: object) -> bool:
    """Returns True for a `Quantity`, and for a column with a unit of an astropy `Table`."""
    if is_of("astropy.table", "Column", value):
        return getattr(value, "unit", None) is not None
    return is_of("astropy.units", "Quantity", value)


def check_unmasked(value: object, what: str, allowed: str) -> None:
    """Raises an error if a value is masked: in a masked array of NumPy, or a masked object of astropy."""
    if isinstance(value, np.ma.MaskedArray) or hasattr(type(value), "unmasked"):
        mask = getattr(value, "mask")
        masked = np.flatnonzero(mask)
        if masked.size:
            index = f"[{masked[0]}]" if np.shape(mask) else ""
            raise ValueError(f"{what}{index} is masked; {allowed}")


def aligned(array: "npt.NDArray[Scalar]", dtype: np.dtype[Scalar] | None = None) -> "npt.NDArray[Scalar]":
    """Returns the array; copied only if it is not contiguous or not aligned (as after transfer by Dask)."""
    return np.require(array, dtype, ["C_CONTIGUOUS", "ALIGNED"])


def number(value: object, unit: str, what: str, *, keep_missing: bool = False) -> FloatArray:
    """Returns a number or array in the given unit. A number without a unit is taken to be in this unit.

    An empty unit accepts numbers without a unit and dimensionless quantities. Missing numbers (masked, `None` or NA of
    pandas) are an error, or NaN if `keep_missing`.
    """
    allowed = f"allowed: a number of {unit} or a Quantity" if unit else "allowed: a number without a unit"
    if keep_missing:
        value = _missing_as_nan(value, what)
    check_unmasked(value, what, allowed)
    if is_quantity(value):
        return _converted(value, unit, what, allowed)
    if isinstance(value, (list, tuple)) and _contains_quantity(value):
        items = [number(item, unit, f"{what}[{index}]") for index, item in enumerate(value)]
        if len({item.shape for item in items}) > 1:
            raise ValueError(f"{what} has items of different shapes; {allowed}")
        return np.array(items)
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iuf":
            raise TypeError
        return array.astype(np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{what} is {type(value).__name__}; {allowed}") from None


def _missing_as_nan(value: Any, what: str) -> object:
    """Returns a value with NaN in place of masked cells, `None` and other objects of an object array."""
    if isinstance(value, np.ma.MaskedArray) and value.dtype.kind in "iufO":
        value = np.ma.filled(value if value.dtype == object else value.astype(np.float64), np.nan)
    if hasattr(type(value), "unmasked"):
        return value.filled(np.nan)
    if is_quantity(value) or isinstance(value, (list, tuple)) and _contains_quantity(value):
        return value
    array = np.asarray(value)
    return np.reshape([_float(cell, what) for cell in array.flat], array.shape) if array.dtype == object else value


def _float(cell: Any, what: str) -> float:
    """Returns a number; NaN for `None`, pandas' NA and other objects. Text is an error."""
    if isinstance(cell, str):
        raise TypeError(f"{what} contains '{cell[:40]}'; allowed: numbers, or None where they are missing")
    try:
        return float(cell)
    except (TypeError, ValueError):
        return float("nan")


def _contains_quantity(items: Sequence[object]) -> bool:
    """Returns True if one of the items, or of the items of a list or tuple in it, is a quantity."""
    return any(_contains_quantity(item) if isinstance(item, (list, tuple)) else is_quantity(item) for item in items)


def _converted(value: object, unit: str, what: str, allowed: str) -> FloatArray:
    from astropy.units import Unit, UnitsError

    given = getattr(value, "unit")
    numbers = np.asarray(getattr(value, "unmasked", value), dtype=np.float64)
    if any(given == Unit(other) for other in _SAME_NUMBERS.get(unit, ())):
        return numbers
    try:
        return np.asarray(given.to(Unit(unit), numbers), dtype=np.float64)
    except UnitsError:
        target = f", which cannot be converted to {unit}" if unit else ""
        raise ValueError(f"{what} has the unit '{given}'{target}; {allowed}") from None


def scalar(value: object, unit: str, what: str) -> float:
    """Returns one number in the given unit."""
    array = number(value, unit, what)
    if array.shape != ():
        raise ValueError(f"{what} has the shape {array.shape}; allowed: one number")
    return float(array)


def finite_scalar(value: FloatLike, unit: str, what: str) -> float:
    """Returns one finite number in the given unit."""
    finite = scalar(value, unit, what)
    if not np.isfinite(finite):
        raise ValueError(f"{what} is {finite}; allowed: a number of {unit}")
    return finite


def count(value: SupportsIndex, what: str, least: int) -> int:
    """Returns an integer that is not below the smallest accepted one."""
    try:
        integer = operator.index(value)
    except TypeError:
        raise TypeError(f"{what} is {value!r}; allowed: integers, {least} or more") from None
    if integer < least:
        raise ValueError(f"{what} is {integer}; allowed: {least} or more")
    return integer


def _icrs(target: object) -> Any:
    """Returns a `SkyCoord` in ICRS."""
    try:
        return getattr(target, "icrs")
    except Exception as error:
        # astropy has an exception of its own for frames without a time or a place.
        raise ValueError(f"target cannot be converted to ICRS: {error}; allowed: a frame with time and place") from None


def _degrees(axis: Any) -> FloatArray:
    """Returns a coordinate in degrees, NaN if it is masked."""
    degrees = np.asarray(getattr(axis, "unmasked", axis).deg, dtype=np.float64)
    return np.where(axis.mask, np.nan, degrees) if hasattr(axis, "mask") else degrees


def directions(target: object, *, keep_missing: bool = False) -> tuple[FloatArray, FloatArray]:
    """Returns right ascension and declination, ICRS, degrees, of a `SkyCoord` in any frame or of a pair.

    Missing numbers are an error, or NaN if `keep_missing`.
    """
    if is_of("astropy.coordinates", "SkyCoord", target):
        icrs = _icrs(target)
        for axis in () if keep_missing else (icrs.ra, icrs.dec):
            check_unmasked(axis, "target", "allowed: unmasked positions")
        return _degrees(icrs.ra), _degrees(icrs.dec)
    allowed = (
        "allowed: a SkyCoord, or a pair (ra, dec) of degrees or Quantity; for several positions, a tuple of an array of "
        "right ascensions and an array of declinations"
    )
    # A list of two sequences may be meant as two positions, or as right ascensions and declinations.
    if isinstance(target, list) and any(isinstance(item, (list, tuple)) or getattr(item, "shape", ()) for item in target):
        raise TypeError(f"target is a list of sequences; {allowed}")
    if not isinstance(target, (tuple, list)) or len(target) != 2:
        raise TypeError(f"target is {type(target).__name__}; {allowed}")
    ra, dec = (number(part, "deg", what, keep_missing=keep_missing) for part, what in zip(target, ("ra", "dec")))
    return ra, dec
