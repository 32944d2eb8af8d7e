"""Measurement of the streaks of satellites in frames."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypedDict, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._exposure_queries import ExposureQueries
from ._injection import _angle, _integers, _without_none
from ._quantities import FloatArray, scalar
from ._setup import absolute, document
from ._tables import table_of
from ._times import TimeLike

if TYPE_CHECKING:
    from astropy.table import QTable
    from astropy.units import Quantity

#: Path of a file.
PathLike = Union[str, "os.PathLike[str]"]


class LearnArguments(TypedDict):
    """Arguments of `streakcast.learn`, each of shape ``(n_streaks,)``."""

    #: NORAD catalogue numbers.
    norad_id: npt.NDArray[np.int64]
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

    #: One row per predicted track and chip, with the columns of ``streakcast measure``: `~astropy.table.QTable` or
    #: dictionary of arrays.
    table: "Union[QTable, dict[str, npt.NDArray[np.generic]]]"
    #: Zero points from stars, and other remarks.
    remarks: tuple[str, ...]
    #: Measured magnitudes of the streaks that were found, without instrumental and saturated ones.
    learn_arguments: LearnArguments


class MeasureQueries(ExposureQueries):
    """Measurement of frames."""

    def measure(
        self,
        frames: Union[PathLike, Sequence[PathLike]],
        *,
        start: Union[TimeLike, None] = None,
        exposure: "Union[float, Quantity, None]" = None,
        scale: Union[str, None] = None,
        hdu: Union[int, Sequence[int], None] = None,
        seeing: "Union[str, Quantity, None]" = None,
        fit_width: bool = False,
        psf: str = "moffat",
        stars: Union[PathLike, None] = None,
        zero_point: Union[float, None] = None,
        zero_point_1s: Union[float, None] = None,
        gain: Union[float, None] = None,
        band: Union[str, None] = None,
        telescope: Union[PathLike, dict[str, object], None] = None,
        table: str = "auto",
    ) -> Measurements:
        """Measures the streaks of the satellites in frames; the result is identical to that of ``streakcast measure``.

        Parameters
        ----------
        frames : path or list of paths
            FITS files with world coordinates, including mosaics and compressed ones.
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
        stars : path, optional
            Table (CSV) of stars, from which the zero point is measured: ``ra_deg, dec_deg, mag`` and, optionally,
            ``mag_sigma`` and ``band``.
        zero_point, zero_point_1s : float, optional
            Magnitude of a star whose image sums to 1 in the unit of the frame, or that gives 1 count per second;
            default: from the header. Without any zero point, magnitudes are instrumental.
        gain : float, optional
            Electrons per count; default: from the header.
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
        if not hasattr(_core, "measure"):
            raise NotImplementedError("measure is not in this build: it needs CFITSIO, which does not build on Windows")
        if zero_point is not None and zero_point_1s is not None:
            raise ValueError("zero_point and zero_point_1s exclude each other; allowed: one of them")
        paths = [frames] if isinstance(frames, (str, os.PathLike)) else list(frames)
        request: dict[str, object] = dict(
            image=[absolute(path) for path in paths], hdu=_integers(hdu), seeing=_angle(seeing, "seeing"), psf=psf,
            fit_width=bool(fit_width), stars=None if stars is None else absolute(stars), zero_point=zero_point,
            zero_point_1s=zero_point_1s, gain=gain,
        )  # fmt: skip
        if start is not None:
            request["start"] = _core.utc_text(*self._moment(start, scale))
        if exposure is not None:
            request["exposure"] = f"{scalar(exposure, 's', 'exposure')!r}s"
        camera = {key: value for key, value in (("telescope", telescope), ("band", band)) if value is not None}
        setup = {**self._state["setup"], **document(camera)}
        sky_cache, _ = self._open()
        result = _core.measure(
            json.dumps(_without_none(request)), json.dumps(setup), self._state["config"], sky_cache
        )
        self._warn_once(sky_cache, result["warnings"])
        columns = {column["name"]: column for column in result["measurements"]}
        observed, predicted = columns["magnitude"]["values"], columns["predicted_magnitude"]["values"]
        is_saturated = np.array(["saturated" in flags for flags in columns["flags"]["values"]], dtype=np.bool_)
        is_usable = columns["calibrated"]["values"] & ~is_saturated & np.isfinite(observed) & np.isfinite(predicted)
        times = columns["mid_utc"]["utc_ns"].view("datetime64[ns]")
        return Measurements(
            table=table_of(result["measurements"], table),
            remarks=tuple(result["remarks"]),
            learn_arguments=LearnArguments(
                norad_id=columns["norad_id"]["values"][is_usable],
                time=np.datetime_as_string(times[is_usable], timezone="UTC"),
                observed=observed[is_usable],
                predicted=predicted[is_usable],
                sigma=columns["magnitude_sigma"]["values"][is_usable],
            ),
        )
