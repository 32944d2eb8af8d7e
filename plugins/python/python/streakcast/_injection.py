"""Streaks put into frames: files, and arrays with a place on the sky."""

from __future__ import annotations

import json
import os
import tempfile
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._quantities import is_of, number, scalar
from ._setup import absolute, document
from ._tables import TableLike, table_of
from ._times import TimeLike, to_tai
from .errors import StreakcastWarning

if TYPE_CHECKING:
    from .model import StreakModel


class Injected(NamedTuple):
    """What was put into a frame."""

    #: The file that was written; `None` for an array.
    path: Union[Path, None]
    #: The image with streaks, of the type of the one given; `None` for a file.
    image: Any
    #: What was added to each pixel, ``float32`` or, for images of double precision, ``float64``; `None` for a file.
    added: Any
    #: Bits of each pixel, ``int32`` (see ``mask_planes``); `None` for a file, whose masks are its extensions.
    mask: Any
    #: Numbers of the bits: ``STREAK`` where a streak stands out of the noise, ``INJECTED`` where there is any light.
    mask_planes: dict[str, int]
    #: One row a streak and chip: ends in pixels and on the sky, magnitude, length, width, counts.
    truth: TableLike
    #: Points along each streak.
    points: TableLike
    #: The same as rows for Rubin's ``source_injection``.
    trails: TableLike
    #: What was done, in one line.
    summary: str


def inject(
    frame: Any,
    output: "Union[str, os.PathLike[str], None]" = None,
    *,
    model: "Union[StreakModel, None]" = None,
    header: Any = None,
    start: Union[TimeLike, None] = None,
    exposure: Any = None,
    scale: Union[str, None] = None,
    random_streaks: Union[int, None] = None,
    streak_density: Union[float, None] = None,
    magnitude: Any = None,
    streak_rate_deg_s: Any = None,
    telescope: Any = None,
    band: Union[str, None] = None,
    seeing: Any = None,
    psf: str = "moffat",
    zero_point: Union[float, None] = None,
    zero_point_1s: Union[float, None] = None,
    gain: Union[float, None] = None,
    detector: "Union[str, os.PathLike[str], None]" = None,
    noise: bool = True,
    seed: int = 0,
    hdu: Any = None,
    pixel_scale: Any = None,
    track_rate: Any = None,
    tumbling: Any = None,
    glints: Any = (),
    light_curve: "Union[str, os.PathLike[str], None]" = None,
    resolve_panels: bool = False,
    truth_points: int = 11,
    mask_bits: str = "lsst",
    pixels_only: bool = False,
    table: str = "auto",
) -> Injected:
    """Puts streaks into a FITS file or an array: what ``streakcast inject`` does, to the last bit.

    Parameters
    ----------
    frame : path or array
        A FITS file (mosaics and compressed ones too), or an image ``(rows, columns)`` of ``float32, float64, uint8, int16, uint16`` or
        ``int32``, whose row 0 is the one that FITS holds first. The array stays as it is.
    output : path, optional
        The file to write, whole or not at all; needed where ``frame`` is a file.
    model : StreakModel, optional
        Whose satellites pass through the frame; see `StreakModel.inject`. Without it streaks are random.
    header : `~astropy.io.fits.Header`, `~astropy.wcs.WCS` or str, optional
        World coordinates of an array, and what else its header says (exposure, zero point, gain). A text has one card a line, or cards of 80
        characters.
    start : time, optional
        Shutter opening; the header's where not said.
    exposure : float or `~astropy.units.Quantity`, optional
        Length of the exposure, seconds; the header's where not said.
    scale : {"utc", "tai", "tt"}, optional
        Scale of a bare number in ``start``.
    random_streaks : int, optional
        As many random streaks instead of satellites.
    streak_density : float, optional
        As many random streaks a square degree, on the average.
    magnitude : float or pair, optional
        Magnitude of random streaks, as if they stood still: one, or the brightest and the faintest.
    streak_rate_deg_s : float or pair, optional
        Their speed over the frame, deg/s: one, or the slowest and the fastest; 0.2 to 0.8 where not said.
    telescope : str, path or dict, optional
        A preset or TOML file: seeing, and the defocus of near satellites; the model's where not said.
    band : str, optional
        Band of magnitudes; the header's filter, else the model's, where not said.
    seeing : str or `~astropy.units.Quantity`, optional
        FWHM of a star's image, with its unit; the telescope's where not said.
    psf : str
        ``gaussian``, ``moffat`` (β 3.5), ``moffat:BETA`` or ``double``.
    zero_point, zero_point_1s : float, optional
        Magnitude of a star whose image sums to 1 in the frame's unit, or of one that makes 1 count a second; the header's where not said.
    gain : float, optional
        Electrons a count; the header's where not said.
    detector : path, optional
        A detector (TOML): saturation with bleeding, crosstalk, vignetting and more.
    noise : bool
        Whether the light has the noise of its own electrons (where the gain is known).
    seed : int
        The same seed gives the same frame.
    hdu : int or list of int, optional
        These HDUs of a file alone, from 0.
    pixel_scale : str or `~astropy.units.Quantity`, optional
        Side of a pixel, for random streaks in a frame that says nothing of the sky.
    track_rate : pair, optional
        What the telescope follows: arcsec/s towards east and north.
    tumbling : sequence, optional
        Period (s), amplitude (mag) and, where wanted, phase (turns) of a tumbling body.
    glints : sequence of triples
        Flashes: magnitude, seconds after the light passes nearest to the frame's middle, full width in seconds.
    light_curve : path, optional
        A CSV file of ``time_s`` and ``delta_mag``.
    resolve_panels : bool
        Chassis and solar array as two lights.
    truth_points : int
        Points along each streak in ``points``.
    mask_bits : {"lsst", "desdm", "last", "ztf", "hst"}
        Whose bits the masks have.
    pixels_only : bool
        No extensions of masks and truth in a file, no mask for an array.
    table : {"auto", "qtable", "dict"}
        Form of the tables: `~astropy.table.QTable`, or dictionaries of arrays; by itself the first where astropy is there.

    Returns
    -------
    Injected

    Raises
    ------
    StreakcastError
        What cannot be done, and what is allowed: no world coordinates, no zero point, no start, nothing to inject, numbers out of range.
    TypeError
        An array of another type; a bare number of time without a scale; an angle without a unit.

    Warns
    -----
    StreakcastWarning
        Light without noise because the gain is not known; chips left out; old elements.
    """
    is_file = isinstance(frame, (str, os.PathLike))
    said: dict[str, Any] = dict(
        random_streaks=random_streaks, streak_density=streak_density, magnitude=_numbers(magnitude, "magnitude"),
        streak_rate_deg_s=_numbers(streak_rate_deg_s, "streak_rate_deg_s"), psf=psf, zero_point=zero_point,
        zero_point_1s=zero_point_1s, gain=gain, seed=int(seed), track_rate=_numbers(track_rate, "track_rate"),
        tumbling=_numbers(tumbling, "tumbling"), glint=[_numbers(glint, "glints") for glint in glints],
        resolve_panels=bool(resolve_panels), truth_points=int(truth_points), mask_bits=mask_bits,
        pixels_only=bool(pixels_only), no_noise=not noise, hdu=_whole_numbers(hdu),
        seeing=_angle(seeing, "seeing"), pixel_scale=_angle(pixel_scale, "pixel_scale"),
        detector=None if detector is None else absolute(detector),
        light_curve=None if light_curve is None else absolute(light_curve),
    )  # fmt: skip
    if seed < 0:
        raise ValueError(f"seed {seed}; allowed: 0 or more")
    if zero_point is not None and zero_point_1s is not None:
        raise ValueError("zero_point and zero_point_1s; allowed: one of them")
    if random_streaks is not None and streak_density is not None:
        raise ValueError("random_streaks and streak_density; allowed: one of them")
    is_random = random_streaks is not None or streak_density is not None
    if is_random and magnitude is None:
        raise ValueError("random streaks need a magnitude")
    if is_random and model is not None:
        raise ValueError("a model and random streaks; allowed: one of them")
    if start is not None:
        known = model.mjd_scale if scale is None and model is not None else scale
        said["start"] = start if isinstance(start, str) and known is None else _moment(start, known)
    if exposure is not None:
        length_s = scalar(exposure, "s", "exposure")
        if not (np.isfinite(length_s) and length_s > 0.0):
            raise ValueError(f"exposure {length_s} s; allowed: above 0 s")
        said["exposure"] = f"{length_s!r}s"

    camera = document({key: value for key, value in (("telescope", telescope), ("band", band)) if value is not None})
    skies, config, setup = None, None, camera
    if model is not None:
        skies, _ = model._open()
        config, setup = model._state["config"], {**model._state["setup"], **camera}

    if is_file:
        if output is None:
            raise ValueError("a file needs an output to write")
        if header is not None:
            raise ValueError("header is for arrays; a file has its own")
        if os.path.realpath(output) == os.path.realpath(frame):
            raise ValueError(f"{os.fspath(output)} is the input and would be overwritten; name another output")
        answer = _core.inject(
            json.dumps(_given({**said, "image": [absolute(frame)]})), json.dumps(setup), config, skies, absolute(output)
        )
    else:
        if output is not None:
            raise ValueError("output is for files; the image with streaks comes back as an array")
        image = np.asarray(frame)
        if image.ndim != 2:
            raise ValueError(f"frame has the shape {image.shape}; allowed: a path, or an array of rows and columns")
        image = np.ascontiguousarray(image, dtype=image.dtype.newbyteorder("="))
        answer = _core.inject(
            json.dumps(_given(said)), json.dumps(setup), config, skies, tempfile.gettempdir(), image, _header_text(header)
        )
    for message in dict.fromkeys(answer["warnings"]):
        warnings.warn(message, StreakcastWarning, stacklevel=2)
    changed = answer.get("image")
    mask = answer.get("mask")
    if not is_file and mask is None and not pixels_only:
        mask = np.zeros(image.shape, dtype=np.int32)
    streak_bit, injected_bit = answer["bits"]
    return Injected(
        path=Path(output) if output is not None else None,
        image=changed,
        added=None if changed is None else _difference(changed, image),
        mask=mask,
        mask_planes={"STREAK": streak_bit, "INJECTED": injected_bit},
        truth=table_of(answer["truth"], table),
        points=table_of(answer["points"], table),
        trails=table_of(answer["trails"], table),
        summary=answer["summary"],
    )


def _difference(after: npt.NDArray[Any], before: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Exact also for whole numbers without sign."""
    wide = np.float32 if after.dtype == np.float32 or after.dtype.itemsize <= 2 else np.float64
    difference: npt.NDArray[Any] = np.subtract(after, before, dtype=wide)
    return difference


def _given(said: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in said.items() if value is not None}


def _numbers(value: Any, what: str) -> list[float]:
    """One number or several as a list; none for `None`."""
    return [] if value is None else [float(one) for one in np.ravel(number(value, "", what))]


def _whole_numbers(value: Any) -> list[int]:
    return [] if value is None else [int(one) for one in np.ravel(value)]


def _angle(value: Any, what: str) -> Union[str, None]:
    """An angle as the text that its unit belongs to."""
    if value is None or isinstance(value, str):
        return value
    if is_of("astropy.units", "Quantity", value):
        return f"{scalar(value, 'arcsec', what)!r}arcsec"
    raise TypeError(f"{what} is {type(value).__name__}; allowed: a text with its unit (\"1.2arcsec\"), or a Quantity")


def _moment(value: Any, scale: Union[str, None]) -> str:
    jd1, jd2 = to_tai(value, scale, "start")
    if np.shape(jd1) != ():
        raise ValueError(f"start has the shape {np.shape(jd1)}; allowed: one moment")
    return _core.utc_text(float(jd1), float(jd2))


def _header_text(header: Any) -> Union[str, None]:
    """Cards, one a line."""
    if header is None or isinstance(header, str):
        return header
    if is_of("astropy.wcs", "WCS", header):
        header = header.to_header(relax=True)
    if is_of("astropy.io.fits", "Header", header):
        text: str = header.tostring(sep="\n", endcard=False, padding=False)
        return text
    raise TypeError(f"header is {type(header).__name__}; allowed: a Header, a WCS, or the text of cards")
