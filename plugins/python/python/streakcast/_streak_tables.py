"""Tables of streaks as files: the library reads paths; tables in memory are written to temporary files."""

from __future__ import annotations

import csv
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from ._frames import is_path
from ._quantities import is_of, is_quantity
from ._setup import absolute
from .typing import PathLike, StreaksLike


#: Columns of an empty list.
ENDS = ("x1_pix", "y1_pix", "x2_pix", "y2_pix")


@dataclass(frozen=True)
class StreakFiles:
    """Files with tables of streaks."""

    paths: list[str]
    #: Folder of a temporary file with a separator; empty for files of the user.
    folder: str = ""

    @property
    def image_folder(self) -> str | None:
        """Folder to which names of frames are relative: the current one for a table in memory, otherwise that of the file."""
        return os.getcwd() if self.folder else None

    def shown(self, text: str) -> str:
        """Returns a message without the folder of the temporary file."""
        return text.replace(self.folder, "") if self.folder else text


@contextmanager
def streak_files(streaks: StreaksLike | Sequence[PathLike] | None, name: str = "streaks") -> Iterator[StreakFiles]:
    """Writes a table that is not a path to a temporary file, which exists inside the context; no file for `None`.

    Errors name the table ``name`` instead of the temporary file.
    """
    if streaks is None:
        yield StreakFiles([])
        return
    if is_path(streaks):
        yield StreakFiles([absolute(cast("PathLike", streaks))])
        return
    if isinstance(streaks, Sequence) and streaks and all(is_path(one) for one in streaks):
        yield StreakFiles([absolute(cast("PathLike", one)) for one in streaks])
        return
    with tempfile.TemporaryDirectory(prefix="streakcast-") as folder:
        files = StreakFiles([os.path.join(folder, name)], folder + os.sep)
        _write(streaks, files.paths[0])
        try:
            yield files
        except Exception as error:
            raise type(error)(files.shown(str(error))) from None


def _write(streaks: object, path: str) -> None:
    if isinstance(streaks, Mapping):
        for name, column in streaks.items():
            if not _has_rows(column):
                raise TypeError(f"column {name} of streaks is {type(column).__name__}; allowed: a list or an array with a value for each streak")
    if isinstance(streaks, Mapping) and any(is_quantity(column) for column in streaks.values()):
        from astropy.table import QTable

        streaks = QTable(dict(streaks))
    if is_of("astropy.table", "Table", streaks):
        # A row that begins with # would be a comment: columns of text are not the first ones.
        columns: Mapping[str, Any] = getattr(streaks, "columns")
        names = sorted(columns, key=lambda name: getattr(getattr(columns[name], "dtype", None), "kind", "O") in "SUO")
        _check_columns(names)
        cast("Any", streaks)[names].write(path, format="ascii.ecsv")
        return
    rows = _rows(streaks)
    names = list(streaks if isinstance(streaks, Mapping) else dict.fromkeys(name for row in rows for name in row))
    if isinstance(streaks, (list, tuple)) and not streaks:
        # A frame without streaks.
        names = list(ENDS)
    _check_columns(names)
    with open(path, "w", newline="", encoding="utf-8") as file:
        # Quotation marks keep names that begin with #, which would be comments.
        writer = csv.DictWriter(file, names, restval="", quoting=csv.QUOTE_NONNUMERIC)
        writer.writeheader()
        writer.writerows({name: _cell(value, name) for name, value in row.items()} for row in rows)


def _has_rows(column: Any) -> bool:
    try:
        len(column)
    except TypeError:
        return False
    return not isinstance(column, (str, bytes))


def _check_columns(names: Sequence[str]) -> None:
    if not names:
        raise ValueError("streaks have no columns; allowed: a table or a dictionary with the columns of the ends, which may have no rows")


def _rows(streaks: object) -> list[dict[str, Any]]:
    if isinstance(streaks, Mapping):
        lengths = {len(column) for column in streaks.values()}
        if len(lengths) > 1:
            raise ValueError(f"columns of streaks have the lengths {sorted(lengths)}; allowed: columns of one length")
        return [dict(zip(streaks, row)) for row in zip(*streaks.values())]
    if isinstance(streaks, Sequence) and not isinstance(streaks, (str, bytes)) and all(isinstance(row, Mapping) for row in streaks):
        return [dict(row) for row in streaks]
    raise TypeError(
        f"streaks is {type(streaks).__name__}; allowed: a path, an astropy Table, a dictionary of columns, or a list of dictionaries"
    )


def _cell(value: Any, name: str) -> Any:
    if is_quantity(value):
        raise TypeError(f"{name} of a streak is a Quantity; allowed: a number in the unit of the column, or a table with units")
    # NaN marks a missing number, as in tables of astropy, and so does a mask.
    return "" if value is None or value is np.ma.masked or value != value else value
