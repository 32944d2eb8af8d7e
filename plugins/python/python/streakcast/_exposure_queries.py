"""Methods of `StreakModel` that need a field of view: verdicts, passes and clear windows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from . import _core
from ._results import FIRST_UNJUDGED, VERDICTS, Assessment, ClearWindows
from ._quantities import aligned, check_unmasked, count, directions, number, scalar
from ._setup import absolute
from ._site_queries import SiteQueries
from ._tables import FLAGS, PASSES, is_qtable, table_of, time_of
from ._times import to_tai, to_tai_or_nan
from .typing import (
    FloatArray,
    FloatArrayLike,
    FloatLike,
    Output,
    PathLike,
    Table,
    TargetLike,
    TextLike,
    TimeLike,
    TimeResult,
    WholeArray,
)

if TYPE_CHECKING:
    from ._core import Column, IntegerColumn, TextColumn

#: Accepted values of ``blocking``: choices of the satellites that block an exposure.
BLOCKING = ("any", "avoid")
#: Accepted values of ``rule``: what a start must be.
RULES = ("clear", "acceptable")


class ExposureQueries(SiteQueries):
    """Methods of `StreakModel` that need a field of view."""

    def assess(
        self,
        target: TargetLike,
        start: TimeLike,
        exposure: FloatArrayLike,
        *,
        rotation: FloatArrayLike | None = None,
        band: TextLike | None = None,
        scale: str | None = None,
        keep_invalid: bool = False,
    ) -> Assessment:
        """Returns verdicts as arrays of numbers, which is the fastest method, for one visit or a million exposures.

        Parameters
        ----------
        target : `~astropy.coordinates.SkyCoord` or pair
            Centre of the field: any frame, or ``(ra, dec)``, ICRS, degrees or `Quantity`.
        start : time
            Shutter opening.
        exposure : float, array or `~astropy.units.Quantity`
            Duration, seconds.
        rotation : float, array or `~astropy.units.Quantity`, optional
            Position angle of the field's y axis, from north through east, degrees; default: that of the configuration
            file, or else 0.
        band : str or sequence of str, optional
            Band of the exposure, for limits by band: one for all, or one for each.
        scale : {"utc", "tai", "tt"}, optional
            Scale of bare numbers (MJD) in ``start``; default: the model's ``mjd_scale``.
        keep_invalid : bool
            Whether exposures with missing numbers (NaN, masked or `None`) or numbers out of range have the verdict
            ``invalid``, with a warning that counts them; otherwise they are an error.

        Returns
        -------
        Assessment
            Numbers for one exposure, arrays in the broadcast shape of target, start, exposure and rotation for many.
            ``n_streaks`` and ``crosses`` of an ``invalid`` or ``unknown`` exposure are `None`; in arrays they are masked
            (`numpy.ma.MaskedArray`).

        Raises
        ------
        TypeError
            A number is given as time without a scale.
        ValueError
            A number is not finite or out of range (the message contains name and index), or shapes cannot be broadcast.
        """
        exposures, bands, shape = self._exposure_columns(target, start, exposure, rotation, band, scale, keep_invalid)
        columns = self._judged(exposures, bands, keep_invalid)
        if keep_invalid:
            self._warn_of_invalid(columns["verdict"], exposures)
        if shape == ():
            # A masked number is None.
            return Assessment(**{name: column.tolist()[0] for name, column in columns.items()})
        return Assessment(**{name: column.reshape(shape) for name, column in columns.items()})

    def _judged(self, exposures: Mapping[str, FloatArray], bands: Sequence[str], keep_invalid: bool = False) -> dict[str, Any]:
        """Returns the columns of an `Assessment`. Numbers out of range are an error, or make an exposure ``invalid``."""
        result, messages = self._engine.judge(exposures, bands, keep_invalid)
        self._warn_once(messages)
        columns: dict[str, Any] = {**result, "verdict": VERDICTS[result["verdict"]]}
        columns["n_streaks"] = _masked(result["n_streaks"], result["verdict"] >= FIRST_UNJUDGED)
        columns["crosses"] = columns["n_streaks"] > 0
        return columns

    def flag(
        self,
        target: TargetLike,
        start: TimeLike,
        exposure: FloatArrayLike,
        *,
        rotation: FloatArrayLike | None = None,
        band: TextLike | None = None,
        scale: str | None = None,
        output: Output = "auto",
        keep_invalid: bool = False,
    ) -> Table:
        """Returns verdicts with reasons and the next clear start, as printed by ``streakcast flag``.

        Parameters
        ----------
        target, start, exposure, rotation, band, scale
            As for `assess`.
        output : {"auto", "qtable", "dict"}
            A `~astropy.table.QTable` or a dictionary of arrays (times as ``datetime64[ns]``, UTC); ``auto``: the former
            if astropy is installed. The main columns of a `QTable` are the first and the last ones, because `print`
            shows these if not all columns fit. Its method ``write`` writes numbers with all digits, times to the
            microsecond, and lists as JSON text (to ECSV as lists).
        keep_invalid
            As for `assess`.

        Returns
        -------
        QTable or dict of arrays, ``(n_exposures,)`` each
            ``exposure_id`` (flat index of the exposure), ``verdict``, ``n_streaks``, ``brightest_mag``,
            ``expected_lost_pixel_fraction``, ``p_any``, ``streak_length_deg``, ``reasons``, ``next_clear_start_utc``,
            ``delay_s``, ``norad_ids``, ``p_crossing``, ``next_acceptable_start_utc``, ``acceptable_delay_s``,
            ``elements_age_days``, ``late_s``, ``streak_cost_s``.
        """
        exposures, bands, _ = self._exposure_columns(target, start, exposure, rotation, band, scale, keep_invalid)
        table = self._flagged(exposures, bands, output, keep_invalid)
        if keep_invalid:
            self._warn_of_invalid(table["verdict"], exposures)
        return table

    def _flagged(
        self, exposures: Mapping[str, FloatArray], bands: Sequence[str], output: Output, keep_invalid: bool = False
    ) -> Table:
        columns, messages = self._engine.flags(exposures, bands, False, keep_invalid)
        self._warn_once(messages)
        return table_of(_with_integer_ids(columns), output, main=FLAGS)

    def annotate(
        self, schedule: PathLike, output: PathLike, *, scale: str | None = None, replace: bool = False
    ) -> list[Path]:
        """Writes a copy of a schedule file with verdicts and streaks, as ``streakcast annotate``.

        As in the other methods and on the command line, element sets are chosen for each night.

        Parameters
        ----------
        schedule : path
            Schedule: opsim SQLite, ConsDB or ObsPlan exports, CSV, ECSV, JSON or VOTable.
        output : path
            File to write (atomically), in the same format. It may be ``schedule``.
        scale : {"utc", "tai", "tt"}, optional
            Scale of bare numbers in the file; default: that which the file states, or else the model's ``mjd_scale``.
        replace : bool
            Whether an earlier annotation in the file is replaced; otherwise it is an error.

        Returns
        -------
        list of Path
            The written files: the schedule, and the table of streaks if it is a file of its own.

        Raises
        ------
        StreakcastError
            The file cannot be read, lacks a column, has no time scale or an earlier annotation.

        Warns
        -----
        StreakcastWarning
            Rows are invalid, or several rows have one identifier.
        """
        written, messages = self._engine.annotate(absolute(schedule), absolute(output), scale, replace)
        self._warn_once(messages)
        return written

    def next_start(
        self,
        target: TargetLike,
        start: TimeLike,
        exposure: FloatArrayLike,
        *,
        rule: str = "clear",
        rotation: FloatArrayLike | None = None,
        band: TextLike | None = None,
        scale: str | None = None,
        output: Output = "auto",
    ) -> TimeResult:
        """Returns the earliest time at or after ``start`` at which each exposure can start without a satellite in its way.

        Parameters
        ----------
        target, start, exposure, rotation, band, scale
            As for `assess`. The search ends at the policy's ``max_delay_s`` (default 600 s), and its ``margin_s`` is
            applied.
        rule : {"clear", "acceptable"}
            ``clear``: no lit satellite crosses the field. ``acceptable``: the verdict is not ``avoid``.
        output : {"auto", "qtable", "dict"}
            As for `flag`: an astropy `Time`, or ``datetime64[ns]``, UTC.

        Returns
        -------
        Time or array
            Masked (NaT in arrays) where there is no such start within the limit. The delay is a column of `flag`.
        """
        if rule not in RULES:
            raise ValueError(f"rule is '{rule}'; allowed: {', '.join(RULES)}")
        column, shape = self._starts(f"next_{rule}_start_utc", target, start, exposure, rotation, band, scale)
        assert column["kind"] == "time"
        if is_qtable(output):
            return time_of(column["jd1"].reshape(shape), column["jd2"].reshape(shape))
        return column["utc_ns"].view("datetime64[ns]").reshape(shape)

    def _starts(
        self,
        name: str,
        target: TargetLike,
        start: TimeLike,
        exposure: FloatArrayLike,
        rotation: FloatArrayLike | None,
        band: TextLike | None,
        scale: str | None,
    ) -> tuple[Column, tuple[int, ...]]:
        """Returns a column of `flag`, also of later starts from an orbit, and the shape of the exposures."""
        exposures, bands, shape = self._exposure_columns(target, start, exposure, rotation, band, scale)
        columns, messages = self._engine.flags(exposures, bands, True)
        self._warn_once(messages)
        return next(column for column in columns if column["name"] == name), shape

    def passes(
        self,
        target: TargetLike,
        start: TimeLike,
        exposure: FloatArrayLike,
        *,
        rotation: FloatArrayLike | None = None,
        include_dark: bool | None = None,
        samples: int | None = None,
        limit_mag: FloatArrayLike | None = None,
        band: TextLike | None = None,
        scale: str | None = None,
        output: Output = "auto",
    ) -> Table:
        """Returns all satellites that cross the field during each exposure, as printed by ``streakcast passes``.

        Parameters
        ----------
        target, start, exposure, rotation, band, scale
            As for `assess`.
        include_dark : bool, optional
            Whether crossings entirely in the Earth's shadow are included; default: that of the configuration file, or
            else `False`.
        samples : int, optional
            Number of points along each track, in a column ``samples`` of dictionaries; default: that of the
            configuration file, or else 0.
        limit_mag : float, array or `~astropy.units.Quantity`, optional
            Magnitude limit, one for all exposures or one for each (NaN for none). It adds the column ``p_brighter``,
            the probability that the satellite is brighter at its peak. Default: the model's ``limit_mag`` for the band.
        output : {"auto", "qtable", "dict"}
            As for `flag`.

        Returns
        -------
        QTable or dict of arrays, ``(n_passes,)`` each
            ``exposure_id`` is the flat index of the exposure; magnitudes with sigma and source, entry and exit, length,
            width, surface brightness, probability, age of the element set, chords, the lit parts of the chords, and the
            cost of each streak in seconds of open shutter.
        """
        exposures, bands, shape = self._exposure_columns(target, start, exposure, rotation, band, scale)
        limits = None if limit_mag is None else _limits(limit_mag, shape)
        is_dark = None if include_dark is None else bool(include_dark)
        points = None if samples is None else count(samples, "samples", 0)
        return self._crossings(exposures, bands, output, is_dark, points, limits)

    def _crossings(
        self,
        exposures: Mapping[str, FloatArray],
        bands: Sequence[str],
        output: Output,
        include_dark: bool | None = None,
        samples: int | None = None,
        limits_mag: list[float] | None = None,
    ) -> Table:
        columns, messages = self._engine.passes(exposures, include_dark, samples, bands, limits_mag)
        self._warn_once(messages)
        return table_of(_with_integer_ids(columns), output, main=PASSES)

    def windows(
        self,
        target: TargetLike,
        start: TimeLike,
        end: TimeLike,
        exposure: FloatLike,
        *,
        min_altitude: FloatLike = 0.0,
        rotation: FloatArrayLike | None = None,
        band: TextLike | None = None,
        blocking: str | None = None,
        max_sun_altitude: FloatLike | None = None,
        scale: str | None = None,
        output: Output = "auto",
    ) -> ClearWindows:
        """Returns the intervals in which an exposure can start that no satellite selected by ``blocking`` crosses.

        Parameters
        ----------
        target : `~astropy.coordinates.SkyCoord` or pair
            One or many, as for `assess`.
        start, end : time
            Earliest shutter opening and latest shutter closing, at most one day apart.
        exposure : float or `~astropy.units.Quantity`
            Duration of the exposure, seconds.
        min_altitude : float or `~astropy.units.Quantity`
            Smallest altitude of the pointing while the shutter is open, degrees, without refraction.
        rotation, band, scale
            As for `assess`.
        blocking : {"any", "avoid"}, optional
            Satellites that block an exposure. ``any``: all lit satellites. ``avoid``: satellites that exceed a
            magnitude limit of the policy; all lit satellites if no limit applies to the band. Default: the policy's.
        max_sun_altitude : float or `~astropy.units.Quantity`, optional
            Highest altitude of the Sun while the shutter is open, degrees. Default: no limit.
        output : {"auto", "qtable", "dict"}
            As for `flag`: starts are an astropy `Time`, or ``datetime64[ns]``, UTC (several times faster).

        Returns
        -------
        ClearWindows

        Warns
        -----
        StreakcastWarning
            Satellites were omitted because their position cannot be computed at that time, or the element sets are old.
        """
        if blocking is not None and blocking not in BLOCKING:
            raise ValueError(f"blocking is '{blocking}'; allowed: {', '.join(BLOCKING)}")
        sun = None if max_sun_altitude is None else scalar(max_sun_altitude, "deg", "max_sun_altitude")
        jd1, jd2 = to_tai(end, self._scale(scale), "end")
        begin1, begin2 = to_tai(start, self._scale(scale), "start")
        span_s = ((jd1 - begin1) + (jd2 - begin2)) * 86_400.0
        if np.any(span_s < 0.0):
            raise ValueError(f"end[{int(np.flatnonzero(np.ravel(span_s) < 0.0)[0])}] is before the start")
        if np.any(span_s > 86_400.0):
            index = int(np.flatnonzero(np.ravel(span_s) > 86_400.0)[0])
            raise ValueError(f"end[{index}] is {np.ravel(span_s)[index]:.12g} s after the start; allowed: at most one day, 86400 s")
        length_s = scalar(exposure, "s", "exposure")
        if not length_s > 0.0:
            raise ValueError(f"exposure is {length_s:g} s; allowed: above 0 s, at most 86400 s")
        exposures, bands, _ = self._exposure_columns(target, start, span_s, rotation, band, scale)
        lowest = scalar(min_altitude, "deg", "min_altitude")
        result, messages = self._engine.clear_windows(exposures, bands, length_s, lowest, blocking, sun)
        self._warn_once(messages)
        first, last = result["first_start"], result["last_start"]
        length = (last[0] - first[0] + (last[1] - first[1])) * 86_400.0
        if is_qtable(output):
            return ClearWindows(result["target"], time_of(*first[:2]), time_of(*last[:2]), length)
        moments = [one[2].view("datetime64[ns]") for one in (first, last)]
        return ClearWindows(result["target"], moments[0], moments[1], length)

    def check_pointings(
        self,
        pointing_ras: FloatArrayLike,
        pointing_decs: FloatArrayLike,
        mjds: TimeLike,
        visit_time: FloatArrayLike,
        *,
        scale: str | None = None,
    ) -> tuple[FloatArray, WholeArray]:
        """Returns length and number of streaks per pointing, like the satellite constellations of rubin_sim.

        Parameters
        ----------
        pointing_ras, pointing_decs : array or `~astropy.units.Quantity`, ``(n,)``
            Right ascension and declination of the pointings, ICRS, degrees.
        mjds : array, ``(n,)``
            Start of each visit, MJD, or times of any other kind. Numbers need a scale, here or as the model's
            ``mjd_scale``.
        visit_time : float, array or `~astropy.units.Quantity`
            Duration of a visit, seconds.
        scale : {"utc", "tai", "tt"}, optional
            Scale of ``mjds``.

        Returns
        -------
        lengths_deg : array, ``(n,)``
            Total length of the lit streaks in the field of each visit, degrees; 0 for pointings below the horizon, as
            in rubin_sim (`assess` returns NaN); NaN if the element sets are too old to predict positions.
        n_streaks : array, ``(n,)``
            Number of lit streaks; 0 for pointings below the horizon, masked if the element sets are too old.
        """
        result = self.assess((pointing_ras, pointing_decs), mjds, visit_time, scale=scale)
        verdict = np.atleast_1d(result.verdict)
        lengths = np.where(verdict == "invalid", 0.0, np.atleast_1d(result.streak_length_deg))
        streaks = np.ma.masked if result.n_streaks is None else result.n_streaks
        streaks = np.ma.filled(np.ma.atleast_1d(streaks), 0).astype(np.int64)
        return lengths, _masked(streaks, verdict == "unknown")

    def _exposure_columns(
        self,
        target: TargetLike,
        start: TimeLike,
        exposure: FloatArrayLike,
        rotation: FloatArrayLike | None,
        band: TextLike | None,
        scale: str | None,
        keep_invalid: bool = False,
    ) -> tuple[dict[str, FloatArray], list[str], tuple[int, ...]]:
        ra, dec = directions(target, keep_missing=keep_invalid)
        jd1, jd2 = (to_tai_or_nan if keep_invalid else to_tai)(start, self._scale(scale), "start")
        if rotation is None:
            rotation = self._engine.default_rotation_deg
        length = number(exposure, "s", "exposure", keep_missing=keep_invalid)
        angle = number(rotation, "deg", "rotation", keep_missing=keep_invalid)
        names = ("ra_deg", "dec_deg", "jd1", "jd2", "exposure_s", "rotation_deg")
        parts = (ra, dec, jd1, jd2, length, angle)
        try:
            shape = np.broadcast_shapes(*(part.shape for part in parts))
        except ValueError:
            shapes = f"ra {ra.shape}, dec {dec.shape}, start {jd1.shape}, exposure {length.shape}, rotation {angle.shape}"
            raise ValueError(f"shapes cannot be broadcast together: {shapes}") from None
        exposures = {
            # The arrays of one visit have the shape already, and broadcasting them takes long.
            name: aligned((part if part.shape == shape else np.broadcast_to(part, shape)).reshape(-1))
            for name, part in zip(names, parts)
        }
        bands = [] if band is None or 0 in shape else _band_names(band)
        return exposures, bands, shape

    def _warn_of_invalid(self, verdicts: "npt.ArrayLike", exposures: Mapping[str, FloatArray]) -> None:
        """Issues a warning with the number of exposures that have a number out of range, and the first one."""
        if "invalid" in np.asarray(verdicts):
            self._warn_once(invalid_numbers(exposures, "exposures"))


def invalid_numbers(exposures: Mapping[str, FloatArray], what: str) -> list[str]:
    """Returns a warning with the number of exposures that have a number missing or out of range; none if there are none."""
    invalid = _core.out_of_range(exposures)
    if not invalid:
        return []
    row, reason = invalid[0]
    verbs = ("has a number", "is") if len(invalid) == 1 else ("have numbers", "are")
    count = f"{len(invalid)} of {len(exposures['ra_deg'])} {what}"
    return [f"{count} {verbs[0]} missing or out of range, and {verbs[1]} invalid; first row {row}: {reason}"]


def _band_names(band: TextLike) -> list[str]:
    """Returns the names of bands: one for all exposures, or one for each."""
    check_unmasked(band, "band", "allowed: a string, or one for each exposure")
    names = np.ravel(np.asarray(band))
    if names.dtype.kind == "S":
        return [name.decode("ascii", "replace") for name in names]
    if names.dtype.kind not in "UTO":
        raise TypeError(f"band is of the type {names.dtype}; allowed: a string, or one for each exposure")
    return [name.decode("ascii", "replace") if isinstance(name, bytes) else str(name) for name in names]


def _masked(values: WholeArray, is_unknown: "npt.NDArray[np.bool_]") -> WholeArray:
    """Returns the values, as a masked array if some are unknown."""
    return np.ma.MaskedArray(values, mask=is_unknown) if is_unknown.any() else values


def _limits(limit_mag: FloatArrayLike, shape: tuple[int, ...]) -> list[float]:
    """Returns one magnitude limit for each exposure."""
    limits = number(limit_mag, "mag", "limit_mag")
    try:
        return [float(limit) for limit in np.broadcast_to(limits, shape).ravel()]
    except ValueError:
        raise ValueError(f"limit_mag has the shape {limits.shape}; allowed: one number, or the shape {shape}") from None


def _with_integer_ids(columns: "Sequence[Column]") -> "list[Column]":
    """Returns the columns with integer exposure ids: flat indices of the exposures."""
    first = cast("TextColumn", columns[0])
    indices = np.array([int(text) for text in first["values"]], dtype=np.int64)
    description = "Flat index of the exposure, from 0."
    missing = np.zeros(len(indices), dtype=bool)
    ids: IntegerColumn = {
        "name": first["name"], "unit": "", "description": description, "kind": "integer", "values": indices, "missing": missing,
    }  # fmt: skip
    return [ids, *columns[1:]]
