"""Verdicts on the visits of a survey, computed on a Dask cluster; requires ``distributed`` and ``pyarrow``."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from . import _core
from ._quantities import number
from ._times import TwoPartTai, to_tai
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


def annotate(
    visits: VisitsLike,
    model: StreakModel,
    client: Client,
    folder: PathLike,
    *,
    scale: str | None = None,
    retries: int = 3,
) -> list[Path]:
    """Computes the verdicts on the visits of a survey, and writes one Parquet file per night.

    Each night is one task. The worker reads the files of the model from their paths (once per worker), uses one thread,
    and writes the file of the night atomically. Nights with a valid file for the same visits and model are skipped, so
    that an interrupted run can be resumed. If a worker is lost, its task is run again and its temporary file is
    deleted.

    Parameters
    ----------
    visits : mapping of columns
        ``ra_deg, dec_deg, start, exposure_s`` and, optionally, ``rotation_deg, band``: arrays ``(n,)``, a `QTable` or a
        data frame.
    model : StreakModel
        Model to use. All workers must be able to read its files from the same paths.
    client : distributed.Client
        Client of the cluster.
    folder : path
        Folder of the files ``night-<number>.parquet``, on a file system that all workers can use.
    scale : {"utc", "tai", "tt"}, optional
        Scale of bare numbers (MJD) in ``start``; default: the model's ``mjd_scale``.
    retries : int
        Number of further attempts for a failed night.

    Returns
    -------
    list of Path
        Files of the nights in time order. Columns ``visit`` (row in ``visits``), ``verdict``, ``n_streaks``,
        ``brightest_mag``, ``lost_fraction``, ``p_any``, ``streak_length_deg``, ``p_any_is_lower_limit``,
        ``p_crossing``, ``elements_age_days``, ``late_s`` and ``streak_cost_s``; `read` returns all nights in one table.

    Raises
    ------
    ValueError
        A column is missing, or columns differ in length.
    """
    missing = [name for name in COLUMNS if name not in _names(visits)]
    if missing:
        raise ValueError(f"missing columns of visits {', '.join(missing)}; allowed: all of {', '.join(COLUMNS)}")
    jd1, jd2 = to_tai(_column(visits, "start"), model.mjd_scale if scale is None else scale, "start")
    columns: Columns = {"jd1": np.ravel(jd1), "jd2": np.ravel(jd2)}
    for name, unit in (("ra_deg", "deg"), ("dec_deg", "deg"), ("exposure_s", "s"), ("rotation_deg", "deg")):
        if name in _names(visits):
            columns[name] = np.ravel(number(_column(visits, name), unit, name))
    if "band" in _names(visits):
        columns["band"] = np.ravel(np.asarray(_column(visits, "band"), dtype=np.str_))
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError(f"columns of visits differ in length: {lengths}; allowed: columns of one length")

    output = Path(folder).absolute()
    output.mkdir(parents=True, exist_ok=True)
    nights = np.array([model.night(TwoPartTai(first, second)) for first, second in zip(columns["jd1"], columns["jd2"])], dtype=np.int64)
    files, tasks = [], []
    for night in np.unique(nights):
        rows = np.flatnonzero(nights == night)
        part = {name: column[rows] for name, column in columns.items()}
        path = output / f"night-{int(night):05d}.parquet"
        key = _digest(part, rows, model)
        files.append(path)
        if not _is_done(path, key):
            tasks.append(
                client.submit(_one_night, part, rows, model, str(path), key, retries=retries, key=f"night-{int(night)}-{key[:16]}")
            )
    client.gather(tasks)  # type: ignore[no-untyped-call]
    # Deletes temporary files of lost workers. If that fails, the results are not affected.
    prefixes = tuple(_scratch_prefix(path) for path in files)
    for partial in [path for path in output.glob(".night-*") if path.name.startswith(prefixes)]:
        with suppress(OSError):
            partial.unlink()
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
    import pyarrow
    import pyarrow.parquet

    table = pyarrow.concat_tables([pyarrow.parquet.read_table(path).replace_schema_metadata() for path in files])
    columns = {name: table[name].to_numpy() for name in table.column_names}
    order = np.argsort(columns["visit"], kind="stable")
    return {name: column[order] for name, column in columns.items()}


def _names(visits: VisitsLike) -> list[str]:
    return [str(name) for name in visits.keys()]


def _column(visits: VisitsLike, name: str) -> object:
    column = visits[name]
    # Columns of a data frame are not NumPy arrays.
    return column.to_numpy() if hasattr(column, "to_numpy") else column


def _digest(part: Columns, rows: npt.NDArray[np.int64], model: StreakModel) -> str:
    """Returns a hash of all data that determine the result of a night."""
    digest = hashlib.sha256(json.dumps([_core.__version__, model.key()]).encode())
    for name, column in sorted({**part, "visit": rows}.items()):
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(column).tobytes())
    return digest.hexdigest()


def _is_done(path: Path, key: str) -> bool:
    import pyarrow
    import pyarrow.parquet

    try:
        metadata = pyarrow.parquet.read_schema(path).metadata or {}
    except (OSError, pyarrow.ArrowInvalid):
        return False
    return bool(metadata.get(b"streakcast_visits") == key.encode())


def _scratch_prefix(path: Path) -> str:
    return f".{path.name}."


def _one_night(part: Columns, rows: npt.NDArray[np.int64], model: StreakModel, path: str, key: str) -> int:
    """Writes the verdicts of one night, in a worker. Returns the number of visits."""
    import pyarrow
    import pyarrow.parquet

    # Dask distributes the cores among workers. This is effective only before the first computation in this process.
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    verdicts = model.assess(
        (part["ra_deg"], part["dec_deg"]),
        TwoPartTai(part["jd1"], part["jd2"]),
        part["exposure_s"],
        rotation=part.get("rotation_deg", 0.0),
        band=part.get("band"),
    )
    names = [name for name in verdicts._fields if name != "crosses"]
    table = pyarrow.table({"visit": rows, **{name: getattr(verdicts, name) for name in names}})
    table = table.replace_schema_metadata({"streakcast_visits": key, "streakcast_version": _core.__version__})
    target = Path(path)
    with tempfile.NamedTemporaryFile(dir=target.parent, prefix=_scratch_prefix(target), delete=False) as scratch:
        try:
            pyarrow.parquet.write_table(table, scratch)
            scratch.flush()
            os.fsync(scratch.fileno())
        except BaseException:
            os.unlink(scratch.name)
            raise
    os.replace(scratch.name, target)
    return len(rows)
