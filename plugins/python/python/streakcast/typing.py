"""Types of the arguments and results of this package, for annotations in programs that use it.

Names in quotation marks are classes of astropy, which is optional: `~astropy.time.Time`, `~astropy.units.Quantity`,
`~astropy.coordinates.SkyCoord`, `~astropy.coordinates.EarthLocation`, `~astropy.table.QTable`,
`~astropy.io.fits.Header`, `~astropy.io.fits.HDUList`, HDUs of images, `~astropy.nddata.NDData` and `~astropy.wcs.WCS`.
"""

from __future__ import annotations

import datetime
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, SupportsFloat, TypedDict, Union

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from astropy.coordinates import EarthLocation, SkyCoord
    from astropy.io.fits import CompImageHDU, HDUList, Header, ImageHDU, PrimaryHDU
    from astropy.nddata import NDData
    from astropy.table import QTable
    from astropy.table import Table as AstropyTable
    from astropy.time import Time
    from astropy.units import Quantity
    from astropy.wcs import WCS

__all__ = [
    "BoolOrArray",
    "Columns",
    "EndsLike",
    "FieldOptions",
    "FloatArray",
    "FloatArrayLike",
    "FloatLike",
    "FloatOrArray",
    "FrameLike",
    "HeaderLike",
    "InjectionOptions",
    "Json",
    "Learned",
    "LearnedKind",
    "LearnedMagnitude",
    "LearnedSatellite",
    "LightOptions",
    "LimitLike",
    "MeasureOptions",
    "ModelLike",
    "ModelOptions",
    "NightLike",
    "Options",
    "Output",
    "PathLike",
    "Pixels",
    "PlaceLike",
    "Sample",
    "Samples",
    "SiteLike",
    "SkyLightOptions",
    "StreaksLike",
    "Table",
    "TableLike",
    "TargetLike",
    "TextLike",
    "TextOrArray",
    "TimeLike",
    "TimeResult",
    "WholeArray",
    "WholeLike",
    "WholeOrArray",
]

# Arguments -----------------------------------------------------------------------------------------------------------

#: One number, or a `Quantity` of a convertible unit.
FloatLike = Union[SupportsFloat, "Quantity"]
#: A number, an array of any shape, or a `Quantity` (or several) of a convertible unit.
FloatArrayLike = Union[npt.ArrayLike, "Quantity", Sequence["Quantity"]]
#: An `astropy.time.Time`, an ISO 8601 string, an aware `datetime`, or, with a given scale, numbers (MJD) and
#: `numpy.datetime64`; one or an array.
TimeLike = Union["Time", datetime.datetime, Sequence[datetime.datetime], Sequence["Time"], npt.ArrayLike]
#: Local date of an evening, for example ``"2026-08-14"``; one or several.
NightLike = Union[str, datetime.date, Sequence[Union[str, datetime.date]]]
#: Position: a `SkyCoord` in any frame, or a pair (ra, dec), ICRS, degrees or `Quantity`.
TargetLike = Union["SkyCoord", tuple[FloatArrayLike, FloatArrayLike]]
#: Both ends of a streak: a `SkyCoord` of two, two positions, or an array ``(2, 2)`` of degrees.
EndsLike = Union["SkyCoord", tuple[TargetLike, TargetLike], npt.ArrayLike, "Quantity"]
#: Path of a file.
PathLike = Union[str, "os.PathLike[str]"]
#: One text or several.
TextLike = Union[str, Sequence[str], npt.NDArray[np.str_]]
#: One whole number or several.
WholeLike = Union[int, Sequence[int], npt.NDArray[np.integer]]
#: Table of a configuration file as a dictionary. A `Quantity` is accepted for keys that end with a unit.
Options = Mapping[str, object]
#: Site: a name in the bundled table, a location, or ``latitude_deg``, ``longitude_deg`` and ``height_m``.
SiteLike = Union[str, "EarthLocation", Options]
#: Site of a host: a location, or latitude, longitude (degrees, east positive) and height (metres).
PlaceLike = Union["EarthLocation", Sequence[FloatLike]]
#: Magnitude limit: one for all bands, or one for each, with ``"default"`` for the others.
LimitLike = Union[FloatLike, Mapping[str, FloatLike]]
#: Brightness model by name or as a JSON file, for all satellites or by generation.
ModelLike = Union[PathLike, Mapping[str, PathLike]]
#: World coordinates and other keywords of a frame; a string has one card per line, or cards of 80 characters.
HeaderLike = Union["Header", "WCS", Mapping[str, object], str]
#: Form of tables: `QTable`, dictionaries of arrays, or the former if astropy is installed.
Output = Literal["auto", "qtable", "dict"]

# Arguments and results -----------------------------------------------------------------------------------------------

#: Array of numbers in double precision.
FloatArray = npt.NDArray[np.float64]
#: Array of whole numbers.
WholeArray = npt.NDArray[np.int64]
#: Number for one exposure, array for several.
FloatOrArray = Union[float, FloatArray]
#: Whole number for one exposure, array for several.
WholeOrArray = Union[int, WholeArray]
#: Truth value for one exposure, array for several.
BoolOrArray = Union[bool, npt.NDArray[np.bool_]]
#: Text for one exposure, array for several.
TextOrArray = Union[str, npt.NDArray[np.str_]]
#: Image, rows and columns.
Pixels = npt.NDArray[Union[np.float32, np.float64, np.uint8, np.int16, np.uint16, np.int32]]
#: Frame: path of a FITS file, its HDUs, one HDU, an `NDData` (for example `CCDData`), or an array, also masked or with a
#: unit.
FrameLike = Union[PathLike, Pixels, "HDUList", "PrimaryHDU", "ImageHDU", "CompImageHDU", "NDData"]
#: Point along a track: values by name; `None` if a value is missing.
Sample = Mapping[str, Union[str, float, None]]
#: Points along a track.
Samples = Sequence[Sample]
#: Table of streaks: a path, an astropy table, a dictionary of columns, or a list with a dictionary for each streak.
StreaksLike = Union[
    PathLike,
    "AstropyTable",
    Mapping[str, Union[Sequence[Union[str, float, None]], npt.NDArray[Any], "Quantity"]],
    Sequence[Sample],
]
# The data types of the columns differ, so that they cannot be stated for all together.
#: Columns by name, each an array with one cell per row.
Columns = dict[str, npt.NDArray[Any]]
#: `QTable` if astropy is installed and ``output`` is not ``"dict"``, otherwise a dictionary of arrays.
Table = Union["QTable", Columns]
#: Table in the form of a result, with all or some of its rows.
TableLike = Union["QTable", Mapping[str, npt.NDArray[Any]]]
#: Times: `Time` if astropy is installed and ``output`` is not ``"dict"``, otherwise ``datetime64[ns]``, UTC.
TimeResult = Union["Time", npt.NDArray[np.datetime64]]
#: Value of a JSON document.
Json = Union[None, bool, int, float, str, "list[Json]", "dict[str, Json]"]

# Learned files -------------------------------------------------------------------------------------------------------


class _LearnedFrom(TypedDict):
    #: Number of passes.
    passes: int
    #: Number of measurements.
    measurements: int
    #: Time of the first measurement, UTC.
    first_utc: str
    #: Time of the last measurement, UTC.
    last_utc: str
    #: Offset from the model (of a kind: mean of its satellites), mag; positive is fainter than the model.
    offset_mag: float
    #: One sigma of the offset, mag.
    offset_sigma_mag: float
    #: One sigma of a measurement in another pass (of a kind: of a satellite without an entry), mag.
    sigma_mag: float


class LearnedMagnitude(_LearnedFrom):
    """Learned magnitudes of one kind of satellite."""

    #: Source of the magnitudes of the model.
    model: str
    #: Number of satellites.
    satellites: int
    #: Standard deviation of the offsets of the satellites, mag.
    satellite_sigma_mag: float
    #: Scale of the differences between passes of a satellite, mag.
    pass_scale_mag: float
    #: One sigma of the measurements within a pass, mag.
    point_sigma_mag: float


class LearnedKind(TypedDict):
    """Entry of a kind of satellite in a learned file."""

    #: Kind of satellite.
    kind: str
    #: Magnitudes.
    magnitude: LearnedMagnitude
    #: Error along the track: missing, because `streakcast.learn` has no delays.
    lateness: None


class LearnedSatellite(_LearnedFrom):
    """Entry of a satellite in a learned file."""

    #: NORAD catalogue number.
    norad_id: int
    #: Kind of satellite.
    kind: str


class Learned(TypedDict):
    """Content of a learned file, as returned by `streakcast.learn`."""

    #: Version of the schema.
    schema: int
    #: Name and version of the program.
    program: str
    #: Kind and number of measurements.
    provenance: dict[str, Json]
    #: Time of the first measurement, UTC.
    first_utc: str
    #: Time of the last measurement, UTC.
    last_utc: str
    #: Kinds of satellites.
    kinds: list[LearnedKind]
    #: Satellites.
    satellites: list[LearnedSatellite]


# Keyword arguments ---------------------------------------------------------------------------------------------------


class _MagnitudeOptions(TypedDict, total=False):
    band: str | None
    mag_system: str | None
    earthshine: bool | None


class LightOptions(_MagnitudeOptions, total=False):
    """Further arguments of `streakcast.body_map` and `streakcast.standard_magnitudes`."""

    models: Options | None


class SkyLightOptions(LightOptions, total=False):
    """Further arguments of `streakcast.sky_map` and `streakcast.sky_magnitudes`."""

    extinction: FloatLike | None
    shadow: str | None
    site: SiteLike | None
    mpc: str | None
    lat: FloatLike | None
    lon: FloatLike | None
    height_m: FloatLike | None


class _ExposureOptions(_MagnitudeOptions, total=False):
    extinction: FloatLike | None
    sun_distance: bool | None
    min_probability: float | None
    bright_share: float | None
    max_delay: str | Quantity | None


class FieldOptions(_ExposureOptions, total=False):
    """Arguments of `streakcast.StreakModel.with_options`."""

    fov: str | Quantity | None
    field: PathLike | Options | None
    telescope: PathLike | Options | None
    limit_mag: LimitLike | None
    limit_surface_brightness: LimitLike | None
    policy: PathLike | Options | None
    blocking: str | None
    mjd_scale: str | None


class MeasureOptions(TypedDict, total=False):
    """Further arguments of `streakcast.measure_streaks`, which are those of `streakcast.StreakModel.measure`."""

    header: HeaderLike | None
    start: TimeLike | None
    exposure: FloatLike | None
    scale: str | None
    hdu: WholeLike | None
    seeing: str | Quantity | None
    fit_width: bool
    psf: str
    satellite_size: FloatLike | None
    stars: PathLike | None
    star_colours: Sequence[FloatLike] | None
    zero_point: FloatLike | None
    zero_point_1s: FloatLike | None
    gain: FloatLike | None
    saturation: FloatLike | None
    band: str | None
    telescope: PathLike | Options | None
    table: Output


class ModelOptions(_ExposureOptions, total=False):
    """Further arguments of `streakcast.StreakModel`."""

    mpc: str | None
    limit_surface_brightness: LimitLike | None
    lat: FloatLike | None
    lon: FloatLike | None
    height: FloatLike | None
    blocking: str | None
    drag: str | None
    shadow: str | None
    eop: PathLike | None
    learned: PathLike | None
    measured: PathLike | Sequence[PathLike] | None
    qs_mag: PathLike | None
    accept_bad_checksums: bool | None
    observer_elements: PathLike | None
    observer_norad: int | None
    limb_height_km: FloatLike | None
    max_zenith_angle: FloatLike | None
    min_sun_angle: FloatLike | None
    min_limb_angle: FloatLike | None


class InjectionOptions(TypedDict, total=False):
    """Further arguments of `streakcast.StreakModel.inject`, the same as those of `streakcast.inject`."""

    scale: str | None
    random_streaks: int | None
    streak_density: FloatLike | None
    magnitude: FloatArrayLike | None
    streak_rate_deg_s: FloatArrayLike | None
    streaks: StreaksLike | None
    satellite_size: FloatLike | None
    telescope: PathLike | Options | None
    band: str | None
    seeing: str | Quantity | None
    psf: str
    psf_oversampling: int | None
    zero_point: FloatLike | None
    zero_point_1s: FloatLike | None
    gain: FloatLike | None
    detector: PathLike | None
    noise: bool
    seed: int
    hdu: WholeLike | None
    pixel_scale: str | Quantity | None
    track_rate: FloatArrayLike | Sequence[FloatLike] | None
    tumbling: FloatArrayLike | Sequence[FloatLike] | None
    glints: Sequence[FloatArrayLike | Sequence[FloatLike]]
    light_curve: PathLike | None
    resolve_panels: bool
    truth_points: int
    mask_bits: str
    labels: str | Sequence[str]
    pixels_only: bool
    table: Output
