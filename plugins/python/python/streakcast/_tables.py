"""Conversion of columns of the library to an astropy `QTable` or, without astropy, to a dictionary of arrays."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

import numpy as np
import numpy.typing as npt

from .typing import Columns, FloatArray, Json, Output, Table

if TYPE_CHECKING:
    from astropy.table import QTable
    from astropy.time import Time

    from ._core import Column


class Main(NamedTuple):
    """Main columns of a table, placed first and last, because `print` shows these if not all columns fit."""

    first: tuple[str, ...]
    last: tuple[str, ...]


# They fit in 80 characters if the names of the satellites have 13.
PASSES = Main(("exposure_id", "name", "enter_utc"), ("magnitude_peak", "probability"))
FLAGS = Main(("exposure_id", "verdict", "n_streaks"), ("brightest_mag", "p_any", "acceptable_delay_s"))
FORECAST = Main(("name", "begin_utc"), ("highest_altitude_deg", "peak_magnitude"))
NIGHTS = Main(("dark_from_utc", "dark_until_utc"), ("dark_h", "why_empty"))
EPHEMERIS = Main(("name", "utc", "ra_deg"), ("dec_deg", "magnitude"))
CANDIDATES = Main(("name", "probability"), ("along_track_offset_s", "magnitude"))
CANDIDATES_OF_TABLE = Main(("streak", "name", "probability"), ("along_track_offset_s", "magnitude"))
STREAKS_OF_TABLE = Main(("streak", "image", "start_utc"), ("candidates", "unknown_probability"))
STREAK = Main(("start_utc", "ra_deg", "dec_deg"), ("position_angle_deg", "length_deg"))
TRUTH = Main(("name", "x1_pix", "y1_pix", "x2_pix"), ("y2_pix", "length_pix", "magnitude"))

# Formats of printed columns. They do not change the values, also in files (`ResultTable`), and are also valid for
# tables that are read from an ECSV file.
# Numbers by unit, and some by the name of the column; other numbers are probabilities and fractions.
_NUMBER_FORMATS = {
    "1 / s": ".1f",
    "counts": ".1f",
    "julian_date_utc": ".8f",
    "arcsec": ".2f",
    "d": ".2f",
    "deg": ".4f",
    "deg / s": ".4f",
    "h": ".2f",
    "km": ".1f",
    "km / s": ".3f",
    "m": ".1f",
    "mag": ".2f",
    "mag / arcsec2": ".2f",
    "pix": ".2f",
    "s": ".3f",
}
#: Format of other numbers.
_NUMBER_FORMAT = ".4f"
#: Times to the millisecond: 23 characters, not rounded.
_TIME_FORMAT = "{!s:.23}"
#: Lists of points and of reasons, shortened to some characters.
_LIST_FORMAT = "{!s:.40}"


def is_qtable(output: str) -> bool:
    """Returns True if results with this setting are a `QTable`."""
    if output not in get_args(Output):
        raise ValueError(f"output is '{output}'; allowed: {', '.join(get_args(Output))}")
    return output == "qtable" or (output == "auto" and importlib.util.find_spec("astropy") is not None)


def table_of(
    columns: Sequence[Column], output: str, *, meta: Mapping[str, Json] | None = None, main: Main = Main((), ())
) -> Table:
    """Returns the columns in the requested form. The main columns are the first and the last ones of a `QTable`."""
    if is_qtable(output):
        named = {column["name"]: column for column in columns}
        others = [name for name in named if name not in (*main.first, *main.last)]
        return _qtable([named[name] for name in (*main.first, *others, *main.last)], meta or {})
    return arrays_of(columns)


def arrays_of(columns: Sequence[Column]) -> Columns:
    """Returns the columns by name, each an array with one cell per row."""
    return {column["name"]: _array(column) for column in columns}


def _array(column: Column) -> npt.NDArray[Any]:
    if column["kind"] == "time":
        return column["utc_ns"].view("datetime64[ns]")
    if column["kind"] == "text":
        return np.array(column["values"], dtype=np.str_)
    if column["kind"] == "list":
        cells = np.empty(len(column["values"]), dtype=object)
        cells[:] = column["values"]
        return cells
    if column["kind"] != "real" and column["missing"].any():
        return np.ma.MaskedArray(column["values"], mask=column["missing"])
    return column["values"]


def _qtable(columns: Sequence[Column], meta: Mapping[str, Json]) -> QTable:
    from astropy.table import Column, MaskedColumn
    from astropy.units import Quantity

    from ._result_table import ResultTable

    table = ResultTable(meta=dict(meta))
    for column in columns:
        name, style = column["name"], None
        if column["kind"] == "time":
            table[name] = time_of(column["jd1"], column["jd2"])
            style = _TIME_FORMAT
        elif column["kind"] == "real":
            unit = column["unit"]
            table[name] = Quantity(column["values"], unit, copy=False) if unit else Column(column["values"])
            style = _NUMBER_FORMATS.get(name) or _NUMBER_FORMATS.get(unit, _NUMBER_FORMAT)
        else:
            array = _array(column)
            table[name] = MaskedColumn(array) if isinstance(array, np.ma.MaskedArray) else Column(array)
            style = _LIST_FORMAT if column["kind"] == "list" else None
        table[name].info.description = column["description"]
        table[name].info.format = style
    return table


def time_of(jd1: FloatArray, jd2: FloatArray) -> Time:
    """Returns an astropy `Time`, UTC, for two-part Julian dates, TAI. NaN values are masked."""
    from astropy.time import Time

    missing = np.isnan(jd1)
    if not missing.any():
        return _utc(Time(jd1, jd2, format="jd", scale="tai"))
    # Missing values are replaced by a valid date, converted to UTC, and then masked.
    filled = np.where(missing, 2_451_545.0, jd1)
    time = _utc(Time(filled, np.where(missing, 0.0, jd2), format="jd", scale="tai")).copy()
    time[missing] = np.ma.masked
    return time


def _utc(time: Time) -> Time:
    utc = time.utc
    utc.format = "isot"
    utc.precision = 6
    return utc
