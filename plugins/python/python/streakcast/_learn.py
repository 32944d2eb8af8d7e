"""Offsets of satellites learned from measured magnitudes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from . import _core
from ._quantities import check_unmasked, number
from ._setup import document
from ._times import to_tai
from .typing import FloatArrayLike, Learned, ModelLike, PathLike, TimeLike, WholeLike


#: Range of magnitudes.
_MAGNITUDES = (-30.0, 40.0)


def learn(
    norad_id: WholeLike,
    time: TimeLike,
    observed: FloatArrayLike,
    predicted: FloatArrayLike,
    *,
    kind: str,
    sigma: FloatArrayLike | None = None,
    model: ModelLike | None = None,
    scale: str | None = None,
    output: PathLike | None = None,
) -> Learned:
    """Learns the offsets of satellites of one kind from their brightness model.

    Parameters
    ----------
    norad_id : int or array of int, shape (n,)
        NORAD catalogue number of each measurement.
    time : time, shape (n,)
        Times of the measurements.
    observed, predicted : float, array or `~astropy.units.Quantity`, shape (n,)
        Measured magnitudes, and those of the model without a learned file (``magnitude`` and ``predicted_magnitude``
        of ``streakcast measure``). Rows in which one of them is NaN are omitted.
    kind : str
        Kind of the satellites, for example ``"oneweb"``.
    sigma : float, array or `~astropy.units.Quantity`, optional
        Errors (one sigma) of the measurements, mag.
    model : str, path or dict, optional
        Brightness model of the predictions, as for `StreakModel`; the default model of the kind if omitted.
    scale : {"utc", "tai", "tt"}, optional
        Scale of bare numbers in `time`.
    output : path, optional
        File to write, for the argument ``learned`` of `StreakModel`.

    Returns
    -------
    Learned
        Content of the learned file, a dictionary: lists ``kinds`` and ``satellites`` with offsets and sigmas.

    Raises
    ------
    ValueError
        The kind is unknown or has no model, an argument has another shape, or no row is complete.
    """
    jd1, jd2 = to_tai(time, scale)
    check_unmasked(norad_id, "norad_id", "allowed: unmasked catalogue numbers")
    ids = np.asarray(norad_id)
    if ids.dtype.kind not in "iu" or np.any(ids < 1):
        raise ValueError("norad_id is not a list of catalogue numbers; allowed: integers from 1")
    given = (("observed", observed), ("predicted", predicted), ("sigma", np.nan if sigma is None else sigma))
    numbers = [number(value, "mag", name) for name, value in given]
    try:
        rows = [np.ascontiguousarray(np.ravel(column)) for column in np.broadcast_arrays(ids, jd1, jd2, *numbers)]
    except ValueError:
        raise ValueError("norad_id, time, observed, predicted and sigma differ in shape; allowed: one shape") from None
    ranges = (("observed", 3, *_MAGNITUDES, "magnitudes"), ("predicted", 4, *_MAGNITUDES, "magnitudes"), ("sigma", 5, 0.0, 10.0, "mag"))
    for name, column, least, most, what in ranges:
        values = rows[column]
        # NaN is unknown.
        wrong = np.flatnonzero((values < least) | (values > most))
        if wrong.size:
            raise ValueError(f"{name}[{wrong[0]}] is {values[wrong[0]]}; allowed: {what} from {least:g} to {most:g}")
    complete = np.isfinite(rows[3]) & np.isfinite(rows[4])
    ids, jd1, jd2, measured, computed, errors = [column[complete] for column in rows]
    setup = json.dumps(document({"model": model}))
    text = _core.learn(setup, kind, [int(one) for one in ids], jd1, jd2, measured - computed, errors)
    if output is not None:
        Path(output).write_text(text, encoding="utf-8")
    learned: Learned = json.loads(text)
    return learned
