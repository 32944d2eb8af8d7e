"""Images that are 0 in most pixels."""

from __future__ import annotations

from typing import Generic, TypeVar

import numpy as np
import numpy.typing as npt

Scalar = TypeVar("Scalar", bound=np.generic)


class SparseImage(Generic[Scalar]):
    """Image row by row, of which only the runs of adjacent pixels that are not 0 take memory."""

    def __init__(self, columns: int, dtype: type[Scalar]) -> None:
        self._rows, self._columns, self._dtype = 0, columns, dtype
        #: Index of the first pixel and length of each run, and the values of all of them.
        self._runs: list[tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], npt.NDArray[Scalar]]] = []

    def append(self, rows: npt.NDArray[Scalar]) -> None:
        """Appends rows of pixels."""
        pixels = rows.ravel()
        filled = np.flatnonzero(pixels)
        is_first = np.diff(filled, prepend=-2) != 1
        lengths = np.diff(np.append(np.flatnonzero(is_first), filled.size))
        self._runs.append((filled[is_first] + self._rows * self._columns, lengths, pixels[filled]))
        self._rows += len(rows)

    def dense(self) -> npt.NDArray[Scalar]:
        """Returns the image as an array."""
        image = np.zeros((self._rows, self._columns), self._dtype)
        for starts, lengths, values in self._runs:
            numbers = np.arange(values.size) - np.repeat(np.cumsum(lengths) - lengths, lengths)
            image.ravel()[np.repeat(starts, lengths) + numbers] = values
        return image
