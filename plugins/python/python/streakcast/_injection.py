"""Injection of streaks into FITS files and arrays with world coordinates."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from ._frames import Image, as_files, is_path, read_hdu_list
from ._quantities import count, finite_scalar, is_quantity, number, scalar
from ._setup import absolute, document
from ._sparse import SparseImage
from ._streak_tables import streak_files
from ._tables import TRUTH, Main, table_of
from ._times import to_tai
from ._warnings import warn_of_frames
from .typing import (
    FloatArrayLike,
    FloatLike,
    FrameLike,
    HeaderLike,
    Json,
    Options,
    Output,
    PathLike,
    Pixels,
    StreaksLike,
    Table,
    TimeLike,
    WholeLike,
)

if TYPE_CHECKING:
    from astropy.units import Quantity

    from .model import StreakModel

_POINTS = Main(("streak", "utc", "x_pix", "y_pix"), ("ra_deg", "dec_deg", "magnitude"))


@dataclass(frozen=True)
class Injected:
    """Result of an injection."""

    #: File that was written; `None` for a frame in memory.
    path: Path | None
    #: Image with streaks, in the data type of the input; `None` for a file or HDU list.
    image: Pixels | None
    #: Bit numbers: ``STREAK`` where a streak exceeds the noise, ``INJECTED`` where light was added.
    mask_planes: dict[str, int]
    #: One row per streak and chip: ends in pixels and on the sky, magnitude, length, width, counts.
    truth: Table
    #: Points along each streak.
    points: Table
    #: Streaks as rows for Rubin's ``source_injection``.
    trails: Table
    #: Summary in one line.
    summary: str
    #: Frame with streaks in the form of the input: path of the output, `~astropy.io.fits.HDUList`, HDU,
    #: `~astropy.nddata.NDData` or array.
    frame: FrameLike
    #: Remarks, for example about columns of a table of streaks that are not used.
    remarks: tuple[str, ...]
    #: Text of each file of labels, by its name. The files are written beside ``output``.
    labels: Mapping[str, str]
    _added: SparseImage[np.float32 | np.float64] | None = field(repr=False)
    _mask: SparseImage[np.int32] | None = field(repr=False)

    @cached_property
    def added(self) -> npt.NDArray[np.float32 | np.float64] | None:
        """Value added to each pixel, ``float32`` or, for images of double precision, ``float64``; `None` for a file or HDU
        list. The array is created when it is first read.
        """
        return None if self._added is None else self._added.dense()

    @cached_property
    def mask(self) -> npt.NDArray[np.int32] | None:
        """Mask bits of each pixel, ``int32`` (see ``mask_planes``); `None` for a file or HDU list, whose masks are
        extensions. The array is created when it is first read.
        """
        return None if self._mask is None else self._mask.dense()


def inject(
    frame: FrameLike,
    output: PathLike | None = None,
    *,
    model: StreakModel | None = None,
    header: HeaderLike | None = None,
    start: TimeLike | None = None,
    exposure: FloatLike | None = None,
    scale: str | None = None,
    random_streaks: int | None = None,
    streak_density: FloatLike | None = None,
    magnitude: FloatArrayLike | None = None,
    streak_rate_deg_s: FloatArrayLike | None = None,
    streaks: StreaksLike | None = None,
    satellite_size: FloatLike | None = None,
    telescope: PathLike | Options | None = None,
    band: str | None = None,
    seeing: str | Quantity | None = None,
    psf: str = "moffat",
    psf_oversampling: int | None = None,
    zero_point: FloatLike | None = None,
    zero_point_1s: FloatLike | None = None,
    gain: FloatLike | None = None,
    detector: PathLike | None = None,
    noise: bool = True,
    seed: int = 0,
    hdu: WholeLike | None = None,
    pixel_scale: str | Quantity | None = None,
    track_rate: FloatArrayLike | Sequence[FloatLike] | None = None,
    tumbling: FloatArrayLike | Sequence[FloatLike] | None = None,
    glints: Sequence[FloatArrayLike | Sequence[FloatLike]] = (),
    light_curve: PathLike | None = None,
    resolve_panels: bool = False,
    truth_points: int = 11,
    mask_bits: str = "lsst",
    labels: str | Sequence[str] = (),
    pixels_only: bool = False,
    table: Output = "auto",
) -> Injected:
    """Adds streaks to a FITS file or a frame in memory; the result is identical to that of ``streakcast inject``.

    Parameters
    ----------
    frame : path, array, `~astropy.nddata.NDData`, `~astropy.io.fits.HDUList` or HDU
        A FITS file (mosaics and compressed ones too), its HDUs, one HDU with an image, a `~astropy.nddata.CCDData` or
        other `~astropy.nddata.NDData` with world coordinates, or an image ``(rows, columns)`` of ``float32, float64,
        uint8, int16, uint16`` or ``int32``, or other integers within the limits of ``int32``; row 0 is the first row in
        FITS order. The frame is not modified. The unit of an `~astropy.nddata.NDData` or `~astropy.units.Quantity` has
        precedence over BUNIT. The variance of the noise of streaks is added to a standard deviation, variance or inverse variance in ``uncertainty``.
    output : path, optional
        The file to write (atomically); required if ``frame`` is a path.
    model : StreakModel, optional
        Model whose satellites cross the frame; see `StreakModel.inject`. Without a model, streaks are random.
    header : `~astropy.io.fits.Header`, `~astropy.wcs.WCS`, dict or str, optional
        World coordinates of an array and the other keywords of its header (exposure, zero point, gain). A string has
        one card per line, or cards of 80 characters. Required for an array without ``pixel_scale``.
    start : time, optional
        Shutter opening; default: from the header.
    exposure : float or `~astropy.units.Quantity`, optional
        Duration of the exposure, seconds; default: from the header.
    scale : {"utc", "tai", "tt"}, optional
        Scale of a bare number in ``start``.
    random_streaks : int, optional
        Number of random streaks, instead of satellites.
    streak_density : float or `~astropy.units.Quantity`, optional
        Mean number of random streaks per square degree, instead of satellites.
    magnitude : float, pair or `~astropy.units.Quantity`, optional
        Magnitude of the random objects if they did not move: one value, or the brightest and the faintest.
    streak_rate_deg_s : float, pair or `~astropy.units.Quantity`, optional
        Angular rate of random streaks, deg/s: one value, or the slowest and the fastest; default 0.2 to 0.8.
    streaks : path, `~astropy.table.Table`, dict of columns or list of dicts, optional
        Table of streaks (CSV or ECSV), instead of satellites: one row a streak, with its ends and its magnitude or peak.
        Light curves in tables that are not files need absolute paths.
    satellite_size : float or `~astropy.units.Quantity`, optional
        Diameter of the satellites, m, 0 for points; default: that of the model, 2 m for random streaks.
    telescope : str, path or dict, optional
        Preset name or TOML file, for seeing and defocus of near satellites; default: that of the model.
    band : str, optional
        Band of the magnitudes; default: filter in the header, or else the model's band.
    seeing : str or `~astropy.units.Quantity`, optional
        FWHM of the image of a star, with its unit; default: that of the telescope.
    psf : str
        ``gaussian``, ``moffat`` (β 3.5), ``moffat:BETA`` or ``double``; or the path of an image (``.fits``) or of a file of
        PSFEx (``.psf``), in place of seeing, defocus and size.
    psf_oversampling : int, optional
        Number of pixels of the image of ``psf`` along a pixel of the frame; default: OVERSAMP in its header, or else 1.
    zero_point, zero_point_1s : float or `~astropy.units.Quantity`, optional
        Magnitude of a star whose image sums to 1 in the unit of the frame, or that gives 1 count per second; default:
        from the header.
    gain : float or `~astropy.units.Quantity`, optional
        Electrons per count (``electron / adu`` or ``electron / ct``); default: from the header.
    detector : path, optional
        Detector description (TOML): saturation with bleeding, crosstalk, vignetting and more.
    noise : bool
        Whether the added light includes photon noise (requires the gain).
    seed : int
        Seed of the random numbers. The same seed gives the same frame.
    hdu : int or list of int, optional
        HDUs of the file to use, from 0; default: all images.
    pixel_scale : str or `~astropy.units.Quantity`, optional
        Pixel scale, for random streaks and streaks in pixels in a frame without world coordinates.
    track_rate : pair or `~astropy.units.Quantity`, optional
        Non-sidereal tracking rate of the telescope: arcsec/s towards east and north.
    tumbling : sequence, optional
        Period (s), amplitude (mag) and, optionally, phase (turns) of a tumbling body; numbers or `Quantity`.
    glints : sequence of triples
        Flashes: magnitude, time in seconds after the closest approach to the frame's centre, full width in seconds;
        numbers or `Quantity`.
    light_curve : path, optional
        A CSV file of ``time_s`` and ``delta_mag``.
    resolve_panels : bool
        Whether chassis and solar array are drawn as separate light sources.
    truth_points : int
        Points along each streak in ``points``.
    mask_bits : {"lsst", "desdm", "last", "ztf", "hst"}
        Survey that defines the mask bits.
    labels : {"coco", "yolo", "ds9"} or a list of them
        Labels for the training of detectors: outlines of the streaks as COCO JSON, oriented boxes of YOLO, or regions of
        DS9. In COCO and YOLO, y increases with the rows of the array.
    pixels_only : bool
        Whether the mask and truth extensions of a file, and the mask of an array, are omitted.
    table : {"auto", "qtable", "dict"}
        Form of the tables: `~astropy.table.QTable` or dictionaries of arrays; ``auto``: the former if astropy is
        installed.

    Returns
    -------
    Injected

    Raises
    ------
    StreakcastError
        World coordinates, zero point or start are missing, there is nothing to inject, or a number is out of range. The
        message contains the accepted values.
    TypeError
        An array has another type, a number is given as time without a scale, or an angle has no unit.

    Warns
    -----
    StreakcastWarning
        Light was added without noise because the gain is unknown; chips were omitted; element sets are old.
    """
    options: dict[str, Json] = dict(
        random_streaks=None if random_streaks is None else count(random_streaks, "random_streaks", 0),
        streak_density=_scalar(streak_density, "1 / deg2", "streak_density"),
        magnitude=_numbers(magnitude, "mag", "magnitude"),
        streak_rate_deg_s=_numbers(streak_rate_deg_s, "deg / s", "streak_rate_deg_s"), psf=psf,
        psf_oversampling=None if psf_oversampling is None else count(psf_oversampling, "psf_oversampling", 1),
        satellite_size=_scalar(satellite_size, "m", "satellite_size"),
        zero_point=_scalar(zero_point, "mag", "zero_point"), zero_point_1s=_scalar(zero_point_1s, "mag", "zero_point_1s"),
        gain=_scalar(gain, "electron / adu", "gain"), seed=count(seed, "seed", 0),
        track_rate=_numbers(track_rate, "arcsec / s", "track_rate"),
        tumbling=_mixed(tumbling, ("s", "mag", "cycle"), "tumbling"),
        glint=[_mixed(glint, ("mag", "s", "s"), f"glints[{index}]") for index, glint in enumerate(glints)],
        resolve_panels=bool(resolve_panels), truth_points=count(truth_points, "truth_points", 2), mask_bits=mask_bits,
        labels=[labels] if isinstance(labels, str) else list(labels),
        pixels_only=bool(pixels_only), no_noise=not noise, hdu=_integers(hdu),
        seeing=_angle(seeing, "seeing"), pixel_scale=_angle(pixel_scale, "pixel_scale"),
        detector=None if detector is None else absolute(detector),
        light_curve=None if light_curve is None else absolute(light_curve),
    )  # fmt: skip
    if zero_point is not None and zero_point_1s is not None:
        raise ValueError("zero_point and zero_point_1s exclude each other; allowed: one of them")
    if random_streaks is not None and streak_density is not None:
        raise ValueError("random_streaks and streak_density exclude each other; allowed: one of them")
    is_random = random_streaks is not None or streak_density is not None
    if is_random and magnitude is None:
        raise ValueError("missing magnitude of random streaks; specify magnitude=...")
    if streaks is not None and (is_random or model is not None):
        raise ValueError("streaks exclude random streaks and a model; allowed: one of them")
    if is_random and model is not None:
        raise ValueError("a model and random streaks exclude each other; allowed: one of them")
    if start is not None:
        time_scale = model.mjd_scale if scale is None and model is not None else scale
        options["start"] = start if isinstance(start, str) and time_scale is None else _moment(start, time_scale)
    if exposure is not None:
        length_s = scalar(exposure, "s", "exposure")
        if not (np.isfinite(length_s) and length_s > 0.0):
            raise ValueError(f"exposure is {length_s} s; allowed: above 0 s")
        options["exposure"] = f"{length_s!r}s"

    camera = document({"telescope": telescope, "band": band})
    sky_cache, config, setup = None, None, camera
    if model is not None:
        sky_cache, _ = model._open()
        config, setup = model._state["config"], {**model._state["setup"], **camera}

    if not hasattr(_core, "inject"):
        raise NotImplementedError("inject is not in this build: it needs CFITSIO, which does not build on Windows")
    if not is_path(frame) and output is not None:
        raise ValueError("output is given for an array; allowed: with a file (the frame with streaks is returned)")
    if is_path(frame) and output is None:
        raise ValueError("missing output file; specify output=...")
    if is_path(frame) and os.path.realpath(str(output)) == os.path.realpath(str(frame)):
        raise ValueError(f"{output} is the input; allowed: another output file")
    or_else = " (or pixel_scale=... for random streaks)" if is_random else ""
    with streak_files(streaks) as tables, as_files([frame], header, needs_header=pixel_scale is None, or_else=or_else) as files:
        if tables.paths:
            options["streaks"] = tables.paths[0]
        target = os.path.join(files.folder, "injected") if output is None else absolute(output)
        request = json.dumps(_without_none({**options, "image": [*files.paths]}))
        result = _core.inject(request, json.dumps(setup), config, sky_cache, target)
        done = _done(frame, files.images[0], target, output, with_mask=not pixels_only)

    def shown(text: str) -> str:
        return files.shown(tables.shown(text))

    warn_of_frames(shown(message) for message in result["warnings"])
    if model is not None:
        # Old element sets, as in the other methods.
        model._warn_once([])
    truth = result["truth"] if output is not None else [one for one in result["truth"] if one["name"] != "image"]
    streak_bit, injected_bit = result["bits"]
    return Injected(
        path=Path(output) if output is not None else None,
        image=done.image,
        mask_planes={"STREAK": streak_bit, "INJECTED": injected_bit},
        truth=table_of(truth, table, main=TRUTH),
        points=table_of(result["points"], table, main=_POINTS),
        trails=table_of(result["trails"], table),
        summary=result["summary"],
        frame=done.frame,
        remarks=(*files.remarks, *(shown(remark) for remark in result["remarks"])),
        labels=dict(result["labels"]),
        _added=done.added,
        _mask=done.mask,
    )


class _Done(NamedTuple):
    frame: FrameLike
    image: Pixels | None = None
    added: SparseImage[np.float32 | np.float64] | None = None
    mask: SparseImage[np.int32] | None = None


#: Number of rows that are read at once.
_ROWS = 32


def _done(frame: FrameLike, given: Image | None, target: str, output: PathLike | None, with_mask: bool) -> _Done:
    """Returns the frame in the output file in the form in which it was given."""
    if output is not None:
        return _Done(Path(output))
    if given is None:
        return _Done(read_hdu_list(target, frame))
    before, errors = given.pixels, given.errors()
    kind, columns = before.dtype.name, before.shape[1]
    image: Pixels = np.empty(before.shape, kind)
    is_single = kind == "float32" or before.dtype.itemsize <= 2
    wide: type[np.float32 | np.float64] = np.float32 if is_single else np.float64
    added, mask = SparseImage(columns, wide), SparseImage(columns, np.int32)
    # The output contains the planes of the input, and then the mask if there are streaks.
    hdu_of_mask = len(given.planes())
    for first in range(0, len(before), _ROWS):
        end = min(first + _ROWS, len(before))
        old, new = before[first:end], _core.read_rows(target, 0, kind, first, end)
        assert new is not None
        image[first:end] = new
        # The difference is exact also for unsigned integers. NaN pixels, which differ from themselves, stay NaN.
        added.append(np.subtract(new, old, out=np.zeros(new.shape, wide), where=new != old, dtype=wide))
        if errors is not None and given.variance is not None:
            variance = _core.read_rows(target, 2, given.variance.dtype.name, first, end)
            assert variance is not None
            given.change_errors(errors[first:end], given.variance[first:end], variance)
        bits = _core.read_rows(target, hdu_of_mask, "int32", first, end) if with_mask else None
        mask.append(np.zeros(new.shape, np.int32) if bits is None else bits)
    if given.integers is not None:
        limits = np.iinfo(given.integers)
        # Of the other integers, only int8 has a smaller range than int32.
        image = (image.clip(limits.min, limits.max) if limits.bits < 32 else image).astype(given.integers)
    return _Done(given.like(image, errors), image, added, mask if with_mask else None)


def _without_none(options: Mapping[str, Json]) -> dict[str, Json]:
    return {key: value for key, value in options.items() if value is not None}


def _scalar(value: FloatLike | None, unit: str, what: str) -> float | None:
    return None if value is None else finite_scalar(value, unit, what)


def _numbers(value: object, unit: str, what: str) -> list[Json]:
    """Returns one or several numbers as a list; empty for `None`."""
    return [] if value is None else _all_finite(np.ravel(number(value, unit, what)).tolist(), what)


def _mixed(values: FloatArrayLike | Sequence[FloatLike] | None, units: tuple[str, ...], what: str) -> list[Json]:
    """Returns numbers of different units as a list; empty for `None`. Their count is checked by the library."""
    if values is None:
        return []
    items = values if isinstance(values, (list, tuple)) else list(np.asanyarray(values).reshape(-1))
    # Superfluous numbers are passed on without a unit.
    units += ("",) * (len(items) - len(units))
    numbers = [scalar(one, unit, f"{what}[{index}]") for index, (one, unit) in enumerate(zip(items, units))]
    return _all_finite(numbers, what)


def _all_finite(numbers: list[float], what: str) -> list[Json]:
    for index, one in enumerate(numbers):
        if not np.isfinite(one):
            raise ValueError(f"{what}[{index}] is {one}; allowed: finite numbers")
    return [*numbers]


def _integers(value: WholeLike | None) -> list[Json]:
    return [] if value is None else [count(one, "hdu", 0) for one in np.ravel(value).tolist()]


def _angle(value: object, what: str) -> str | None:
    """Returns an angle as a string with its unit."""
    if value is None or isinstance(value, str):
        return value
    if is_quantity(value):
        return f"{scalar(value, 'arcsec', what)!r}arcsec"
    raise TypeError(f"{what} is {type(value).__name__}; allowed: a string with a unit (\"1.2arcsec\"), or a Quantity")


def _moment(value: TimeLike, scale: str | None) -> str:
    jd1, jd2 = to_tai(value, scale, "start")
    if np.shape(jd1) != ():
        raise ValueError(f"start has the shape {np.shape(jd1)}; allowed: one time")
    return _core.utc_text(float(jd1), float(jd2))
