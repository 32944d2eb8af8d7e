"""Summary of an annotated survey: by year, band and altitude of the Sun, and as HEALPix maps."""

from __future__ import annotations

import contextlib
import os
import sqlite3
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Optional, Union

import healpy
import numpy as np
import numpy.typing as npt
from rubin_scheduler.utils import Site as RubinSite
from streakcast import Site, StreakcastWarning

from ._checks import at_least
from ._exchanges import of_visits
from ._verdicts import is_date, sun_altitude_deg

#: Borders of the bins in the altitude of the Sun, degrees.
SUN_EDGES_DEG = (-90.0, -18.0, -15.0, -12.0, 0.0)
#: Verdicts of visits whose streaks are not known.
UNJUDGED = ("unknown", "invalid")
#: Radius of the LSST camera's field of view, degrees.
FIELD_RADIUS_DEG = 1.75
#: Columns of ``observations``, with their units or formats in astropy, and of ``streak_flags`` that are read.
OBSERVATIONS = {"fieldRA": "deg", "fieldDec": "deg", "observationStartMJD": "mjd", "visitExposureTime": "s", "sunAlt": "deg"}
FLAGS = ("verdict", "n_streaks", "expected_lost_pixel_fraction", "streak_cost_s")

#: Column of ``observations`` that is read if the table has it: the identifier of a visit in the scheduler.
TARGET = "target_id"

#: Name of the lost fraction of pixels in the tables of `streakcast.dask` without next starts.
OF_DASK = {"expected_lost_pixel_fraction": "lost_fraction"}
#: Band of visits whose band is missing.
UNKNOWN_BAND = "unknown"
#: Largest difference between the start of a visit and that of its flags, days: more than that of time scales.
SAME_START_DAY = 100.0 / 86_400.0
#: Columns of a row of `survey_summary`: effects on the visits of known effects.
EFFECTS = ("streaked_fraction", "bright_fraction", "avoid_fraction", "streak_cost_s", "streak_cost_fraction", "lost_pixel_fraction", "coadd_loss_mag")

Columns = Mapping[str, Any]
Annotated = Union[str, "os.PathLike[str]", Sequence[Columns]]


def survey_summary(
    annotated: Annotated,
    *,
    sun_edges_deg: Sequence[float] = SUN_EDGES_DEG,
    exchanges: Union[Columns, str, "os.PathLike[str]", None] = None,
) -> dict[str, npt.NDArray[Any]]:
    """Returns the effects of streaks on a survey, by year, band and altitude of the Sun.

    Parameters
    ----------
    annotated : path or sequence of tables
        Database that `annotate` or ``streakcast annotate`` wrote; or the visits given to `streakcast.dask.annotate`, with
        the columns of an opsim database, and what `streakcast.dask.read` and, optionally, `streakcast.dask.read_streaks` return.
    sun_edges_deg : sequence of float
        Ascending borders of the bins in ``sunAlt``, the altitude of the Sun, degrees. If the visits have no such column, the
        altitude is computed for Rubin's site, with the times in UTC.
    exchanges : mapping of columns or path, optional
        ``exchanges`` of the `StreakQueueManager` of the survey, or a file of its `write_exchanges`. An exchange is that of
        the visit of its band with its ``target_id`` that starts at most 60 s from the predicted shutter opening; or, if the
        table of visits has no different ``target_id``, of the nearest visit of its band, at most 10 s from it.

    Returns
    -------
    dict of arrays, ``(n_bins,)`` each
        One row for each year, band and bin with visits: ``year`` (from 1, of 365.25 days from the first visit),
        ``band`` (``unknown`` if it is missing), ``sun_min_deg``, ``sun_max_deg``, ``visits``, ``unknown_visits`` (verdict ``unknown`` or ``invalid``;
        the following columns are for the rest, and NaN if there are none), ``streaked_fraction``, ``bright_fraction``
        (expected fraction of visits with a streak that is brighter per pixel than that of a satellite at 550 km of the
        telescope's ``bright_mag``, by default 7; NaN without the table ``streaks``), ``avoid_fraction``,
        ``streak_cost_s`` (mean, seconds of open shutter), ``streak_cost_fraction`` (of the open shutter),
        ``lost_pixel_fraction`` (mean), and ``coadd_loss_mag``, the loss in depth of all visits of the row. With
        `exchanges` also ``exchanged_visits``, and sums over these, also of unknown effects: ``saved_s``, seconds of open
        shutter, and ``detour_s``, seconds of the night.

    Raises
    ------
    ValueError
        The database has no annotation, has one without a telescope, lacks a column, or repeats the number of a visit; or
        the visits are not those of the flags, or have ``sunAlt`` in radians; or the borders do not ascend; or the exchanges
        are invalid.

    Warns
    -----
    StreakcastWarning
        There are exchanges of no visit of the survey; or visits are in no row, because their start or the altitude of the
        Sun is missing or outside the bins.
    """
    edges = np.asarray(sun_edges_deg, dtype=float)
    if edges.ndim != 1 or len(edges) < 2 or not (np.diff(edges) > 0.0).all():
        raise ValueError(f"sun_edges_deg is {sun_edges_deg}; allowed: at least two ascending altitudes, degrees")
    visits = _read(annotated)
    start_mjd = visits["observationStartMJD"]
    dated = is_date(start_mjd)
    sun_alt_deg = _sun_altitudes_deg(visits)
    of_exchanges = {} if exchanges is None else of_visits(exchanges, start_mjd, visits["band"], visits.get(TARGET))
    year = np.zeros(len(start_mjd), dtype=int)
    if dated.any():
        year[dated] = (start_mjd[dated] - start_mjd[dated].min()) // 365.25 + 1
    sun_bin = np.digitize(sun_alt_deg, edges) - 1
    within = (sun_bin >= 0) & (sun_bin < len(edges) - 1) & dated
    outside = {"without a start": ~dated, "with the Sun outside the bins, or at an unknown altitude": dated & ~within}
    _warn_of_left_out(outside, "summary")
    keys = sorted({(int(one), str(band), int(each)) for one, band, each in zip(year[within], visits["band"][within], sun_bin[within])})
    rows = []
    for one, band, each in keys:
        chosen = (year == one) & (visits["band"] == band) & (sun_bin == each)
        known = chosen & visits["judged"]
        row = {"year": one, "band": band, "sun_min_deg": edges[each], "sun_max_deg": edges[each + 1]}
        row |= {"visits": int(chosen.sum()), "unknown_visits": int((chosen & ~known).sum())}
        row |= _effects({name: column[known] for name, column in visits.items()})
        rows.append(row | {name: column[chosen].sum() for name, column in of_exchanges.items()})
    columns = ("year", "band", "sun_min_deg", "sun_max_deg", "visits", "unknown_visits", *EFFECTS, *of_exchanges)
    return {name: np.array([row[name] for row in rows]) for name in columns}


def survey_maps(annotated: Annotated, *, nside: int = 64, field_radius_deg: float = FIELD_RADIUS_DEG) -> dict[str, npt.NDArray[Any]]:
    """Returns the effects of streaks on a survey as HEALPix maps in RING order, NaN outside the survey.

    Parameters
    ----------
    annotated : path or sequence of tables
        Database that `annotate` or ``streakcast annotate`` wrote; or the visits given to `streakcast.dask.annotate`, with
        the columns of an opsim database, and what `streakcast.dask.read` and, optionally, `streakcast.dask.read_streaks` return.
    nside : int
        Resolution of the maps.
    field_radius_deg : float
        Radius of the field of view, degrees: a visit counts in each pixel whose centre it contains.

    Returns
    -------
    dict of arrays, ``(12 nside²,)`` each
        ``visits`` (0 outside the survey), ``streaked_fraction``, ``bright_fraction``, ``streak_cost_s`` (mean),
        ``streak_cost_fraction`` and ``coadd_loss_mag``, as in `survey_summary`. Visits of unknown effects do not count.

    Raises
    ------
    ValueError
        The database has no annotation or lacks a column, the visits are not those of the flags, or the radius is out of
        range.

    Warns
    -----
    StreakcastWarning
        Visits have no coordinates.
    """
    at_least("field_radius_deg", field_radius_deg, 1e-4, 90.0)
    every = _read(annotated)
    placed = np.isfinite(every["fieldRA"]) & (np.abs(every["fieldDec"]) <= 90.0)
    _warn_of_left_out({"without coordinates": every["judged"] & ~placed}, "maps")
    visits = {name: column[every["judged"] & placed] for name, column in every.items()}
    sums = {name: np.zeros(healpy.nside2npix(nside)) for name in ("visits", "streaked", "bright", "cost_s", "open_s")}
    centres = healpy.ang2vec(visits["fieldRA"], visits["fieldDec"], lonlat=True)
    streaked, cost_s = visits["n_streaks"] > 0, visits["streak_cost_s"]
    for index, centre in enumerate(centres):
        pixels = healpy.query_disc(nside, centre, np.radians(field_radius_deg))
        sums["visits"][pixels] += 1
        sums["streaked"][pixels] += streaked[index]
        sums["bright"][pixels] += visits["p_bright"][index]
        sums["cost_s"][pixels] += cost_s[index]
        sums["open_s"][pixels] += visits["visitExposureTime"][index]
    with np.errstate(invalid="ignore", divide="ignore"):
        lost = sums["cost_s"] / sums["open_s"]
        return {
            "visits": sums["visits"],
            "streaked_fraction": sums["streaked"] / sums["visits"],
            "bright_fraction": sums["bright"] / sums["visits"],
            "streak_cost_s": sums["cost_s"] / sums["visits"],
            "streak_cost_fraction": lost,
            # A coadded image of visits without open shutter that is left has no depth.
            "coadd_loss_mag": -1.25 * np.log10(np.maximum(1.0 - lost, 0.0)),
        }


def _effects(visits: dict[str, npt.NDArray[Any]]) -> dict[str, float]:
    """Returns the effects of streaks on visits whose effects are known."""
    if not len(visits["verdict"]):
        return dict.fromkeys(EFFECTS, np.nan)
    lost = visits["streak_cost_s"].sum() / visits["visitExposureTime"].sum()
    return {
        "streaked_fraction": float((visits["n_streaks"] > 0).mean()),
        "bright_fraction": float(visits["p_bright"].mean()),
        "avoid_fraction": float((visits["verdict"] == "avoid").mean()),
        "streak_cost_s": float(visits["streak_cost_s"].mean()),
        "streak_cost_fraction": float(lost),
        "lost_pixel_fraction": float(visits["expected_lost_pixel_fraction"].mean()),
        # Depth of a coadded image: 1.25 log10(sum of t), with the time t - C of each visit.
        "coadd_loss_mag": float(-1.25 * np.log10(1.0 - lost)) if lost < 1.0 else np.inf,
    }


def _warn_of_left_out(left_out: Mapping[str, npt.NDArray[np.bool_]], what: str) -> None:
    """Issues a warning with the numbers of visits that are left out, by reason."""
    counts = [f"{int(of_reason.sum()):,} {reason}" for reason, of_reason in left_out.items() if of_reason.any()]
    if counts:
        visits = len(next(iter(left_out.values())))
        warnings.warn(f"visits that are not in the {what}: {', '.join(counts)} (of {visits:,})", StreakcastWarning, stacklevel=3)


def _sun_altitudes_deg(visits: dict[str, npt.NDArray[Any]]) -> npt.NDArray[np.float64]:
    """Returns the altitudes of the Sun; NaN if they are unknown."""
    given = visits.get("sunAlt")
    # A column that was not filled contains zeros.
    if given is not None and not (given == 0.0).all():
        known = given[np.isfinite(given)]
        if known.size and (np.abs(known) < np.pi / 2.0).all() and known.min() < -0.1:
            raise ValueError(f"sunAlt is {known.min():g} to {known.max():g}; allowed: degrees (these are radians)")
        return given
    lsst, start_mjd = RubinSite("LSST"), visits["observationStartMJD"]
    site = Site("Rubin", lsst.latitude, lsst.longitude, lsst.height)
    altitude_deg, dated = np.full(len(start_mjd), np.nan), is_date(start_mjd)
    if dated.any():
        altitude_deg[dated] = sun_altitude_deg(start_mjd[dated], "utc", site)
    return altitude_deg


def _p_bright(streaks: Sequence[tuple[Any, Any, Any]]) -> dict[str, float]:
    """Returns the probability of each visit to have a bright streak, for visits with streaks, from visit, probability and
    ``p_bright`` of each streak."""
    none_bright: dict[str, float] = {}
    # `p_bright` is that of a streak, if there is one; near misses are in the table too.
    for visit, probability, p_bright in streaks:
        bright = np.nan if probability is None or p_bright is None else probability * p_bright
        none_bright[str(visit)] = none_bright.get(str(visit), 1.0) * (1.0 - bright)
    return {visit: 1.0 - none for visit, none in none_bright.items()}


def _read(annotated: Annotated) -> dict[str, npt.NDArray[Any]]:
    """Returns the columns of all visits; ``judged`` is true if the effects of streaks on a visit are known."""
    if isinstance(annotated, (str, os.PathLike)):
        path = Path(annotated)
        columns, p_bright = _of_database(path)
        origin = f"{path}: "
    elif isinstance(annotated, Mapping) or len(annotated) not in (2, 3):
        raise ValueError("allowed: the path of a database, or two or three tables: visits, flags, and streaks")
    else:
        columns, p_bright = _of_tables(*annotated)
        origin = ""
    visits = columns.pop("observationId")
    columns["p_bright"] = [None if p_bright is None else p_bright.get(str(one), 0.0) for one in visits]
    columns["band"] = [one if isinstance(one, str) else UNKNOWN_BAND for one in columns["band"]]
    texts = {name: np.array([str(one) for one in columns.pop(name)], dtype=object) for name in ("verdict", "band")}
    numbers = {name: np.array([one if isinstance(one, (int, float)) else np.nan for one in column], dtype=float) for name, column in columns.items()}
    known = ~np.isin(texts["verdict"], (*UNJUDGED, "None"))
    if known.any() and np.isnan(numbers["streak_cost_s"][known]).all():
        raise ValueError(f"{origin}the annotation has no streak_cost_s; allowed: an annotation with a telescope (for example --telescope rubin)")
    finite = np.isfinite(numbers["streak_cost_s"]) & np.isfinite(numbers["n_streaks"]) & np.isfinite(numbers["visitExposureTime"])
    return {**numbers, **texts, "judged": finite & known}


def _cells(column: Any, rows: npt.NDArray[np.int64]) -> list[Any]:
    """Returns cells of a column; `None` for those that are masked."""
    column = column.to_numpy() if hasattr(column, "to_numpy") else column
    if hasattr(column, "unmasked"):
        # A masked array of astropy.
        column = np.ma.MaskedArray(np.asarray(column.unmasked), mask=column.mask)
    cells: list[Any] = np.ma.asarray(column)[rows].tolist()
    return cells


def _read_columns(has: Any) -> list[str]:
    """Returns the columns of visits that are read from a table with the columns `has`."""
    return [name for name in OBSERVATIONS if name != "sunAlt" or name in has]


def _of_database(path: Path) -> tuple[dict[str, Sequence[Any]], Optional[dict[str, float]]]:
    """Returns the columns of all visits of a database, and the probabilities of `_p_bright`; `None` if these are unknown."""
    if not path.is_file():
        raise ValueError(f"{path} is not a file; allowed: a database that streakcast annotate wrote")
    try:
        with contextlib.closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as base:
            of_flags, has, of_streaks = ([row[1] for row in base.execute(f"PRAGMA table_info({name})")] for name in ("streak_flags", "observations", "streaks"))
            if not of_flags:
                raise ValueError(f"{path} has no table streak_flags; allowed: a database that streakcast annotate wrote")
            band, read = "band" if "band" in has else "filter", _read_columns(has)
            missing = [name for name in ("observationId", *read, band) if name not in has]
            missing += [name for name in ("exposure_id", *FLAGS) if name not in of_flags]
            if missing:
                raise ValueError(f"{path}: missing column {', '.join(missing)}")
            repeated = "SELECT exposure_id FROM streak_flags GROUP BY exposure_id HAVING count(*) > 1 LIMIT 1"
            for (number,) in base.execute(repeated):
                raise ValueError(f"{path}: observationId {number} has several different visits; allowed: unique numbers")
            targets = [TARGET] if TARGET in has else []
            selected = ", ".join([*(f"o.{name}" for name in ("observationId", *read, band, *targets)), *(f"f.{name}" for name in FLAGS)])
            has_streaks = {"exposure_id", "probability", "p_bright"} <= set(of_streaks)
            streaks = base.execute("SELECT exposure_id, probability, p_bright FROM streaks").fetchall() if has_streaks else None
            # A visit that is repeated in all columns counts once.
            rows = base.execute(f"SELECT DISTINCT {selected} FROM observations o LEFT JOIN streak_flags f ON o.observationId = f.exposure_id").fetchall()
    except sqlite3.Error as error:
        raise ValueError(f"{path}: {error}") from error
    names = ("observationId", *read, "band", *targets, *FLAGS)
    columns: dict[str, Sequence[Any]] = dict(zip(names, zip(*rows) if rows else ((),) * len(names)))
    return columns, None if streaks is None else _p_bright(streaks)


def _of_tables(visits: Columns, flags: Columns, streaks: Optional[Columns] = None) -> tuple[dict[str, Sequence[Any]], Optional[dict[str, float]]]:
    """Returns the same from the tables of `streakcast.dask`."""
    names = set(visits.keys())
    band, read = "band" if "band" in names else "filter", _read_columns(names)
    of_flags = {name: name if name in flags else OF_DASK.get(name, name) for name in FLAGS}
    missing = [name for name in (*read, band) if name not in names]
    missing += [name for name in ("visit", *of_flags.values()) if name not in flags]
    missing += [name for name in ("visit", "probability", "p_bright") if streaks is not None and name not in streaks]
    if missing:
        raise ValueError(f"missing column {', '.join(missing)}")
    rows, count = np.asarray(flags["visit"], dtype=int), len(np.asarray(visits[band]))
    if len(rows) != count:
        raise ValueError(f"the flags are those of {len(rows):,} visits, but there are {count:,}; allowed: the visits given to streakcast.dask.annotate")
    if not np.array_equal(np.sort(rows), np.arange(count)):
        raise ValueError(f"the column visit of the flags does not contain each row of the visits once; allowed: the table of streakcast.dask.read")
    columns: dict[str, Sequence[Any]] = {"observationId": rows.tolist()}
    for name in read:
        unit = OBSERVATIONS[name]
        column = visits[name]
        if getattr(column, "unit", None) is not None:
            column = getattr(column, "quantity", column)
        columns[name] = _cells(column.to_value(unit) if hasattr(column, "to_value") else column, rows)
    for name, column in (("band", band), (TARGET, TARGET)):
        if column in names:
            columns[name] = _cells(visits[column], rows)
    if "start_mjd_tai" in flags:
        starts = np.array([np.nan if one is None else one for one in columns["observationStartMJD"]], dtype=float)
        apart_day = np.abs(starts - np.asarray(flags["start_mjd_tai"], dtype=float))
        if (apart_day > SAME_START_DAY).any():
            row = int(rows[np.argmax(apart_day > SAME_START_DAY)])
            raise ValueError(f"visit {row} is not the one of its flags: their starts differ; allowed: the visits given to streakcast.dask.annotate, in the same order")
    for name, of_flag in of_flags.items():
        columns[name] = np.ma.asarray(flags[of_flag]).tolist()
    of_streaks = None if streaks is None else [np.ma.asarray(streaks[name]).tolist() for name in ("visit", "probability", "p_bright")]
    return columns, None if of_streaks is None else _p_bright(list(zip(*of_streaks)))
