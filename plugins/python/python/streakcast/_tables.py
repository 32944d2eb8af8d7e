"""Conversion of columns of the library to an astropy `QTable` or, without astropy, to a dictionary of arrays."""

from __future__ import annotations

import importlib.util
from typing import Any, Union

import numpy as np

#: `QTable` if astropy is installed, otherwise a dictionary of arrays.
TableLike = Any


def is_qtable(output: str) -> bool:
    """Returns True if results with this setting are a `QTable`."""
    if output not in ("auto", "qtable", "dict"):
        raise ValueError(f"output is '{output}'; allowed: auto, qtable, dict")
    return output == "qtable" or (output == "auto" and importlib.util.find_spec("astropy") is not None)


def table_of(columns: list[dict[str, Any]], output: str, meta: Union[dict[str, Any], None] = None) -> TableLike:
    """Returns the columns in the requested form."""
    if is_qtable(output):
        return _qtable(columns, meta or {})
    return {column["name"]: _array(column) for column in columns}


def _array(column: dict[str, Any]) -> Any:
    kind = column["kind"]
    if kind == "time":
        return column["utc_ns"].view("datetime64[ns]")
    if kind == "text":
        return np.array(column["values"], dtype=np.str_)
    if kind == "list":
        return column["values"]
    if kind in ("integer", "boolean") and column["missing"].any():
        return np.ma.MaskedArray(column["values"], mask=column["missing"])
    return column["values"]


def _qtable(columns: list[dict[str, Any]], meta: dict[str, Any]) -> Any:
    from astropy.table import Column, MaskedColumn, QTable
    from astropy.units import Quantity

    table = QTable(meta=meta)
    for column in columns:
        name, kind = column["name"], column["kind"]
        cells: Any
        if kind == "time":
            cells = time_of(column["jd1"], column["jd2"])
        elif kind == "real" and column["unit"]:
            cells = Quantity(column["values"], column["unit"], copy=False)
        elif kind == "list":
            cells = np.empty(len(column["values"]), dtype=object)
            cells[:] = column["values"]
            cells = Column(cells)
        else:
            array = _array(column)
            cells = MaskedColumn(array) if isinstance(array, np.ma.MaskedArray) else Column(array)
        table[name] = cells
        table[name].info.description = column["description"]
    return table


def time_of(jd1: Any, jd2: Any) -> Any:
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


def _utc(time: Any) -> Any:
    utc = time.utc
    utc.format = "isot"
    utc.precision = 6
    return utc
