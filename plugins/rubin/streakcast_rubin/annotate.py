"""Streaks in the visits of a survey: columns for arrays, and tables in opsim databases."""

from __future__ import annotations

import contextlib
import os
import sqlite3
from pathlib import Path
from typing import Any, Union

from streakcast import StreakModel

from ._arrays import Visits
from ._verdicts import pointings, scale_of, warn_of_sun

#: Beginning of a SQLite file.
SQLITE = b"SQLite format 3\0"


def visit_columns(visits: Visits, model: StreakModel, *, mjd_scale: Union[str, None] = None) -> dict[str, Any]:
    """Returns the effects of satellites on each visit.

    Parameters
    ----------
    visits : ObservationArray
        RA, dec and rotSkyPos in radians, mjd, exptime in seconds, band.
    model : StreakModel
        Site, satellites and field.
    mjd_scale : {"utc", "tai", "tt"}, optional
        Scale of ``mjd``. It must be given here or in the model.

    Returns
    -------
    dict of arrays, ``(n_visits,)`` each
        As `StreakModel.flag`: ``verdict``, ``n_streaks``, ``brightest_mag``, ``expected_lost_pixel_fraction``,
        ``p_any``, ``streak_length_deg``, ``norad_ids`` and more. Visits with NaN or numbers out of range have the verdict
        ``invalid``.

    Warns
    -----
    StreakcastWarning
        Visits have numbers that are missing or out of range; or their ``sunAlt`` contradicts the scale.
    """
    scale = scale_of(model, mjd_scale)
    warn_of_sun(visits, scale, model.site)
    target, rotation, bands = pointings(visits)
    options: dict[str, Any] = {"rotation": rotation, "band": bands, "scale": scale, "output": "dict"}
    return dict(model.flag(target, visits["mjd"], visits["exptime"], keep_invalid=True, **options))


def annotate(
    opsim: Union[str, "os.PathLike[str]"],
    output: Union[str, "os.PathLike[str]"],
    model: StreakModel,
    *,
    mjd_scale: Union[str, None] = None,
    replace: bool = False,
) -> int:
    """Copies an opsim database, and adds tables of streaks, as `StreakModel.annotate`. Existing tables are not changed.

    The copy has the tables ``streak_flags`` (one row per visit), ``streaks`` (one row per visit and satellite) and
    ``streak_provenance``, and the view ``observations_streaks``, which joins the first to the observations. It is
    written atomically. Visits with NULL or values out of range have the verdict ``invalid`` and no other values.

    Parameters
    ----------
    opsim : path
        SQLite, with a table ``observations``.
    output : path
        Path of the copy.
    model : StreakModel
        Site, satellites and field.
    mjd_scale : {"utc", "tai", "tt"}, optional
        Scale of ``observationStartMJD`` (UTC in simulations). It must be given here or in the model.
    replace : bool
        Whether to replace tables of an earlier annotation; otherwise they are an error.

    Returns
    -------
    int
        Number of crossed visits.

    Raises
    ------
    ValueError
        A file, table, column or scale is missing, the file is no database, or the tables of an earlier annotation exist.

    Warns
    -----
    StreakcastWarning
        Visits are invalid, or a number belongs to several different visits (there is no view then).
    """
    path = Path(opsim)
    if path.is_file() and not _is_sqlite(path):
        raise ValueError(f"{path} is no opsim database (SQLite); StreakModel.annotate accepts other formats")
    model.annotate(opsim, output, scale=scale_of(model, mjd_scale), replace=replace)
    with contextlib.closing(sqlite3.connect(output)) as base:
        (crossed,) = base.execute("SELECT count(*) FROM streak_flags WHERE n_streaks > 0").fetchone()
    return int(crossed)


def _is_sqlite(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(len(SQLITE)) == SQLITE
