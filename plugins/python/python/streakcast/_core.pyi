from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal, Optional, TypedDict, Union, overload

import numpy as np
import numpy.typing as npt

from .typing import FloatArray, Pixels, Samples

_Bools = npt.NDArray[np.bool_]
_Integers = npt.NDArray[np.int64]
_Times = tuple[FloatArray, FloatArray, _Integers]

class _Described(TypedDict):
    name: str
    unit: str
    description: str

class RealColumn(_Described):
    kind: Literal["real"]
    values: FloatArray

class IntegerColumn(_Described):
    kind: Literal["integer"]
    values: _Integers
    missing: _Bools

class BooleanColumn(_Described):
    kind: Literal["boolean"]
    values: _Bools
    missing: _Bools

class TimeColumn(_Described):
    kind: Literal["time"]
    jd1: FloatArray
    jd2: FloatArray
    utc_ns: _Integers

class TextColumn(_Described):
    kind: Literal["text"]
    values: list[str]

class ListColumn(_Described):
    kind: Literal["list"]
    values: list[Union[list[str], list[int], Samples]]

Column = Union[RealColumn, IntegerColumn, BooleanColumn, TimeColumn, TextColumn, ListColumn]

class Judged(TypedDict):
    verdict: npt.NDArray[np.uint8]
    n_streaks: _Integers
    brightest_mag: FloatArray
    lost_fraction: FloatArray
    p_any: FloatArray
    streak_length_deg: FloatArray
    p_any_is_lower_limit: _Bools
    p_crossing: FloatArray
    elements_age_days: FloatArray
    late_s: FloatArray
    streak_cost_s: FloatArray

class Windows(TypedDict):
    target: _Integers
    first_start: _Times
    last_start: _Times

class OverheadRows(TypedDict):
    moment: _Integers
    norad_id: _Integers
    direction: FloatArray
    probability: FloatArray
    range_km: FloatArray
    angular_rate_deg_s: FloatArray
    lost_width_arcsec: FloatArray
    magnitude: FloatArray
    p_brighter: FloatArray
    q_bright: FloatArray

class Forecasted(TypedDict):
    passes: list[Column]
    nights: list[Column]
    warnings: list[str]

class Identified(TypedDict):
    candidates: list[Column]
    streak: list[Column]
    n_candidates: int
    unknown_probability: float
    warnings: list[str]
    remarks: list[str]

class IdentifiedStreaks(TypedDict):
    candidates: list[Column]
    streak: list[Column]
    warnings: list[str]
    row_warnings: list[str]
    remarks: list[str]

class Measured(TypedDict):
    measurements: list[Column]
    warnings: list[str]
    remarks: list[str]

class Masked(TypedDict):
    masks: dict[int, npt.NDArray[np.bool_]]
    streaks: list[Column]
    left_out: list[Column]
    summary: str
    remarks: list[str]
    warnings: list[str]

class InjectionResult(TypedDict):
    summary: str
    truth: list[Column]
    points: list[Column]
    labels: list[tuple[str, str]]
    trails: list[Column]
    bits: tuple[int, int]
    remarks: list[str]
    warnings: list[str]

__version__: str

class StreakcastError(ValueError): ...
class SetupError(StreakcastError): ...
class UnknownPositionsError(StreakcastError): ...

def times_from_text(texts: list[str], scale: Optional[str] = None) -> tuple[FloatArray, FloatArray]: ...
def times_from_mjd(mjd: FloatArray, scale: str) -> tuple[FloatArray, FloatArray]: ...
def replaced_keys(changed: list[str]) -> list[str]: ...
def setup_files(setup: str, config: Optional[str] = None) -> list[Path]: ...
def utc_mjd(jd1: FloatArray, jd2: FloatArray) -> list[float]: ...
def draw(chart: str, labels: Mapping[str, object], columns: Mapping[str, object]) -> Picture: ...

class Picture:
    @property
    def size(self) -> tuple[int, int]: ...
    def png(self) -> bytes: ...
    def svg(self) -> str: ...
    def save(self, path: str) -> None: ...

def measure(
    request: str,
    setup: str,
    config: Optional[str],
    sky_cache: Optional[SkyCache],
) -> Measured: ...
def mask(
    request: str,
    setup: str,
    config: Optional[str],
    sky_cache: SkyCache,
) -> Masked: ...
def learn(
    setup: str,
    kind: str,
    norad_id: list[int],
    jd1: FloatArray,
    jd2: FloatArray,
    residual_mag: FloatArray,
    sigma_mag: FloatArray,
) -> str: ...
def model_names(setup: str) -> list[str]: ...
def body_map(
    setup: str,
    model: str,
    sun_latitude_deg: float,
    height_km: float,
    step_deg: Optional[float] = None,
    nside: Optional[int] = None,
) -> tuple[list[Column], str]: ...
def sky_map(
    setup: str,
    model: str,
    sun_altitude_deg: float,
    sun_azimuth_deg: float,
    height_km: float,
    step_deg: Optional[float] = None,
    nside: Optional[int] = None,
) -> tuple[list[Column], str]: ...
def standard_magnitudes(
    setup: str,
    model: str,
    sun_latitude_deg: FloatArray,
    observer_longitude_deg: FloatArray,
    observer_latitude_deg: FloatArray,
    height_km: FloatArray,
) -> FloatArray: ...
def sky_magnitudes(
    setup: str,
    model: str,
    azimuth_deg: FloatArray,
    altitude_deg: FloatArray,
    sun_altitude_deg: float,
    sun_azimuth_deg: float,
    height_km: float,
) -> tuple[FloatArray, FloatArray]: ...
def utc_text(jd1: float, jd2: float) -> str: ...
def out_of_range(exposures: Mapping[str, FloatArray]) -> list[tuple[int, str]]: ...
def inject(
    request: str,
    setup: str,
    config: Optional[str],
    sky_cache: Optional[SkyCache],
    output: str,
) -> InjectionResult: ...
def write_frame(path: str, images: list[tuple[str, Pixels, str]]) -> None: ...
@overload
def read_rows(path: str, hdu: int, dtype: Literal["int32"], first_row: int, end_row: int) -> Optional[npt.NDArray[np.int32]]: ...
@overload
def read_rows(path: str, hdu: int, dtype: str, first_row: int, end_row: int) -> Optional[Pixels]: ...
def sky_of_pixels(cards: str, pixels: Sequence[tuple[float, float]]) -> Optional[tuple[list[list[float]], float]]: ...
def forecast(requests: list[str], engine: Engine) -> Forecasted: ...
def ephemeris(request: str, engine: Engine) -> tuple[list[Column], list[str]]: ...
def identify(request: str, engine: Engine, include_dark: Optional[bool], top: int) -> Identified: ...
def identify_streaks(
    request: str,
    tables: list[str],
    folder: Optional[str],
    engine: Engine,
    include_dark: Optional[bool],
    top: int,
) -> IdentifiedStreaks: ...

class SkyCache:
    def __new__(
        cls, setup: str, config: Optional[str] = None, epoch: Optional[tuple[float, float]] = None
    ) -> SkyCache: ...
    @property
    def site(self) -> Optional[tuple[str, float, float, float]]: ...
    def night(self, jd1: float, jd2: float) -> int: ...
    def provenance(self, jd1: float, jd2: float) -> str: ...
    def news(self) -> list[str]: ...
    def element_files(self) -> list[tuple[str, str]]: ...
    def satellites(self, jd1: float, jd2: float) -> int: ...

class Engine:
    def __new__(cls, sky_cache: SkyCache, setup: str, config: Optional[str] = None) -> Engine: ...
    @property
    def time_scale(self) -> Optional[str]: ...
    @property
    def field_radius_deg(self) -> Optional[float]: ...
    @property
    def field_area_deg2(self) -> Optional[float]: ...
    def cost_parameters(self, band: Optional[str] = None) -> Optional[tuple[float, float, Optional[float]]]: ...
    @property
    def blocking(self) -> str: ...
    @property
    def default_rotation_deg(self) -> float: ...
    def judge(
        self, exposures: Mapping[str, FloatArray], bands: Sequence[str], keep_invalid: bool = False
    ) -> tuple[Judged, list[str]]: ...
    def flags(
        self,
        exposures: Mapping[str, FloatArray],
        bands: Sequence[str],
        seeks_starts: bool = False,
        keep_invalid: bool = False,
    ) -> tuple[list[Column], list[str]]: ...
    def annotate(
        self, schedule: str, output: str, scale: Optional[str] = None, replace: bool = False
    ) -> tuple[list[Path], list[str]]: ...
    def passes(
        self,
        exposures: Mapping[str, FloatArray],
        include_dark: Optional[bool],
        samples: Optional[int],
        bands: Sequence[str],
        limits_mag: Optional[list[float]] = None,
    ) -> tuple[list[Column], list[str]]: ...
    def clear_windows(
        self,
        exposures: Mapping[str, FloatArray],
        bands: Sequence[str],
        exposure_s: float,
        min_altitude_deg: float,
        blocking: Optional[str] = None,
        max_sun_altitude_deg: Optional[float] = None,
    ) -> tuple[Windows, list[str]]: ...
    def overhead(
        self,
        jd1: float,
        jd2: float,
        seconds: list[float],
        min_altitude_deg: float,
        include_dark: Optional[bool],
        light: bool,
        possible: bool,
        limits_mag: list[float] = ...,
        band: Optional[str] = None,
    ) -> tuple[OverheadRows, list[str]]: ...
