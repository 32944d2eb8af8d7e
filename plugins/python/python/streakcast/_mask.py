"""Masks of the streaks of satellites in frames."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np
import numpy.typing as npt

from . import _core
from ._frames import as_files
from ._injection import _angle, _integers, _scalar, _without_none
from ._measure import MeasureQueries, Measurements
from ._quantities import finite_scalar, scalar
from ._setup import document
from ._streak_tables import streak_files
from ._tables import Main, table_of
from ._warnings import warn_of_frames
from .typing import (
    FloatLike, FrameLike, HeaderLike, Json, Options, Output, PathLike, StreaksLike, Table, TimeLike, WholeLike,
)  # fmt: skip

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from astropy.nddata import NDData
    from astropy.units import Quantity

_STREAKS = Main(("name", "probability", "pixels"), ("magnitude", "width_arcsec", "coverage"))


@dataclass(frozen=True)
class StreakMask:
    """Mask of the streaks of satellites in a frame."""

    #: Masks by the numbers of their HDUs, from 0; shape ``(rows, columns)``, true where the light of a streak may be.
    masks: Mapping[int, npt.NDArray[np.bool_]]
    #: One row per polygon of a corridor, with the columns of ``streakcast mask --polygons``: `~astropy.table.QTable` or
    #: dictionary of arrays.
    streaks: Table
    #: Satellites that may be in the frame and are left out, and those of unknown position, with the reasons.
    left_out: Table
    #: Summary in one line.
    summary: str
    #: Other remarks.
    remarks: tuple[str, ...]
    #: `~astropy.nddata.NDData` or masked array whose mask contains the streaks too; `None` for frames of other forms.
    frame: NDData | np.ma.MaskedArray[tuple[int, int], np.dtype[np.generic]] | None

    @property
    def mask(self) -> npt.NDArray[np.bool_]:
        """Mask of a frame with one chip.

        Raises
        ------
        ValueError
            The frame has several chips.
        """
        if len(self.masks) != 1:
            raise ValueError(f"the frame has {len(self.masks)} chips; use masks[hdu] with hdu in {list(self.masks)}")
        return next(iter(self.masks.values()))


class MaskQueries(MeasureQueries):
    """Masks of frames."""

    def mask(
        self,
        frame: FrameLike,
        *,
        header: HeaderLike | None = None,
        start: TimeLike | None = None,
        exposure: FloatLike | None = None,
        scale: str | None = None,
        hdu: WholeLike | None = None,
        coverage: FloatLike = 0.95,
        threshold: FloatLike | None = None,
        min_probability: FloatLike | None = None,
        width: str | Quantity | None = None,
        seeing: str | Quantity | None = None,
        psf: str | None = None,
        zero_point: FloatLike | None = None,
        zero_point_1s: FloatLike | None = None,
        band: str | None = None,
        telescope: PathLike | Options | None = None,
        measured: StreaksLike | Sequence[PathLike] | Measurements | None = None,
        table: Output = "auto",
    ) -> StreakMask:
        """Masks the streaks of the satellites in a frame; the result is identical to that of ``streakcast mask``.

        With ``measured``, the streaks of the frame that were found are masked where they are.

        Parameters
        ----------
        frame : path, array, `~astropy.nddata.NDData`, `~astropy.io.fits.HDUList` or HDU
            A FITS file with world coordinates, or a frame in memory, as for `streakcast.inject`.
        header : `~astropy.io.fits.Header`, `~astropy.wcs.WCS`, dict or str, optional
            World coordinates of an array and the other keywords of its header; required for an array.
        start : time, optional
            Shutter opening; default: from the header.
        exposure : float or `~astropy.units.Quantity`, optional
            Duration of the exposure, seconds; default: from the header.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number in ``start``.
        hdu : int or list of int, optional
            HDUs of the file to use, from 0; default: all images with world coordinates.
        coverage : float
            Probability that the streak of a satellite is in its corridor, 0.5 to 0.999.
        threshold : float, optional
            Light is masked down to this multiple of the local noise of a pixel, default 1; fainter satellites are left
            out.
        min_probability : float, optional
            Smallest probability of a crossing of satellites whose predicted track misses the frame; default 0.01.
        width : str or `~astropy.units.Quantity`, optional
            Full width of the light of all streaks, instead of that from brightness, seeing, zero point and noise;
            excludes ``threshold``, ``seeing``, ``psf`` and zero points.
        seeing : str or `~astropy.units.Quantity`, optional
            FWHM of the image of a star, with its unit; default: that of the telescope.
        psf : str, optional
            ``gaussian``, ``moffat`` (β 3.5), ``moffat:BETA`` or ``double``; default: ``moffat``.
        zero_point, zero_point_1s : float or `~astropy.units.Quantity`, optional
            Magnitude of a star whose image sums to 1 in the unit of the frame, or that gives 1 count per second;
            default: from the header.
        band : str, optional
            Band of the magnitudes; default: filter in the header, or else the model's band.
        telescope : path or dict, optional
            Preset name or TOML file, for seeing and defocus; default: that of the model.
        measured : Measurements, path, list of paths, or table, optional
            Result of `measure` for the same frame, its table, or files with tables of ``streakcast measure``; default:
            ``measured`` of the model. A table belongs to the frame with the same file name; all frames in memory have the
            name ``frame``.
        table : {"auto", "qtable", "dict"}
            Form of the tables, as for `flags`.

        Returns
        -------
        StreakMask
            ``mask`` is the boolean array.

        Raises
        ------
        StreakcastError
            World coordinates, zero point, seeing or the time are missing, a number is out of range, or arguments exclude
            each other.
        TypeError
            A number is given as time without a scale, or an angle has no unit.

        Warns
        -----
        StreakcastWarning
            More than half of a chip is masked, positions are unknown, measured streaks are not used, chips were omitted, or
            element sets are old.
        """
        if not hasattr(_core, "mask"):
            raise NotImplementedError("mask is not in this build: it needs CFITSIO, which does not build on Windows")
        request: dict[str, Json] = dict(
            hdu=_integers(hdu), coverage=finite_scalar(coverage, "", "coverage"),
            threshold=_scalar(threshold, "", "threshold"), width=_angle(width, "width"),
            seeing=_angle(seeing, "seeing"), psf=psf, zero_point=_scalar(zero_point, "mag", "zero_point"),
            zero_point_1s=_scalar(zero_point_1s, "mag", "zero_point_1s"),
        )  # fmt: skip
        if start is not None:
            request["start"] = _core.utc_text(*self._moment(start, scale))
        if exposure is not None:
            request["exposure"] = f"{scalar(exposure, 's', 'exposure')!r}s"
        camera = {"telescope": telescope, "band": band, "min_probability": min_probability}
        tables = measured.table if isinstance(measured, Measurements) else measured
        with streak_files(cast("StreaksLike | None", tables), "measured") as own, as_files([frame], header) as files:
            model = self
            if own.paths:
                # The measured streaks also correct the predictions of the sky.
                corrected: dict[str, Json] = {**self._state["setup"], "measured": [*own.paths]}
                model = self._of_state({**self._state, "setup": corrected, "files": None})
            sky_cache, _ = model._open()
            setup = {**model._state["setup"], **document(camera)}
            request["image"] = [*files.paths]
            result = _core.mask(json.dumps(_without_none(request)), json.dumps(setup), self._state["config"], sky_cache)

        def shown(text: str) -> str:
            return files.shown(own.shown(text))

        warn_of_frames(shown(message) for message in result["warnings"])
        # Warnings about the elements and the measurements of this sky.
        self._warn_once([own.shown(message) for message in sky_cache.news()])
        return StreakMask(
            masks=result["masks"],
            streaks=table_of(files.named(result["streaks"]), table, main=_STREAKS),
            left_out=table_of(files.named(result["left_out"]), table),
            summary=result["summary"],
            remarks=(*files.remarks, *(shown(remark) for remark in result["remarks"])),
            frame=None if files.images[0] is None else files.images[0].masked(next(iter(result["masks"].values()))),
        )
