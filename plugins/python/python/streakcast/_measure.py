"""Measurement of the streaks of satellites in frames."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypedDict

import numpy as np
import numpy.typing as npt

from . import _core
from ._exposure_queries import ExposureQueries
from ._frames import as_files, frames_of
from ._injection import _angle, _integers, _moment, _scalar, _without_none
from ._quantities import scalar
from ._setup import absolute, document
from ._streak_tables import streak_files
from ._tables import Main, arrays_of, table_of
from ._warnings import warn_of_frames
from .typing import (
    FloatArray,
    FloatLike,
    FrameLike,
    HeaderLike,
    Json,
    MeasureOptions,
    Options,
    Output,
    PathLike,
    StreaksLike,
    Table,
    TimeLike,
    WholeArray,
    WholeLike,
)

if TYPE_CHECKING:
    from astropy.units import Quantity
    from typing_extensions import Unpack

#: Flags of measurements from which nothing is learned.
_DOUBTFUL = frozenset(("saturated", "clipped", "masked", "position"))
_MEASUREMENTS = Main(("name", "detected", "limit_magnitude"), ("magnitude", "magnitude_sigma"))
_STREAKS = Main(("streak", "name", "detected", "limit_magnitude"), ("magnitude", "magnitude_sigma"))


class LearnArguments(TypedDict):
    """Arguments of `streakcast.learn`, each of shape ``(n_streaks,)``."""

    #: NORAD catalogue numbers.
    norad_id: WholeArray
    #: Times in the middle of the tracks, as text, UTC.
    time: npt.NDArray[np.str_]
    #: Measured magnitudes.
    observed: FloatArray
    #: Magnitudes of the model.
    predicted: FloatArray
    #: Errors (one sigma) of the measured magnitudes.
    sigma: FloatArray


@dataclass(frozen=True)
class Measurements:
    """Measured streaks and upper limits in frames."""

    #: One row per predicted track or given streak and chip, with the columns of ``streakcast measure``: `~astropy.table.QTable` or
    #: dictionary of arrays.
    table: Table
    #: Zero points from stars, and other remarks.
    remarks: tuple[str, ...]
    #: Measured magnitudes of the streaks that were found, without instrumental ones and those with the flags
    #: ``saturated``, ``clipped``, ``masked`` or ``position``.
    learn_arguments: LearnArguments


class MeasureQueries(ExposureQueries):
    """Measurement of frames."""

    def measure(
        self,
        frames: FrameLike | Sequence[FrameLike],
        *,
        streaks: StreaksLike | Sequence[PathLike] | None = None,
        place_sigma: str | Quantity | None = None,
        header: HeaderLike | None = None,
        start: TimeLike | None = None,
        exposure: FloatLike | None = None,
        scale: str | None = None,
        hdu: WholeLike | None = None,
        seeing: str | Quantity | None = None,
        fit_width: bool = False,
        psf: str = "moffat",
        satellite_size: FloatLike | None = None,
        stars: PathLike | None = None,
        star_colours: Sequence[FloatLike] | None = None,
        zero_point: FloatLike | None = None,
        zero_point_1s: FloatLike | None = None,
        gain: FloatLike | None = None,
        saturation: FloatLike | None = None,
        band: str | None = None,
        telescope: PathLike | Options | None = None,
        table: Output = "auto",
    ) -> Measurements:
        """Measures the streaks of the satellites in frames; the result is identical to that of ``streakcast measure``.

        Parameters
        ----------
        frames : path, array, `~astropy.nddata.NDData`, `~astropy.io.fits.HDUList` or HDU, or a list of them
            FITS files with world coordinates, including mosaics and compressed ones, or frames in memory, as for
            `streakcast.inject`. Pixels in ``mask`` of an `~astropy.nddata.NDData`, and those without a positive
            variance, are not used.
        streaks : path or list of paths, `~astropy.table.Table`, dict of columns, or list of dicts, optional
            Table of streaks that are measured instead of the predicted ones: ends in pixels or on the sky, ``streaks.txt``
            of ASTRiDE, or a catalog of ``acstools.findsat_mrt``. Streaks are named if a satellite of the model has
            probably made them. Several files belong to the frames in their order.
        place_sigma : str or `~astropy.units.Quantity`, optional
            Position error (one sigma) of the ends of ``streaks``, with its unit; default: 3 pixels.
        header : `~astropy.io.fits.Header`, `~astropy.wcs.WCS`, dict or str, optional
            World coordinates of an array and the other keywords of its header; required for one array.
        start : time, optional
            Shutter opening; default: from the header.
        exposure : float or `~astropy.units.Quantity`, optional
            Duration of the exposure, seconds; default: from the header.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number in ``start``.
        hdu : int or list of int, optional
            HDUs to use, from 0; default: all images with world coordinates.
        seeing : str or `~astropy.units.Quantity`, optional
            FWHM of the image of a star, with its unit; default: that of the telescope, or else that of ``stars``, or
            else fitted to each streak.
        fit_width : bool
            Whether the width of each streak is fitted although the seeing is given.
        psf : str
            ``gaussian``, ``moffat`` (β 3.5), ``moffat:BETA`` or ``double``.
        satellite_size : float or `~astropy.units.Quantity`, optional
            Diameter of the satellites, m, 0 for points; default: that of the model, with an error of half of it.
        stars : path, optional
            Table (CSV) of stars, from which the zero point is measured: ``ra_deg, dec_deg, mag`` and, optionally,
            ``mag_sigma``, ``band`` and ``colour``.
        star_colours : (float, float), optional
            The bluest and the reddest colour of the stars that are used, mag: ``(0.7, 0.95)`` for stars like the Sun in
            Gaia's BP - RP.
        zero_point, zero_point_1s : float or `~astropy.units.Quantity`, optional
            Magnitude of a star whose image sums to 1 in the unit of the frame, or that gives 1 count per second;
            default: from the header. Without any zero point, magnitudes are instrumental.
        gain : float or `~astropy.units.Quantity`, optional
            Electrons per count; default: from the header.
        saturation : float or `~astropy.units.Quantity`, optional
            Value at which pixels are saturated, in the unit of the frame; default: from the header, or else the largest
            value of the frame if pixels pile up there.
        band : str, optional
            Band of the magnitudes; default: filter in the header, or else the model's band.
        telescope : path or dict, optional
            Preset name or TOML file, for seeing and defocus; default: that of the model.
        table : {"auto", "qtable", "dict"}
            Form of the table, as for `flags`.

        Returns
        -------
        Measurements
            ``learn(**measured.learn_arguments, kind=...)`` learns from the streaks that were found.

        Raises
        ------
        StreakcastError
            World coordinates or the time are missing, the table of stars is invalid, or a number is out of range.
        TypeError
            A number is given as time without a scale, or an angle has no unit.

        Warns
        -----
        StreakcastWarning
            A frame has no zero point, the gain is unknown, chips were omitted, or element sets are old.
        """
        if start is not None:
            start = _core.utc_text(*self._moment(start, scale))
        sky_cache, _ = self._open()
        measurements, warnings = _measure(
            frames, streaks, (self._state["setup"], self._state["config"], sky_cache), place_sigma=place_sigma, header=header,
            start=start, exposure=exposure, hdu=hdu, seeing=seeing, fit_width=fit_width, psf=psf, satellite_size=satellite_size,
            stars=stars, star_colours=star_colours, zero_point=zero_point, zero_point_1s=zero_point_1s, gain=gain,
            saturation=saturation, band=band, telescope=telescope, table=table,
        )  # fmt: skip
        warn_of_frames(warnings)
        # Warnings about the elements.
        self._warn_once([])
        return measurements


def measure_streaks(
    frames: FrameLike | Sequence[FrameLike],
    streaks: StreaksLike | Sequence[PathLike],
    *,
    place_sigma: str | Quantity | None = None,
    **options: Unpack[MeasureOptions],
) -> Measurements:
    """Measures streaks whose ends a table gives, without satellites; the result is identical to that of ``streakcast measure
    --streaks``. `StreakModel.measure` with ``streaks`` also identifies their satellites.

    Parameters
    ----------
    frames : path, array, `~astropy.nddata.NDData`, `~astropy.io.fits.HDUList` or HDU, or a list of them
        Frames, as for `StreakModel.measure`.
    streaks : path or list of paths, `~astropy.table.Table`, dict of columns, or list of dicts
        Table of streaks, as for `StreakModel.measure`.
    place_sigma : str or `~astropy.units.Quantity`, optional
        Position error (one sigma) of the ends, with its unit; default: 3 pixels.
    **options
        Other arguments of `StreakModel.measure`.

    Returns
    -------
    Measurements

    Raises
    ------
    StreakcastError
        World coordinates or the time are missing, a table is invalid, or a number is out of range.
    TypeError
        A number is given as time without a scale, or an angle has no unit.

    Warns
    -----
    StreakcastWarning
        A frame has no zero point, the gain is unknown, or chips were omitted.
    """
    measurements, warnings = _measure(frames, streaks, ({}, None, None), place_sigma=place_sigma, **options)
    warn_of_frames(warnings)
    return measurements


def _measure(
    frames: FrameLike | Sequence[FrameLike],
    streaks: StreaksLike | Sequence[PathLike] | None,
    sky: tuple[Mapping[str, Json], str | None, _core.SkyCache | None],
    *,
    place_sigma: str | Quantity | None,
    header: HeaderLike | None = None,
    start: TimeLike | None = None,
    scale: str | None = None,
    exposure: FloatLike | None = None,
    hdu: WholeLike | None = None,
    seeing: str | Quantity | None = None,
    fit_width: bool = False,
    psf: str = "moffat",
    satellite_size: FloatLike | None = None,
    stars: PathLike | None = None,
    star_colours: Sequence[FloatLike] | None = None,
    zero_point: FloatLike | None = None,
    zero_point_1s: FloatLike | None = None,
    gain: FloatLike | None = None,
    saturation: FloatLike | None = None,
    band: str | None = None,
    telescope: PathLike | Options | None = None,
    table: Output = "auto",
) -> tuple[Measurements, list[str]]:
    """Returns the measurements and the warnings. Arguments are those of `StreakModel.measure`."""
    if not hasattr(_core, "measure"):
        raise NotImplementedError("measure is not in this build: it needs CFITSIO, which does not build on Windows")
    if zero_point is not None and zero_point_1s is not None:
        raise ValueError("zero_point and zero_point_1s exclude each other; allowed: one of them")
    if place_sigma is not None and streaks is None:
        raise ValueError("place_sigma is given without streaks; allowed: with streaks")
    request: dict[str, Json] = dict(
        hdu=_integers(hdu), seeing=_angle(seeing, "seeing"), psf=psf,
        satellite_size=_scalar(satellite_size, "m", "satellite_size"), place_sigma=_angle(place_sigma, "place_sigma"),
        fit_width=bool(fit_width), stars=None if stars is None else absolute(stars),
        star_colours=None if star_colours is None else ",".join(repr(scalar(one, "mag", "star_colours")) for one in star_colours),
        zero_point=_scalar(zero_point, "mag", "zero_point"),
        zero_point_1s=_scalar(zero_point_1s, "mag", "zero_point_1s"), gain=_scalar(gain, "electron/adu", "gain"),
        saturation=_scalar(saturation, "adu", "saturation"),
    )  # fmt: skip
    if start is not None:
        request["start"] = start if isinstance(start, str) and scale is None else _moment(start, scale)
    if exposure is not None:
        request["exposure"] = f"{scalar(exposure, 's', 'exposure')!r}s"
    setup, config, sky_cache = sky
    setup = {**setup, **document({"telescope": telescope, "band": band})}
    several = frames_of(frames)
    what = "frame" if len(several) == 1 else "frames"
    with streak_files(streaks) as tables, as_files(several, header, what=what) as files:
        request["image"], request["streaks"] = [*files.paths], [*tables.paths]
        request["streaks_folder"] = tables.image_folder
        result = _core.measure(json.dumps(_without_none(request)), json.dumps(setup), config, sky_cache)

    def shown(text: str) -> str:
        return files.shown(tables.shown(text))

    measured = files.named(result["measurements"])
    columns = arrays_of(measured)
    observed, predicted = columns["magnitude"], columns["predicted_magnitude"]
    is_doubtful = np.array([not _DOUBTFUL.isdisjoint(flags) for flags in columns["flags"]], dtype=np.bool_)
    is_usable = np.isfinite(observed) & np.isfinite(predicted) & ~is_doubtful
    # Streaks that are not measured have no value here.
    is_usable &= np.ma.filled(columns["calibrated"], False)
    learn_arguments = LearnArguments(
        norad_id=np.ma.getdata(columns["norad_id"])[is_usable],
        time=np.datetime_as_string(columns["mid_utc"][is_usable], timezone="UTC"),
        observed=observed[is_usable],
        predicted=predicted[is_usable],
        sigma=columns["magnitude_sigma"][is_usable],
    )
    measurements = Measurements(
        table=table_of(measured, table, main=_MEASUREMENTS if streaks is None else _STREAKS),
        remarks=(*files.remarks, *(shown(remark) for remark in result["remarks"])),
        learn_arguments=learn_arguments,
    )
    return measurements, [shown(message) for message in result["warnings"]]
