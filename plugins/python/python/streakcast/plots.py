"""Plots of the results of `StreakModel` as PNG and SVG, in the form of those of ``streakcast plot``.

They have no stars and no twilight, and a circle is the only outline of a field. Files do not state how the data were
computed.

>>> from streakcast import StreakModel, plots
>>> model = StreakModel(site="Rubin Observatory", shells="starlink-gen1", fov="3.5deg", limit_mag=7)
>>> passes = model.passes((198.9, 7.7), "2026-08-14T23:29:05Z", 30.0)
>>> plots.field(passes, (198.9, 7.7), fov_deg=3.5).size
(1440, 846)

Each function takes tables as returned by the model (a `QTable` or a dictionary of arrays) and returns a `Picture`,
which notebooks display.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from . import _core
from ._quantities import check_unmasked, count, directions, number, scalar
from ._times import is_time, to_tai
from ._warnings import warn
from .typing import FloatArray, FloatArrayLike, FloatLike, PathLike, Sample, Samples, TableLike, TargetLike, TimeLike

__all__ = ["Picture", "field", "light_curve", "night", "sky_chart", "sky_rate", "sun_altitude"]

#: MJD of 1970-01-01, the epoch of ``datetime64``.
_UNIX_MJD = 40587.0
_DAY_NS = 86_400e9
#: Largest offset of a local clock from UTC, hours.
_MAX_UTC_OFFSET_H = 14


class Picture:
    """Rendered plot, displayed by notebooks.

    Attributes
    ----------
    size : (int, int)
        Width and height in pixels.
    """

    def __init__(self, core: _core.Picture) -> None:
        self._core = core

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self._core.size

    def png(self) -> bytes:
        """Returns the bytes of a PNG."""
        return self._core.png()

    def svg(self) -> str:
        """Returns the text of an SVG with embedded font."""
        return self._core.svg()

    def save(self, path: PathLike) -> None:
        """Writes a file atomically.

        Parameters
        ----------
        path : str or path
            File name that ends in ``.png`` or ``.svg``.

        Raises
        ------
        ValueError
            The file name has another extension.
        OSError
            The file cannot be written.
        """
        self._core.save(os.fspath(path))

    def _repr_png_(self) -> bytes:
        return self.png()

    def _repr_svg_(self) -> str:
        return self.svg()

    def __repr__(self) -> str:
        return f"<streakcast picture, {self.size[0]} by {self.size[1]} pixels>"


def night(
    flags: TableLike,
    start: TimeLike,
    exposure: FloatArrayLike,
    *,
    limit_mag: FloatLike | None = None,
    utc_offset: FloatLike | None = None,
    scale: str | None = None,
    title: str = "",
) -> Picture:
    """Plots a night: number and brightness of the streaks in each exposure.

    Parameters
    ----------
    flags : QTable or dict of arrays, ``(n_exposures,)``
        Result of `StreakModel.flag`: ``n_streaks`` and ``brightest_mag`` are drawn. Exposures with the ``verdict``
        ``unknown`` or ``invalid`` are not drawn.
    start, exposure, scale
        Arguments of that call.
    limit_mag : float or `~astropy.units.Quantity`, optional
        Magnitude of a limit line.
    utc_offset : float or `~astropy.units.Quantity`, optional
        Offset of the local time on the upper axis from UTC, hours.
    title : str
        Title of the plot.

    Returns
    -------
    Picture

    Raises
    ------
    StreakcastError
        There are no data, columns differ in length, or exposures are more than two days apart.
    ValueError
        All exposures are invalid.

    Warns
    -----
    StreakcastWarning
        Number of invalid exposures.
    """
    columns = {
        "n_streaks": _numbers(flags, "n_streaks"),
        "brightest_mag": _numbers(flags, "brightest_mag"),
        "start": _mjd(start, scale),
        "exposure": np.ravel(number(exposure, "s", "exposure")),
    }
    n_exposures = len(columns["n_streaks"])
    lengths = {name: len(column) for name, column in columns.items()}
    for name, length in lengths.items():
        if length != n_exposures and (length != 1 or name not in ("start", "exposure")):
            given = ", ".join(f"{name} {length}" for name, length in lengths.items())
            raise _core.StreakcastError(f"columns differ in length: {given}; allowed: columns of one length")
    is_drawn = np.ones(n_exposures, dtype=bool)
    if "verdict" in flags.keys():
        is_drawn = ~np.isin(np.array(_texts(flags, "verdict"), dtype=np.str_), ("invalid", "unknown"))
    n_invalid = n_exposures - int(is_drawn.sum())
    if n_invalid and n_invalid == n_exposures:
        raise ValueError(f"all {n_exposures} exposures are invalid; allowed: at least one valid exposure")
    if n_invalid:
        warn(f"{n_invalid} of {n_exposures} exposures are invalid and not drawn")
    streaks, brightest, start_mjd, seconds = (np.broadcast_to(one, n_exposures)[is_drawn] for one in columns.values())
    return _drawn(
        "night", title, limit_mag=limit_mag, utc_offset=utc_offset,
        start_mjd=start_mjd, duration_s=seconds, n_streaks=streaks, brightest_mag=brightest,
    )  # fmt: skip


def field(passes: TableLike, target: TargetLike, *, fov_deg: FloatLike | None = None, title: str = "") -> Picture:
    """Plots a field with the streaks that cross it: gnomonic, north up, east left.

    Parameters
    ----------
    passes : QTable or dict of arrays, ``(n_passes,)``
        Result of `StreakModel.passes` for one exposure.
    target : SkyCoord or (ra, dec)
        Centre of the field in that call, ICRS.
    fov_deg : float or `~astropy.units.Quantity`, optional
        Diameter of a circular field for its outline, degrees.
    title : str
        Title of the plot.

    Returns
    -------
    Picture

    Raises
    ------
    StreakcastError
        There are neither streaks nor an outline, the diameter is not above 0 or is above 180 degrees, or a position is
        more than 75 degrees from the centre.
    ValueError
        The passes are of several exposures, or there are several targets.
    """
    centre = np.broadcast_arrays(*directions(target))
    if centre[0].size != 1:
        raise ValueError(f"target has {centre[0].size} positions; allowed: one position")
    exposures = np.unique(np.asarray(passes["exposure_id"])).tolist() if "exposure_id" in passes.keys() else []
    if len(exposures) > 1:
        one = f"passes[passes['exposure_id'] == {exposures[0]!r}]"
        raise ValueError(f"passes are of {len(exposures)} exposures; allowed: rows of one exposure, for example {one}")
    ra, dec = (axis.item() for axis in centre)
    diameter = None if fov_deg is None else scalar(fov_deg, "deg", "fov_deg")
    axes = [[_numbers(passes, f"{end}_{axis}_deg") for axis in ("ra", "dec")] for end in ("enter", "mid", "exit")]
    names, ids = _texts(passes, "name"), _numbers(passes, "norad_id")
    ends = [_mjd(passes[f"{end}_utc"], None) for end in ("enter", "exit")]
    peak, sigma = _numbers(passes, "magnitude_peak"), _numbers(passes, "magnitude_peak_sigma")
    streaks = [
        (
            names[k] or f"NORAD {ids[k]:.0f}",
            [[float(right[k]), float(up[k])] for right, up in axes],
            float(ends[0][k]),
            float(ends[1][k]),
            float(peak[k]),
            float(sigma[k]),
        )
        for k in range(len(names))
    ]
    return _drawn("field", title, ra_deg=ra, dec_deg=dec, fov_deg=diameter, streaks=streaks)


def light_curve(
    samples: Samples,
    *,
    limit_mag: FloatLike | None = None,
    utc_offset: FloatLike | None = None,
    title: str = "",
) -> Picture:
    """Plots the magnitude along the track of one pass, with its error.

    Parameters
    ----------
    samples : sequence of dict
        Cell of the column ``samples`` of ``StreakModel.passes(..., samples=100)`` (all points are in the field) or of
        ``StreakModel.forecast(..., samples=100).passes`` (from rise to set), with ``utc``, ``magnitude`` and
        ``magnitude_sigma``.
    limit_mag : float or `~astropy.units.Quantity`, optional
        Magnitude of a limit line.
    utc_offset : float or `~astropy.units.Quantity`, optional
        Offset of the local time on the upper axis from UTC, hours.
    title : str
        Title of the plot.

    Returns
    -------
    Picture

    Raises
    ------
    StreakcastError
        There are fewer than two points, or no point has a magnitude.
    """
    times = _sample_times(samples)
    # Samples from rise to set include points in shadow, and have the column illumination.
    is_of_field = len(times) > 1 and "illumination" not in samples[0]
    return _drawn(
        "light_curve", title, limit_mag=limit_mag, utc_offset=utc_offset,
        time_mjd=times, magnitude=_of_samples(samples, "magnitude"), sigma_mag=_of_samples(samples, "magnitude_sigma"),
        in_fitted_range=[point.get("in_fitted_range") in (None, True) for point in samples],
        in_field=[[float(times[0]), float(times[-1])]] if is_of_field else [],
    )  # fmt: skip


def sky_chart(passes: TableLike, *, title: str = "") -> Picture:
    """Plots passes over the sky of a site, coloured by magnitude: zenith in the centre, north up, east left.

    Parameters
    ----------
    passes : QTable or dict of arrays, ``(n_passes,)``
        ``StreakModel.forecast(..., samples=100).passes``, or some of its rows; the 22 brightest are drawn.
    title : str
        Title of the plot.

    Returns
    -------
    Picture

    Raises
    ------
    StreakcastError
        There are no passes, or a pass has fewer than two points.
    ValueError
        The table has no column ``samples``.
    """
    names = passes.keys()
    if "samples" not in names:
        raise ValueError("passes have no column samples; call forecast(..., samples=100)")
    late = "along_track_sigma_s"
    late_s = _numbers(passes, late) if late in names else np.full(len(passes["samples"]), np.nan)
    tracks = [
        dict(
            name=str(name), time_mjd=_sample_times(samples).tolist(), azimuth_deg=_of_samples(samples, "azimuth_deg"),
            altitude_deg=_of_samples(samples, "altitude_deg"), magnitude=_of_samples(samples, "magnitude"),
            sigma_mag=_of_samples(samples, "magnitude_sigma"), time_sigma_s=float(sigma_s),
        )
        for name, samples, sigma_s in zip(_texts(passes, "name"), passes["samples"], late_s)
    ]  # fmt: skip
    return _drawn("sky_chart", title, tracks=tracks)


def sky_rate(
    cells: ArrayLike,
    rate: ArrayLike,
    *,
    nside: int,
    sun_azimuth_deg: FloatLike,
    title: str = "Streaks per exposure",
    subtitle: str = "",
) -> Picture:
    """Plots expected streaks per exposure over the sky of a site.

    Parameters
    ----------
    cells : array of int, ``(n_cells,)``
        HEALPix cells of azimuth and altitude in RING order, each once.
    rate : array of float, ``(n_cells,)``
        Expected number of streaks, 0 or more.
    nside : int
        HEALPix resolution, 1 to 1024.
    sun_azimuth_deg : float or `~astropy.units.Quantity`
        Azimuth of the Sun, degrees from north through east.
    title, subtitle : str
        Title and subtitle of the plot.

    Returns
    -------
    Picture

    Raises
    ------
    StreakcastError
        There are no cells, a cell is invalid or repeated, or a rate is negative.
    ValueError
        ``nside`` is below 1, or a cell is masked or negative.
    TypeError
        Cells are not integers.
    """
    numbers = _plain(cells, "cells")
    if numbers.size and numbers.dtype.kind not in "iu":
        raise TypeError(f"cells are {numbers.dtype}; allowed: integers, 0 or more")
    negative = np.flatnonzero(numbers < 0)
    if negative.size:
        raise ValueError(f"cells[{negative[0]}] is {numbers[negative[0]]}; allowed: 0 or more")
    values = np.ravel(number(rate, "", "rate"))
    azimuth = scalar(sun_azimuth_deg, "deg", "sun_azimuth_deg")
    return _drawn(
        "sky_rate", title, nside=count(nside, "nside", 1), cells=numbers, rate=values, sun_azimuth_deg=azimuth, subtitle=subtitle,
    )  # fmt: skip


def sun_altitude(
    sun_altitude_deg: FloatArrayLike,
    n_trails: ArrayLike,
    *,
    n_bright: ArrayLike | None = None,
    limit_mag: FloatLike | None = None,
    bin_deg: FloatLike = 2.0,
    title: str = "Trails per exposure",
) -> Picture:
    """Plots trails per exposure against the altitude of the Sun.

    Parameters
    ----------
    sun_altitude_deg : array of float or Quantity, ``(n_exposures,)``
        Altitude of the Sun at the middle of each exposure.
    n_trails : array, ``(n_exposures,)``
        Number of lit satellites that cross.
    n_bright : array, optional
        Number of those brighter than ``limit_mag``; requires ``limit_mag``.
    bin_deg : float or `~astropy.units.Quantity`
        Width of the bins, 0.1 to 30 degrees.
    title : str
        Title of the plot.

    Returns
    -------
    Picture

    Raises
    ------
    StreakcastError
        There are no data, columns differ in length, or altitudes are invalid.
    ValueError
        Only one of ``n_bright`` and ``limit_mag`` is given, or a number is masked.
    """
    if (n_bright is None) != (limit_mag is None):
        raise ValueError("n_bright and limit_mag require each other; specify both or neither")
    altitudes = np.ravel(number(sun_altitude_deg, "deg", "sun_altitude_deg")).tolist()
    trails = _plain(n_trails, "n_trails").astype(np.float64)
    bright = None if n_bright is None else _plain(n_bright, "n_bright").astype(np.float64)
    return _drawn(
        "sun_altitude", title, limit_mag=limit_mag,
        sun_altitude_deg=altitudes, n_trails=trails, bin_deg=scalar(bin_deg, "deg", "bin_deg"), n_bright=bright,
    )  # fmt: skip


def _drawn(
    chart: str,
    title: str,
    *,
    limit_mag: FloatLike | None = None,
    utc_offset: FloatLike | None = None,
    **columns: object,
) -> Picture:
    """Draws a plot by name from its labels and columns."""
    hours = None if utc_offset is None else scalar(utc_offset, "h", "utc_offset")
    if hours is not None and not abs(hours) <= _MAX_UTC_OFFSET_H:
        raise ValueError(f"utc_offset is {hours} h; allowed: -{_MAX_UTC_OFFSET_H} to {_MAX_UTC_OFFSET_H} h")
    local = None if hours is None else (hours, _clock_name(hours))
    limit = None if limit_mag is None else scalar(limit_mag, "mag", "limit_mag")
    labels = {"title": title, "limit_mag": limit, "local": local}
    plain = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in columns.items()}
    return Picture(_core.draw(chart, labels, plain))


def _sample_times(samples: Samples) -> FloatArray:
    """Returns the times along a pass, MJD (UTC)."""
    # An empty list is passed on; the error states what is missing.
    return _mjd(np.array([str(point["utc"]) for point in samples], dtype=str), None)


def _of_samples(samples: Samples, name: str) -> list[float]:
    return [np.nan if (value := point[name]) is None else float(value) for point in samples]


def _clock_name(utc_offset: float) -> str:
    sign, minutes = ("−" if utc_offset < 0 else "+"), round(abs(utc_offset) * 60)
    rest = f":{minutes % 60:02}" if minutes % 60 else ""
    return f"local time (UTC{sign}{minutes // 60}{rest})"


def _plain(values: ArrayLike, what: str) -> npt.NDArray[Any]:
    """Returns one or several numbers as a flat array."""
    check_unmasked(values, what, "allowed: unmasked numbers")
    return np.ravel(np.asarray(values))


def _numbers(table: TableLike, name: str) -> FloatArray:
    """Returns a column as plain numbers, NaN where it is masked."""
    cells = table[name]
    cells = getattr(cells, "value", cells)
    if isinstance(cells, np.ma.MaskedArray):
        return np.ravel(np.ma.filled(cells.astype(np.float64), np.nan))
    return np.ravel(np.asarray(cells, dtype=np.float64))


def _texts(table: TableLike, name: str) -> list[str]:
    return ["" if cell is None or cell is np.ma.masked else str(cell) for cell in table[name]]


def _mjd(times: TimeLike, scale: str | None) -> FloatArray:
    """Returns times as MJD (UTC)."""
    if not is_time(times):
        array = np.asarray(times)
        if np.issubdtype(array.dtype, np.datetime64):
            return np.ravel(array.astype("datetime64[ns]").astype(np.int64) / _DAY_NS + _UNIX_MJD)
    jd1, jd2 = to_tai(times, scale, "start")
    return np.asarray(_core.utc_mjd(np.ravel(jd1).astype(np.float64), np.ravel(jd2).astype(np.float64)))
