"""Tables of results, which are written to files with all digits. This module requires astropy."""

from __future__ import annotations

import json

import numpy as np
import numpy.typing as npt
from astropy.table import Column, QTable
from astropy.time import Time


class ResultTable(QTable):  # type: ignore[misc]
    """A `QTable` whose files have the values with all digits: the formats of its columns are for `print` only."""

    def write(self, *arguments: object, **options: object) -> None:
        """Writes the table, as `QTable.write`, without the formats of its columns.

        Unlike there, it is a plain method, without ``list_formats``. Lists are written as JSON text, except to ECSV, which has lists. Times are written to VOTable as ISO 8601 text.
        """
        table = QTable(self, copy=True)
        form = str(options.get("format") or (arguments[0] if arguments else "")).lower()
        # ECSV never applies the formats to the values, and restores them.
        if not form.endswith("ecsv"):
            _simplify(table, are_times_text=form.endswith(("votable", "votable.parquet")))
        table.write(*arguments, **options)

    # Masked times of astropy cannot be pickled, so that their masks are stored separately.
    def __getstate__(self) -> tuple[object, ...]:
        columns, meta = super().__getstate__()
        masks = {name: np.array(column.mask) for name, column in columns.items() if _is_masked_time(column)}
        plain = {name: column.unmasked if name in masks else column for name, column in columns.items()}
        return plain, meta, masks

    def __setstate__(self, state: tuple[object, object, dict[str, npt.NDArray[np.bool_]]]) -> None:
        columns, meta, masks = state
        super().__setstate__((columns, meta))
        for name, mask in masks.items():
            self[name][mask] = np.ma.masked


def _is_masked_time(column: object) -> bool:
    return isinstance(column, Time) and bool(getattr(column, "masked"))


def _is_of_lists(column: object) -> bool:
    if not isinstance(column, Column) or column.dtype != object:
        return False
    return all(isinstance(cell, list) or cell is np.ma.masked for cell in column)


def _simplify(table: QTable, *, are_times_text: bool) -> None:
    """Removes the formats of columns, and replaces lists and, if requested, times by text."""
    for name in table.colnames:
        column = table[name]
        column.info.format = None
        if isinstance(column, Time):
            if not are_times_text:
                continue
            texts = ["" if is_masked else str(text) for text, is_masked in zip(column.isot, column.mask)]
        elif _is_of_lists(column):
            texts = ["" if cell is np.ma.masked else json.dumps(cell, default=lambda number: number.item()) for cell in column]
        else:
            continue
        table[name] = Column(np.array(texts, dtype=np.str_), description=column.info.description)
