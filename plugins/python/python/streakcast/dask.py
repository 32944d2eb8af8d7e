"""Verdicts on the visits of a survey, computed on a Dask cluster; requires ``distributed`` and ``pyarrow``."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from . import _core
from ._exposure_queries import invalid_numbers
from ._quantities import aligned, number
from ._results import UNJUDGED
from ._state import without_numbers
from ._times import TwoPartTai, is_time, to_tai_or_nan
from ._warnings import handle_warnings, warn
from .model import StreakModel
from .typing import Columns, PathLike

if TYPE_CHECKING:
    from distributed import Client


class VisitsLike(Protocol):
    """Table of visits: a dictionary of arrays, a `QTable` or a data frame."""

    def keys(self) -> Iterable[str]:
        """Returns the names of the columns."""

    def __getitem__(self, name: str, /) -> object: ...


#: Required columns of a table of visits.
COLUMNS = ("ra_deg", "dec_deg", "start", "exposure_s")
#: Julian date of MJD 0.
MJD_ZERO_JD = 2_400_000.5
#: Column of the starts of visits, MJD, in opsim databases.
OPSIM_START = "observationStartMJD"
#: Columns of a table ``observations`` of Rubin's opsim databases that have the meaning of the others.
OPSIM = {
    "fieldRA": "ra_deg",
    "fieldDec": "dec_deg",
    OPSIM_START: "start",
    "visitExposureTime": "exposure_s",
    "rotSkyPos": "rotation_deg",
    "filter": "band",
}


def annotate(
    visits: VisitsLike,
    model: StreakModel,
    client: Client,
    folder: PathLike,
    *,
    scale: str | None = None,
    streaks: bool = False,
    next_starts: bool = False,
    retries: int = 3,
) -> list[Path]:
    """Computes the verdicts on the visits of a survey, and writes one Parquet file per night.

    Visits with missing numbers, or numbers out of range, have the verdict ``invalid``.

    Each night is one task. The worker reads the files of the model from their paths (once per worker), uses one thread,
    and writes the file of the night atomically. Nights with a valid file for the same visits, model and options are
    skipped, so that an interrupted run can be resumed. If a worker is lost, its task is run again and its temporary file
    is deleted.

    Parameters
    ----------
    visits : mapping of columns
        ``ra_deg, dec_deg, start, exposure_s`` and, optionally, ``rotation_deg, band``: arrays ``(n,)``, a `QTable` or a
        data frame. The columns of ``observations`` in opsim databases (``fieldRA, fieldDec, observationStartMJD,
        visitExposureTime, rotSkyPos, band`` or ``filter``) are read as they are. A visit of several snaps
        (``numExposures`` or ``nexp``) lasts ``visitTime``; one whose number of snaps is missing or 0, the longer of
        both times.
    model : StreakModel
        Model to use. All workers must be able to read its files from the same paths.
    client : distributed.Client
        Client of the cluster.
    folder : path
        Folder of the files ``night-<number>.parquet``, on a file system that all workers can use.
    scale : {"utc", "tai", "tt"}, optional
        Scale of bare numbers (MJD) in ``start``; default: the model's ``mjd_scale``.
    streaks : bool
        Whether each night also has a file ``streaks-<number>.parquet`` with one row per visit and satellite: the columns
        of `StreakModel.passes`, with ``visit`` instead of ``exposure_id``.
    next_starts : bool
        Whether the columns of `StreakModel.flag` are written (reasons, next starts, numbers of the satellites) instead
        of those of `StreakModel.assess`. The search for next starts takes several times as long.
    retries : int
        Number of further attempts for a failed night.

    Returns
    -------
    list of Path
        Files of the nights in time order. Columns ``visit`` (row in ``visits``), ``verdict``, ``n_streaks``,
        ``brightest_mag``, ``lost_fraction``, ``p_any``, ``streak_length_deg``, ``p_any_is_lower_limit``,
        ``p_crossing``, ``elements_age_days``, ``late_s``, ``streak_cost_s`` (of the time with open shutter,
        ``visitExposureTime``, for visits of several snaps) and ``start_mjd_tai``; `read` returns all nights in one table,
        `read_streaks` all streaks.

    Warns
    -----
    StreakcastWarning
        The warnings of the workers, each once with the number of nights, also those of nights that were skipped; and
        visits with numbers that are missing or out of range; and the times of an opsim database, which are in UTC, are
        read in another scale.

    Raises
    ------
    ValueError
        A column is missing, columns differ in length, or there are no visits.
    TypeError
        `client` is no client of Dask.
    """
    _require_pyarrow()
    scale = model.mjd_scale if scale is None else scale
    columns = _columns(visits, model, scale)
    if not len(columns["jd1"]):
        raise ValueError("there are no visits; allowed: at least one")
    if not hasattr(client, "submit"):
        raise TypeError(f"client is of the type {type(client).__name__}; allowed: a distributed.Client")
    is_bare = "start" not in visits.keys() and not is_time(visits[OPSIM_START])
    if is_bare and scale not in (None, "utc"):
        warn(f"opsim databases have {OPSIM_START} in UTC, but it is read as {scale}: crossings are those of other times unless the file was converted")
    output = Path(folder).absolute()
    output.mkdir(parents=True, exist_ok=True)
    nights = _nights(columns, model)
    files, tasks = [], []
    for night in np.unique(nights):
        rows = np.flatnonzero(nights == night)
        part = {name: column[rows] for name, column in columns.items()}
        path = output / f"night-{int(night):05d}.parquet"
        key = _digest(part, rows, model, next_starts)
        files.append(path)
        if not (_is_done(path, key) and (not streaks or _is_done(_streaks_beside(path), key))):
            tasks.append(
                client.submit(
                    _one_night, part, rows, model, str(path), key, streaks, next_starts,
                    retries=retries, key=f"night-{int(night)}-{key[:16]}-{streaks:d}",
                )
            )
    client.gather(tasks)  # type: ignore[no-untyped-call]
    # Deletes temporary files of lost workers. If that fails, the results are not affected.
    prefixes = tuple(_scratch_prefix(path) for path in (*files, *map(_streaks_beside, files)))
    for partial in [path for path in output.iterdir() if path.name.startswith(prefixes)]:
        with suppress(OSError):
            partial.unlink()
    # Warnings of different nights may differ in their numbers and dates.
    similar: dict[str, dict[Path, str]] = {}
    for path in files:
        for message in _warnings_of(path):
            similar.setdefault(without_numbers(message), {}).setdefault(path, message)
    for by_night in similar.values():
        warn(f"{next(iter(by_night.values()))} ({len(by_night)} of {len(files)} nights)")
    for message in invalid_numbers(columns, "visits"):
        warn(message)
    return files


def read(files: Sequence[PathLike]) -> Columns:
    """Reads all nights into one table, in the order of the visits.

    Parameters
    ----------
    files : list of Path
        Return value of `annotate`.

    Returns
    -------
    dict of arrays, ``(n_visits,)`` each
    """
    return _read_all(files)


def read_streaks(files: Sequence[PathLike]) -> Columns:
    """Reads the streaks of all nights into one table, in the order of the visits.

    Parameters
    ----------
    files : list of Path
        Return value of `annotate` with ``streaks=True``.

    Returns
    -------
    dict of arrays, ``(n_streaks,)`` each

    Raises
    ------
    ValueError
        The streaks of a night are missing, or those of another run: the last run did not write them.
    """
    for path in map(Path, files):
        keys = [_metadata(one).get(b"streakcast_visits") for one in (path, _streaks_beside(path))]
        if keys[0] is None or keys[0] != keys[1]:
            raise ValueError(f"{path} has no streaks of the same run; allowed: files of annotate with streaks=True")
    return _read_all([_streaks_beside(Path(path)) for path in files])


def _require_pyarrow() -> None:
    """Raises an error that names the missing package."""
    try:
        import pyarrow  # noqa: F401
    except ImportError as error:
        needed = "streakcast.dask requires pyarrow, which writes and reads Parquet; install it with: pip install pyarrow"
        raise ImportError(needed) from error


def _read_all(files: Sequence[PathLike]) -> Columns:
    _require_pyarrow()
    import pyarrow
    import pyarrow.parquet

    if not files:
        raise ValueError("there are no files; allowed: the files of annotate, at least one")
    tables = [pyarrow.parquet.read_table(path).replace_schema_metadata() for path in files]
    # Lists of a night without streaks have no type.
    table = pyarrow.concat_tables(tables, promote_options="default")
    columns = {name: table[name].to_numpy() for name in table.column_names}
    order = np.argsort(columns["visit"], kind="stable")
    return {name: column[order] for name, column in columns.items()}


def _streaks_beside(path: Path) -> Path:
    return path.with_name(path.name.replace("night-", "streaks-"))


def _columns(visits: VisitsLike, model: StreakModel, scale: str | None) -> Columns:
    """Returns the columns of a table of visits as arrays of one length; missing numbers are NaN."""
    names = [str(name) for name in visits.keys()]
    table = {OPSIM.get(name, name) if OPSIM.get(name) not in names else name: _column(visits, name) for name in names}
    missing = [name for name in COLUMNS if name not in table]
    if missing:
        of_opsim = ", ".join(name for name, meaning in OPSIM.items() if meaning in COLUMNS)
        raise ValueError(
            f"missing columns of visits {', '.join(missing)}; allowed: all of {', '.join(COLUMNS)} (or of opsim's {of_opsim})"
        )
    columns: Columns = dict(zip(("jd1", "jd2"), map(np.ravel, to_tai_or_nan(table["start"], scale, "start"))))
    for name, unit in (("ra_deg", "deg"), ("dec_deg", "deg"), ("exposure_s", "s"), ("rotation_deg", "deg")):
        if name in table:
            columns[name] = _numbers(table[name], unit, name)
    if "exposure_s" not in names:
        columns["open_s"] = columns["exposure_s"]
        columns["exposure_s"] = _durations_s(table, columns["open_s"])
    default_deg = model._engine.default_rotation_deg
    rotation_deg = columns.get("rotation_deg", np.full(len(columns["jd1"]), np.nan))
    columns["rotation_deg"] = np.where(np.isnan(rotation_deg), default_deg, rotation_deg)
    if "band" in table:
        columns["band"] = np.ravel(np.asarray(table["band"], dtype=np.str_))
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError(f"columns of visits differ in length: {lengths}; allowed: columns of one length")
    return columns


def _numbers(column: object, unit: str, name: str) -> npt.NDArray[np.float64]:
    """Returns a column of numbers; missing ones are NaN."""
    return np.ravel(number(column, unit, name, keep_missing=True))


def _durations_s(table: dict[str, Any], open_s: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Returns the durations of visits whose shutter is open for `open_s`, as ``streakcast annotate``; NaN if they are
    unknown."""
    names = [name for name in ("numExposures", "nexp") if name in table][:1]
    snaps = np.broadcast_to(_numbers(table[names[0]], "", names[0]) if names else np.array(np.nan), open_s.shape)
    visit_s = _numbers(table["visitTime"], "s", "visitTime") if "visitTime" in table else np.array(np.nan)
    visit_s = np.broadcast_to(visit_s, open_s.shape)
    # If the number of snaps is not known, there may be several. Between snaps the camera is read out.
    is_several, is_one = snaps > 1.0, snaps == 1.0
    is_wrong = (snaps < 0.0) | (snaps > 1e6) | np.where(is_several, ~(visit_s >= open_s), ~is_one & (visit_s < 0.0))
    durations_s = np.where(is_several, visit_s, np.where(is_one, open_s, np.fmax(open_s, visit_s)))
    return np.where(open_s > 0.0, np.where(is_wrong, np.nan, durations_s), open_s)


def _nights(columns: Columns, model: StreakModel) -> npt.NDArray[np.int64]:
    """Returns the number of the night of each visit. Visits without a start are in the night of the visit before them."""
    known = np.isfinite(columns["jd1"])
    parts = zip(columns["jd1"][known], columns["jd2"][known])
    nights = np.array([model.night(TwoPartTai(first, second)) for first, second in parts], dtype=np.int64)
    if not len(nights):
        return np.zeros(len(known), dtype=np.int64)
    return np.asarray(nights[np.maximum(np.cumsum(known) - 1, 0)])


def _column(visits: VisitsLike, name: str) -> object:
    column = visits[name]
    # Columns of a data frame are not NumPy arrays.
    return column.to_numpy() if hasattr(column, "to_numpy") else column


def _digest(part: Columns, rows: npt.NDArray[np.int64], model: StreakModel, next_starts: bool) -> str:
    """Returns a hash of all data that determine the result of a night."""
    digest = hashlib.sha256(json.dumps([_core.__version__, model.key(), next_starts]).encode())
    for name, column in sorted({**part, "visit": rows}.items()):
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(column).tobytes())
    return digest.hexdigest()


def _metadata(path: Path) -> dict[bytes, bytes]:
    _require_pyarrow()
    import pyarrow
    import pyarrow.parquet

    try:
        return dict(pyarrow.parquet.read_schema(path).metadata or {})
    except (OSError, pyarrow.ArrowInvalid):
        return {}


def _is_done(path: Path, key: str) -> bool:
    return _metadata(path).get(b"streakcast_visits") == key.encode()


def _warnings_of(path: Path) -> list[str]:
    return [str(message) for message in json.loads(_metadata(path).get(b"streakcast_warnings", b"[]"))]


def _scratch_prefix(path: Path) -> str:
    return f".{path.name}."


def _one_night(
    part: Columns,
    rows: npt.NDArray[np.int64],
    model: StreakModel,
    path: str,
    key: str,
    streaks: bool,
    next_starts: bool,
) -> int:
    """Writes the verdicts of one night, and its streaks, in a worker. Returns the number of visits."""
    # Dask distributes the cores among workers. This is effective only before the first computation in this process.
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    # A worker judges many nights with one copy of the model, which issues each warning once. A new copy issues those of
    # this night again.
    model = model.with_options()
    exposures = {name: aligned(column) for name, column in part.items() if name != "band"}
    bands = part["band"].tolist() if "band" in part else []
    messages: list[str] = []
    with handle_warnings(messages.append):
        if next_starts:
            columns: dict[str, Any] = dict(model._flagged(exposures, bands, "dict", keep_invalid=True))
            del columns["exposure_id"]
        else:
            columns = model._judged(exposures, bands, keep_invalid=True)
            del columns["crosses"]
        if streaks:
            # Streaks of unknown positions would be an error.
            judged = np.flatnonzero(~np.isin(columns["verdict"], UNJUDGED))
            known = {name: column[judged] for name, column in exposures.items()}
            passes = dict(model._crossings(known, [bands[row] for row in judged] if bands else [], "dict"))
            crossed = rows[judged[np.asarray(passes.pop("exposure_id"), dtype=np.int64)]]
            _write(_streaks_beside(Path(path)), {"visit": crossed, **passes}, key, messages)
    # Identifies the visits of the rows, if tables are joined later.
    start_mjd_tai = (part["jd1"] - MJD_ZERO_JD) + part["jd2"]
    _write(Path(path), {"visit": rows, "start_mjd_tai": start_mjd_tai, **columns}, key, messages)
    return len(rows)


def _write(target: Path, columns: dict[str, Any], key: str, messages: list[str]) -> None:
    import pyarrow
    import pyarrow.parquet

    table = pyarrow.table({name: _plain(column) for name, column in columns.items()})
    stated = {"streakcast_visits": key, "streakcast_version": _core.__version__, "streakcast_warnings": json.dumps(messages)}
    table = table.replace_schema_metadata(stated)
    with tempfile.NamedTemporaryFile(dir=target.parent, prefix=_scratch_prefix(target), delete=False) as scratch:
        try:
            pyarrow.parquet.write_table(table, scratch)
            scratch.flush()
            os.fsync(scratch.fileno())
        except BaseException:
            os.unlink(scratch.name)
            raise
    os.replace(scratch.name, target)


def _plain(column: Any) -> Any:
    """Returns a column that Arrow can store: lists of a row stay lists, masked values are null."""
    if isinstance(column, np.ma.MaskedArray):
        return column
    return [list(one) if isinstance(one, (tuple, np.ndarray)) else one for one in column] if column.dtype == object else column
