"""Streaks in the visits of a survey: columns for arrays, and tables in opsim databases."""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import sqlite3
from pathlib import Path
from typing import Any, Union

import numpy as np
from streakcast import StreakModel

from ._arrays import Visits
from ._verdicts import pointings, scale_of

#: Columns of the table with one row per visit.
FLAG_COLUMNS = {
    "observationId": "INTEGER",
    "verdict": "TEXT",
    "n_streaks": "INTEGER",
    "streak_length_deg": "REAL",
    "brightest_mag": "REAL",
    "expected_lost_pixel_fraction": "REAL",
    "p_any": "REAL",
    "p_crossing": "REAL",
    "norad_ids": "TEXT",
    "streak_cost_s": "REAL",
}
#: Columns of the table with one row per visit and satellite.
PASS_COLUMNS = {
    "norad_id": "INTEGER",
    "name": "TEXT",
    "magnitude_peak": "REAL",
    "magnitude_peak_sigma": "REAL",
    "magnitude_sigma": "REAL",
    "mag_source": "TEXT",
    "effective_magnitude": "REAL",
    "streak_length_deg": "REAL",
    "width_arcsec": "REAL",
    "min_separation_deg": "REAL",
    "probability": "REAL",
    "streak_cost_s": "REAL",
}
#: Longest exposure, seconds.
LONGEST_S = 86_400.0
#: Times within the years of which streakcast knows the time scales.
MJD_RANGE = (35_840.0, 88_068.0)
TABLES = ("streak_flags", "streaks", "streak_provenance", "observations_streaks")


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
        As `StreakModel.flags`: ``verdict``, ``n_streaks``, ``brightest_mag``, ``expected_lost_pixel_fraction``,
        ``p_any``, ``streak_length_deg``, ``norad_ids`` and more.
    """
    scale = scale_of(model, mjd_scale)
    target, rotation, bands = pointings(visits)
    found = model.flags(target, visits["mjd"], visits["exptime"], rotation=rotation, band=bands, scale=scale, output="dict")
    return dict(found)


def annotate(
    opsim: Union[str, "os.PathLike[str]"],
    output: Union[str, "os.PathLike[str]"],
    model: StreakModel,
    *,
    mjd_scale: Union[str, None] = None,
    replace: bool = False,
) -> int:
    """Copies an opsim database, and adds tables of streaks. Existing tables are not changed.

    The copy has the tables ``streak_flags`` (one row per visit), ``streaks`` (one row per visit and satellite) and
    ``streak_provenance``, and the view ``observations_streaks``, which joins the first to the observations. It is
    written atomically. Visits with NULL or values out of range have the verdict ``invalid`` and no other values.

    Parameters
    ----------
    opsim : path
        SQLite, with a table ``observations``.
    output : path
        Path of the copy. It must differ from `opsim`.
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
        A file, table, column or scale is missing, a number belongs to several different visits, or the tables of an
        earlier annotation exist.
    """
    source, target = Path(opsim), Path(output)
    scale = scale_of(model, mjd_scale)
    if not source.is_file():
        raise ValueError(f"{source} is not a file; allowed: an opsim database")
    if target.exists() and source.samefile(target):
        raise ValueError(f"output {target} is the database; allowed: another file")
    part = _new_file_beside(target)
    try:
        with contextlib.closing(sqlite3.connect(f"{source.resolve().as_uri()}?mode=ro", uri=True)) as old:
            with contextlib.closing(sqlite3.connect(part)) as new:
                old.backup(new)
                new.execute("PRAGMA journal_mode = DELETE")
                crossed = _add_tables(new, source, model, scale, replace)
                new.commit()
        os.replace(part, target)
    except sqlite3.Error as error:
        raise ValueError(f"{source}: {error}") from error
    finally:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(part)
    return crossed


def _new_file_beside(target: Path) -> Path:
    """Creates an empty file with a unique name and default permissions (`tempfile` gives access only to the user)."""
    while True:
        part = target.parent / f".{target.name}.{secrets.token_hex(4)}.part"
        with contextlib.suppress(FileExistsError):
            os.close(os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
            return part


def _add_tables(base: sqlite3.Connection, source: Path, model: StreakModel, scale: str, replace: bool) -> int:
    marks = ", ".join("?" for _ in TABLES)
    for name, kind in base.execute(f"SELECT name, type FROM sqlite_master WHERE name IN ({marks})", TABLES).fetchall():
        if not replace:
            raise ValueError(f"{source} has a {kind} {name} already; specify replace=True to replace it")
        base.execute(f"DROP {kind} {name}")
    columns = [row[1] for row in base.execute("PRAGMA table_info(observations)")]
    # Databases from before version 4 of the scheduler have the column filter.
    band = "band" if "band" in columns else "filter"
    required = ["observationId", "fieldRA", "fieldDec", "observationStartMJD", "visitExposureTime", "rotSkyPos", band]
    missing = [name for name in required if name not in columns]
    if missing:
        raise ValueError(f"{source}: missing column {', '.join(missing)} in observations, which has {', '.join(columns) or 'none'}")
    # Repeated rows have one row in the added tables; those without a number cannot be joined to any.
    query = f"SELECT DISTINCT {', '.join(required)} FROM observations WHERE observationId IS NOT NULL ORDER BY observationId"
    rows = base.execute(query).fetchall()
    numbers = [int(row[0]) for row in rows]
    repeated = next((one for one, next_one in zip(numbers, numbers[1:]) if one == next_one), None)
    if repeated is not None:
        raise ValueError(f"{source}: observationId {repeated} has several different visits; allowed: unique numbers")
    ra, dec, mjd, length, rotation = (np.array([_number(row[one]) for row in rows]) for one in range(1, 6))
    valid = (mjd > MJD_RANGE[0]) & (mjd < MJD_RANGE[1]) & (ra >= -180.0) & (ra <= 360.0) & (np.abs(dec) <= 90.0) & (length >= 0.0) & (length <= LONGEST_S)
    used = np.flatnonzero(valid)
    exposures: tuple[Any, ...] = ((ra[used], dec[used]), mjd[used], length[used])
    options: dict[str, Any] = {"rotation": np.nan_to_num(rotation[used]), "band": [str(rows[one][6]) for one in used]}
    options |= {"scale": scale, "output": "dict"}
    flags: dict[str, Any] = dict(model.flags(*exposures, **options)) if used.size else {}
    passes: dict[str, Any] = dict(model.passes(*exposures, **options)) if used.size else {}
    judged = [numbers[one] for one in used]
    _write(base, "streak_flags", FLAG_COLUMNS, {**flags, "observationId": judged}, used.size)
    invalid = [(numbers[one], "invalid") for one in np.flatnonzero(~valid)]
    base.executemany("INSERT INTO streak_flags (observationId, verdict) VALUES (?, ?)", invalid)
    crossing = [judged[int(one)] for one in passes.get("exposure_id", [])]
    _write(base, "streaks", {"observationId": "INTEGER", **PASS_COLUMNS}, {**passes, "observationId": crossing}, len(crossing))
    base.execute("CREATE INDEX streaks_observationId ON streaks (observationId)")
    base.execute("CREATE TABLE streak_provenance (key TEXT, value TEXT)")
    provenance: dict[str, Any] = dict(model.provenance(float(mjd[used[0]]), scale=scale)) if used.size else {}
    provenance["mjd_scale"] = scale
    base.executemany("INSERT INTO streak_provenance VALUES (?, ?)", [(key, json.dumps(value, default=str)) for key, value in provenance.items()])
    added = ", ".join(f"f.{name}" for name in FLAG_COLUMNS if name != "observationId")
    base.execute(f"CREATE VIEW observations_streaks AS SELECT o.*, {added} FROM observations o LEFT JOIN streak_flags f USING (observationId)")
    return sum(int(one) > 0 for one in flags.get("n_streaks", []))


def _write(base: sqlite3.Connection, name: str, kinds: dict[str, str], columns: dict[str, Any], rows: int) -> None:
    base.execute(f"CREATE TABLE {name} ({', '.join(f'{column} {kind}' for column, kind in kinds.items())})")
    cells = [[_cell(one, kind) for one in columns.get(column, [None] * rows)] for column, kind in kinds.items()]
    base.executemany(f"INSERT INTO {name} VALUES ({', '.join('?' for _ in kinds)})", list(zip(*cells)))


def _number(value: Any) -> float:
    """Converts a cell; NULL and text become NaN."""
    return float(value) if isinstance(value, (int, float)) else np.nan


def _cell(value: Any, kind: str) -> Any:
    """Converts a value for SQLite; missing values become NULL."""
    if value is None or value is np.ma.masked:
        return None
    if kind == "TEXT":
        return str(value) if isinstance(value, str) else " ".join(str(one) for one in np.ravel(value))
    number = float(value)
    return None if not np.isfinite(number) else int(number) if kind == "INTEGER" else number
