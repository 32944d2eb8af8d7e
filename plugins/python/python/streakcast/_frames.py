"""Frames as files and back: the library reads paths; HDU lists, HDUs, `NDData` and arrays are written to temporary files.

The result of an injection is returned in the form of the frame.
"""

from __future__ import annotations

import copy
import os
import re
import tempfile
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from . import _core
from ._quantities import aligned, is_of
from ._setup import absolute
from .typing import FrameLike, HeaderLike, PathLike, Pixels

if TYPE_CHECKING:
    from astropy.io.fits import Header
    from astropy.nddata import NDData, NDUncertainty
    from astropy.wcs import WCS

    from ._core import Column

#: Keywords of world coordinates, which those of a given `WCS` replace.
_COORDINATES = re.compile(
    r"WCSAXES|(CTYPE|CRVAL|CRPIX|CDELT|CUNIT|CROTA)\d+|(CD|PC|PV)\d+_\d+|LONPOLE|LATPOLE|RADE?C?SYS|EQUINOX"
    r"|[AB]P?_(ORDER|DMAX|\d+_\d+)"
)
#: Keywords of times that astropy moves from a header to the `WCS`, without their comments: which of them count, and
#: those whose place they take.
_START = re.compile(r"(DATE|MJD)-(BEG|AVG|END)")
_LENGTH = re.compile(r"XPOSURE|TELAPSE")
_OTHER_START = re.compile(r"(DATE|MJD|JD|TIME|UT|UTC)-(OBS|BEG|STA\w*)|UTC?START|EXPSTART")
_OTHER_LENGTH = re.compile(r"EXP-?TIME|EXPOSURE|ITIME|ELAPTIME|SHUTTIME")
#: Shortest exposure whose unit need not be known, seconds.
_SHORTEST_S = 1e-3
#: Largest distance between the position of a pixel and that of its `WCS`: pixels and arcsec.
_SAME_PLACE = (0.5, 0.1)
#: Card of a mask whose values other than 0 mark bad pixels, however many they are.
_EXPLICIT = "BADPIX  =                    T"
#: Integers that files of frames have.
_INTEGERS = ("uint8", "int16", "uint16", "int32")
_HDUS = ("PrimaryHDU", "ImageHDU", "CompImageHDU")


def is_path(frame: object) -> bool:
    """Returns True for the path of a file."""
    return isinstance(frame, (str, os.PathLike))


def is_hdu_list(frame: object) -> bool:
    """Returns True for a list of HDUs."""
    return is_of("astropy.io.fits", "HDUList", frame)


def frames_of(frames: FrameLike | Sequence[FrameLike]) -> list[FrameLike]:
    """Returns one frame of any form, or several, as a list."""
    is_one = is_path(frames) or is_hdu_list(frames) or _is_hdu(frames) or _is_nddata(frames) or hasattr(frames, "shape")
    return [cast("FrameLike", frames)] if is_one else list(cast("Sequence[FrameLike]", frames))


def _is_hdu(frame: object) -> bool:
    return any(is_of("astropy.io.fits", name, frame) for name in _HDUS)


def _is_nddata(frame: object) -> bool:
    return is_of("astropy.nddata", "NDData", frame)


@dataclass(frozen=True)
class Image:
    """Image in memory: the pixels of an array, an HDU or an `NDData`, and what is known about them."""

    #: The frame as it was given.
    given: Any
    pixels: Pixels
    #: Header, one card per line.
    cards: str
    #: Values other than 0 mark bad pixels; `None` if no pixel is marked.
    bad: npt.NDArray[np.uint8] | None = None
    #: Variance of each pixel; `None` if it is unknown.
    variance: Pixels | None = None
    #: Type of the given integers, if the pixels are a copy of them as ``int32``.
    integers: np.dtype[Any] | None = None
    #: Remarks about the header.
    remarks: tuple[str, ...] = ()

    def planes(self) -> list[tuple[str, Pixels, str]]:
        """Returns name, pixels and header of the image and of its companion planes, as in the files of Rubin."""
        bad, variance = self.bad, self.variance
        if bad is None and variance is None:
            return [("", self.pixels, self.cards)]
        found: list[tuple[str, Pixels, str]] = [("IMAGE", self.pixels, self.cards)]
        found.append(("MASK", np.zeros(self.pixels.shape, np.uint8) if bad is None else bad, _EXPLICIT))
        if variance is not None:
            found.append(("VARIANCE", variance, ""))
        return found

    def errors(self) -> npt.NDArray[Any] | None:
        """Returns a copy of the values of an uncertainty; `None` without variances."""
        return None if self.variance is None else np.array(np.broadcast_to(self.given.uncertainty.array, self.pixels.shape))

    def change_errors(self, errors: npt.NDArray[Any], before: Pixels, after: Pixels) -> None:
        """Replaces the values of an uncertainty whose variances have changed."""
        uncertainty = self.given.uncertainty
        is_changed = (before != after) & np.isfinite(after)
        changed = _FROM_VARIANCE[uncertainty.uncertainty_type](after[is_changed])
        errors[is_changed] = changed / _unit_factor(uncertainty, self.given.unit)

    def like(self, pixels: Pixels, errors: npt.NDArray[Any] | None) -> Any:
        """Returns a frame of the same form with other pixels and, for an `NDData`, other values of its uncertainty."""
        given = self.given
        if _is_nddata(given):
            return _new_nddata(given, pixels, _new_uncertainty(given.uncertainty, errors), given.mask)
        if _is_hdu(given):
            return _new_hdu(given, pixels)
        if isinstance(given, np.ma.MaskedArray):
            return np.ma.MaskedArray(pixels, mask=np.array(given.mask), fill_value=_fill_value(given))
        return type(given)(pixels, given.unit, copy=False) if is_of("astropy.units", "Quantity", given) else pixels

    def masked(self, streaks: npt.NDArray[np.bool_]) -> Any:
        """Returns an `NDData` or masked array with the same pixels and more of them masked; `None` for other forms."""
        given, mask = self.given, streaks if self.bad is None else streaks | (self.bad != 0)
        if _is_nddata(given):
            return _new_nddata(given, np.array(given.data), _new_uncertainty(given.uncertainty), mask)
        if not isinstance(given, np.ma.MaskedArray):
            return None
        return np.ma.MaskedArray(np.array(given.data), mask=mask, fill_value=_fill_value(given))


@dataclass
class Files:
    """Files of frames."""

    #: Folder of temporary files; empty if all frames are paths.
    folder: str = ""
    #: Path of the file of each frame.
    paths: list[str] = field(default_factory=list)
    #: Image of each frame; `None` for paths and HDU lists.
    images: list[Image | None] = field(default_factory=list)
    #: Remarks about their headers.
    remarks: list[str] = field(default_factory=list)

    def shown(self, text: str) -> str:
        """Returns a message with the names of frames instead of the paths of temporary files."""
        return text.replace(self.folder + os.sep, "") if self.folder else text

    def named(self, columns: Sequence[Column]) -> Sequence[Column]:
        """Replaces the paths of temporary files in the columns of a table."""
        for column in columns:
            if column["kind"] == "text" and column["name"] == "image":
                column["values"] = [self.shown(value) for value in column["values"]]
        return columns


@contextmanager
def as_files(
    frames: Sequence[FrameLike],
    header: HeaderLike | None = None,
    *,
    what: str = "frame",
    needs_header: bool = True,
    or_else: str = "",
) -> Iterator[Files]:
    """Writes the frames that are not paths to temporary files, which exist inside the context.

    Errors name these frames ``what``, with an index if there are several, instead of the temporary file. ``header`` is
    that of the only frame, which is an array. ``or_else`` states what may replace a missing header.
    """
    files = Files()
    if all(is_path(frame) for frame in frames):
        if header is not None:
            raise ValueError("header is given for a file; allowed: with an array (a file contains its header)")
        files.paths = [absolute(frame) for frame in frames if isinstance(frame, (str, os.PathLike))]
        files.images = [None] * len(frames)
        yield files
        return
    with tempfile.TemporaryDirectory(prefix="streakcast-") as folder:
        files.folder = folder
        try:
            for index, frame in enumerate(frames):
                name = what if len(frames) == 1 else f"{what}[{index}]"
                path, image = os.path.join(folder, name), None
                if isinstance(frame, (str, os.PathLike)):
                    path = absolute(frame)
                elif is_hdu_list(frame):
                    if header is not None:
                        raise ValueError("header is given for an HDUList; allowed: with an array (an HDUList contains it)")
                    if len(frame) == 0:
                        raise ValueError(f"{name} is an HDUList without HDUs; allowed: one with an image")
                    _separate(frame).writeto(path, output_verify="ignore")
                else:
                    image = _image_of(frame, header, name, needs_header, or_else)
                    files.remarks += [f"{name}: {remark}" for remark in image.remarks]
                    _core.write_frame(path, [(plane, _native(pixels), cards) for plane, pixels, cards in image.planes()])
                files.paths.append(path)
                files.images.append(image)
            yield files
        except _core.StreakcastError as error:
            raise type(error)(files.shown(str(error))) from None


def _separate(hdus: Any) -> Any:
    """Returns HDUs with the same data and headers of their own: writing scales the data of an HDU, and changes its header.

    Compressed images whose data were read are not compressed: astropy would round all of their pixels again.
    """
    from astropy.io.fits import ImageHDU

    separate = []
    for hdu in hdus:
        if _is_decompressed(hdu):
            separate.append(ImageHDU(hdu.data, hdu.header.copy()))
            continue
        twin = copy.copy(hdu)
        setattr(twin, "_header", getattr(hdu, "_header").copy())
        separate.append(twin)
    return type(hdus)(separate)


def _is_decompressed(hdu: Any) -> bool:
    """Returns True for a compressed image whose data were read or set."""
    return is_of("astropy.io.fits", "CompImageHDU", hdu) and bool(getattr(hdu, "_has_data"))


def read_hdu_list(path: PathLike, given: Any) -> Any:
    """Returns the HDUs of a file, in memory, each of the class of the given HDU."""
    from astropy.io import fits

    with fits.open(path, memmap=False, lazy_load_hdus=False) as hdus:
        for hdu in hdus:
            # Reads the data, because the file is temporary.
            hdu.data
    for index, hdu in enumerate(given):
        if _is_decompressed(hdu):
            hdus[index] = _new_hdu(hdu, hdus[index].data, hdus[index].header)
    return hdus


def _native(pixels: Pixels) -> Pixels:
    return aligned(pixels, pixels.dtype.newbyteorder("="))


def _image_of(frame: object, header: HeaderLike | None, what: str, needs_header: bool, or_else: str) -> Image:
    """Returns the image of an array, an HDU or an `NDData`."""
    known: dict[str, Any] = {}
    data: Any = frame
    wcs = None
    if is_of("astropy.nddata.utils", "Cutout2D", frame):
        raise TypeError(
            f"{what} is a Cutout2D, which has no header; allowed: its data, with its wcs as header=..., start=... and exposure=...,"
            " or with a header that is updated by wcs.to_header()"
        )
    if _is_nddata(frame) or _is_hdu(frame):
        if header is not None:
            raise ValueError(f"header is given for a {type(frame).__name__}, which contains it; allowed: with an array")
        data = getattr(frame, "data")
    if _is_nddata(frame):
        known = {"bad": _bad(getattr(frame, "mask"), np.shape(data))}
        known["variance"] = _variance(getattr(frame, "uncertainty"), getattr(frame, "unit"), np.shape(data))
        wcs = _wcs_of(getattr(frame, "wcs"))
        of_frame, known["remarks"] = _header_of(frame, wcs)
        cards = _text(of_frame)
    elif _is_hdu(frame):
        if data is None:
            raise ValueError(f"{what} is a {type(frame).__name__} without data; allowed: an HDU with an image")
        cards = _text(getattr(frame, "header"))
        if data.dtype.kind == "i" and (frame.header.get("BSCALE", 1) != 1 or frame.header.get("BZERO", 0) != 0):  # type: ignore[attr-defined]
            raise ValueError(f"{what} was opened with do_not_scale_image_data; allowed: an HDU with scaled data")
    else:
        if header is None and needs_header:
            _check_shape(np.shape(data), what)
            raise ValueError(f"missing header of the array; specify header=...{or_else}")
        if _is_wcs(header):
            wcs = _wcs_of(header)
            of_wcs, known["remarks"] = _with_coordinates(_as_header({}), wcs)
            cards = _text(of_wcs)
        else:
            cards = _header_text(header)
        if isinstance(frame, np.ma.MaskedArray):
            data, known = frame.data, {"bad": _bad(frame.mask, frame.shape)}
        if is_of("astropy.units", "Quantity", data):
            cards += f"\nBUNIT   = '{data.unit}'"
    pixels: Pixels = np.asarray(data)
    _check_shape(pixels.shape, what)
    if wcs is not None:
        _check_place(wcs, cards, pixels.shape, what)
    if pixels.dtype.kind in "iu" and pixels.dtype.name not in _INTEGERS:
        known["integers"] = pixels.dtype
        pixels = _as_int32(pixels, what)
    return Image(frame, pixels, cards, **known)


def _as_int32(pixels: npt.NDArray[Any], what: str) -> npt.NDArray[np.int32]:
    limits = np.iinfo(np.int32)
    if pixels.size > 0 and (pixels.min() < limits.min or pixels.max() > limits.max):
        raise ValueError(f"{what} has pixels of {pixels.dtype.name} beyond those of int32; allowed: float64 or int32")
    return pixels.astype(np.int32)


def _check_shape(shape: tuple[int, ...], what: str) -> None:
    if len(shape) != 2:
        is_colour = len(shape) == 3 and not {shape[0], shape[-1]}.isdisjoint((3, 4))
        channel = ", for example one channel of a colour image" if is_colour else ""
        raise ValueError(
            f"{what} has the shape {shape}; allowed: a path, or an array of rows and columns (also of an HDU or NDData){channel}"
        )


def _header_text(header: object) -> str:
    """Returns a header without a `WCS` as text, one card per line."""
    if header is None or isinstance(header, str):
        return header or ""
    if isinstance(header, Mapping) or is_of("astropy.io.fits", "Header", header):
        return _text(_as_header(header))
    raise TypeError(f"header is {type(header).__name__}; allowed: a Header, a WCS, a dict, or a string of cards")


def _text(header: Any) -> str:
    text: str = header.tostring(sep="\n", endcard=False, padding=False)
    return text


def _is_wcs(value: object) -> bool:
    """Returns True for world coordinates of astropy, also those of a slice."""
    return any(is_of("astropy.wcs.wcsapi", name, value) for name in ("BaseHighLevelWCS", "BaseLowLevelWCS"))


def _wcs_of(given: Any) -> Any:
    """Returns world coordinates as a `WCS`; those of a slice of an `NDData` are the slice of a `WCS`."""
    low = getattr(given, "low_level_wcs", given)
    if is_of("astropy.wcs.wcsapi", "SlicedLowLevelWCS", low) and is_of("astropy.wcs", "WCS", getattr(low, "_wcs", None)):
        slices = getattr(low, "_slices_array", ())
        if all(isinstance(one, slice) for one in slices):
            low = getattr(low, "_wcs")[tuple(slices)]
    if given is None or is_of("astropy.wcs", "WCS", low):
        return low
    raise TypeError(f"wcs of the frame is {type(given).__name__}; allowed: an astropy.wcs.WCS")


def _check_place(wcs: Any, cards: str, shape: tuple[int, ...], what: str) -> None:
    """Compares the positions of pixels by the keywords of a `WCS` with its own.

    astropy reads PV keywords of SCAMP with few terms as others, and keywords may be lost when it writes them again.
    """
    right, top = shape[1] - 1.0, shape[0] - 1.0
    pixels = [(0.5 * right, 0.5 * top), (0.0, 0.0), (right, 0.0), (0.0, top), (right, top)]
    # The range of a distortion depends on the size.
    cards = f"NAXIS   = 2\nNAXIS1  = {shape[1]}\nNAXIS2  = {shape[0]}\n{cards}"
    read = _core.sky_of_pixels(cards, pixels) if hasattr(_core, "sky_of_pixels") else None
    if read is None or not wcs.has_celestial:
        # The library states the reason.
        return
    from astropy.coordinates import SkyCoord

    places, scale_arcsec = read
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            own = (wcs if wcs.naxis == 2 else wcs.celestial).pixel_to_world(*np.transpose(pixels)).icrs
        except ValueError:
            # A celestial frame that astropy does not know.
            return
        found = SkyCoord(places, unit="deg")
        apart_arcsec = found.separation(own).arcsec
    pixel, arcsec = _SAME_PLACE
    if not (apart_arcsec <= pixel * scale_arcsec + arcsec).all():
        # A pixel that has a position in only one of the readings comes first.
        at = int(np.argmax(np.nan_to_num(apart_arcsec, nan=np.inf)))
        column, row = pixels[at]
        raise ValueError(
            f"{what}: pixel ({column:g}, {row:g}) is at {_degrees(own[at])} deg by pixel_to_world of the WCS object, but at"
            f" {_degrees(found[at])} deg by its keywords (astropy reads some keywords otherwise, such as PV of SCAMP);"
            " allowed: a path, an HDU, or an array with header=... of the file"
        )


def _degrees(place: Any) -> str:
    return f"{place.ra.deg:.5f}, {place.dec.deg:.5f}"


def _with_coordinates(header: Header, wcs: Any) -> tuple[Header, tuple[str, ...]]:
    """Returns a header with the keywords of world coordinates, and remarks; other keywords of the header have precedence."""
    if any(getattr(wcs, name) is not None for name in ("cpdis1", "cpdis2", "det2im1", "det2im2")):
        raise ValueError("the world coordinates have lookup tables of distortion (CPDIS, D2IM); allowed: SIP or PV keywords")
    for keyword in [keyword for keyword in header if _COORDINATES.fullmatch(keyword)]:
        header.remove(keyword, ignore_missing=True, remove_all=True)
    cards = wcs.to_header(relax=True)
    remarks: tuple[str, ...] = ()
    for name, counts, others in (("start", _START, _OTHER_START), ("length", _LENGTH, _OTHER_LENGTH)):
        taken = [keyword for keyword in cards if counts.fullmatch(keyword) and keyword not in header]
        if taken and not any(others.fullmatch(keyword) for keyword in header):
            remarks += (
                f"the {name} of the exposure is that of {', '.join(taken)} in the WCS object: astropy does not keep the comments of"
                " the header, which may state another unit or time",
            )
            if name == "length" and min(abs(cards[keyword]) for keyword in taken) < _SHORTEST_S:
                shown = " and ".join(f"{keyword} is {cards[keyword]:g} s" for keyword in taken)
                raise ValueError(
                    f"{shown} in the WCS object, of which astropy does not keep the unit; allowed: {_SHORTEST_S:g} s or longer;"
                    " give the file, or EXPTIME in the metadata"
                )
    for card in cards.cards:
        # astropy adds an MJD, rounded to 10 ms, to each date.
        date = card.keyword.replace("MJD-", "DATE-")
        is_rounded = date != card.keyword and (date in cards or date in header)
        if card.keyword not in header and not is_rounded:
            header.append(card)
    return header, remarks


def _as_header(values: Any) -> Header:
    """Returns a copy of a header, or of a dictionary as a header."""
    from astropy.io.fits import Header

    if isinstance(values, Header):
        return values.copy()
    header = Header()
    with warnings.catch_warnings():
        # Long names become HIERARCH cards.
        warnings.simplefilter("ignore")
        for name, value in values.items():
            try:
                header[str(name)] = value
            except ValueError:
                # Not a value of a card, such as a table or an object.
                continue
    return header


def _header_of(data: Any, wcs: Any) -> tuple[Header, tuple[str, ...]]:
    """Returns the metadata, world coordinates and unit of an `NDData` as a header, and remarks about it."""
    header = _as_header(data.meta)
    remarks: tuple[str, ...] = ()
    if wcs is not None:
        header, remarks = _with_coordinates(header, wcs)
    if data.unit is not None:
        header["BUNIT"] = str(data.unit)
    return header, remarks


def _bad(mask: object, shape: tuple[int, ...]) -> npt.NDArray[np.uint8] | None:
    """Returns 1 for the masked pixels; `None` if none is masked."""
    if mask is None or mask is np.ma.nomask:
        return None
    return np.ascontiguousarray(np.broadcast_to(np.asarray(mask) != 0, shape)).view(np.uint8)


def _fill_value(array: "np.ma.MaskedArray[Any, Any]") -> Any:
    """Returns the fill value of a masked array; `None`, that of its type, if none was set."""
    return getattr(array, "_fill_value", None)


#: Functions from values of an uncertainty to variances, and back, by its type.
_TO_VARIANCE: dict[str, Any] = {"std": np.square, "var": np.positive, "ivar": np.reciprocal}
_FROM_VARIANCE: dict[str, Any] = {"std": np.sqrt, "var": np.positive, "ivar": np.reciprocal}
#: Power of the unit of the data that is the unit of the uncertainty.
_POWERS = {"std": 1, "var": 2, "ivar": -2}


def _variance(uncertainty: NDUncertainty | None, unit: Any, shape: tuple[int, ...]) -> Pixels | None:
    """Returns the variances that an uncertainty states, in the squared unit of the data; `None` if it is missing or of an
    unknown kind. Values without information (0 of an inverse variance) become infinite.
    """
    if uncertainty is None or uncertainty.array is None or uncertainty.uncertainty_type not in _TO_VARIANCE:
        return None
    array = np.broadcast_to(uncertainty.array, shape)
    variance: Pixels = array.astype(np.float32 if array.dtype.itemsize <= 4 else np.float64)
    variance *= _unit_factor(uncertainty, unit)
    with np.errstate(divide="ignore", over="ignore"):
        _TO_VARIANCE[uncertainty.uncertainty_type](variance, out=variance)
    return variance


def _unit_factor(uncertainty: NDUncertainty, unit: Any) -> Any:
    """Returns the factor from the unit of an uncertainty to that which belongs to the unit of the data."""
    if uncertainty.unit is None:
        return np.float32(1.0)
    power = _POWERS[uncertainty.uncertainty_type]
    if unit is None:
        raise ValueError(f"the uncertainty has the unit {uncertainty.unit}, the data have none; allowed: units of both")
    expected = unit**power
    try:
        return np.float32(uncertainty.unit.to(expected))
    except ValueError:
        raise ValueError(
            f"the uncertainty has the unit {uncertainty.unit}, the data {unit}; allowed: a unit that converts to {expected}"
        ) from None


def _new_uncertainty(uncertainty: NDUncertainty | None, errors: npt.NDArray[Any] | None = None) -> NDUncertainty | None:
    """Returns an uncertainty that belongs to no frame, with the given values or a copy of its own."""
    if uncertainty is None or uncertainty.array is None:
        return uncertainty
    values = np.array(uncertainty.array) if errors is None else errors
    return type(uncertainty)(values, unit=uncertainty.unit, copy=False)


def _new_nddata(given: Any, pixels: Pixels, uncertainty: NDUncertainty | None, mask: object) -> NDData:
    """Returns an `NDData` with the world coordinates, metadata and unit of the given one."""
    others = {name: getattr(given, name) for name in ("flags", "psf") if getattr(given, name, None) is not None}
    new: NDData = type(given)(
        pixels, uncertainty=uncertainty, mask=copy.copy(mask), wcs=given.wcs, meta=copy.deepcopy(given.meta), unit=given.unit, **others
    )
    return new


def _new_hdu(given: Any, pixels: Pixels, header: Any = None) -> Any:
    """Returns an HDU of the same class with other pixels and, if given, another header."""
    options = ("compression_type", "tile_shape", "quantize_level", "quantize_method", "dither_seed", "hcomp_scale", "hcomp_smooth")
    same = {name: getattr(given, name) for name in options if getattr(given, name, None) is not None}
    return type(given)(pixels, given.header.copy() if header is None else header, **same)
