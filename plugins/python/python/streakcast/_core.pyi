from pathlib import Path
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

_Reals = npt.NDArray[np.float64]
_Times = tuple[_Reals, _Reals, npt.NDArray[np.int64]]
_Columns = list[dict[str, Any]]

__version__: str

class StreakcastError(ValueError): ...
class SetupError(StreakcastError): ...

def times_from_text(texts: list[str], scale: Optional[str] = None) -> tuple[_Reals, _Reals]: ...
def times_from_mjd(mjd: _Reals, scale: str) -> tuple[_Reals, _Reals]: ...
def setup_files(setup: str, config: Optional[str] = None) -> list[Path]: ...
def utc_mjd(jd1: _Reals, jd2: _Reals) -> list[float]: ...
def draw(chart: str, labels: dict[str, Any], columns: dict[str, Any]) -> Picture: ...

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
    sky_cache: SkyCache,
) -> dict[str, Any]: ...
def learn(
    setup: str,
    kind: str,
    norad_id: list[int],
    jd1: _Reals,
    jd2: _Reals,
    residual_mag: _Reals,
    sigma_mag: _Reals,
) -> str: ...
def model_names(setup: str) -> list[str]: ...
def body_map(
    setup: str,
    model: str,
    sun_latitude_deg: float,
    height_km: float,
    step_deg: Optional[float] = None,
    nside: Optional[int] = None,
) -> tuple[_Columns, str]: ...
def sky_map(
    setup: str,
    model: str,
    sun_altitude_deg: float,
    sun_azimuth_deg: float,
    height_km: float,
    step_deg: Optional[float] = None,
    nside: Optional[int] = None,
) -> tuple[_Columns, str]: ...
def standard_magnitudes(
    setup: str,
    model: str,
    sun_latitude_deg: _Reals,
    observer_longitude_deg: _Reals,
    observer_latitude_deg: _Reals,
    height_km: _Reals,
) -> _Reals: ...
def sky_magnitudes(
    setup: str,
    model: str,
    azimuth_deg: _Reals,
    altitude_deg: _Reals,
    sun_altitude_deg: float,
    sun_azimuth_deg: float,
    height_km: float,
) -> tuple[_Reals, _Reals]: ...

def utc_text(jd1: float, jd2: float) -> str: ...
def inject(
    request: str,
    setup: str,
    config: Optional[str],
    sky_cache: Optional[SkyCache],
    output: str,
    image: Optional[npt.NDArray[Any]] = None,
    header: Optional[str] = None,
) -> dict[str, Any]: ...

def forecast(requests: list[str], setup: str, config: Optional[str], sky_cache: SkyCache) -> dict[str, Any]: ...
def ephemeris(
    request: str, setup: str, config: Optional[str], sky_cache: SkyCache
) -> tuple[_Columns, list[str]]: ...
def identify(
    request: str, setup: str, config: Optional[str], sky_cache: SkyCache, include_dark: bool, top: int
) -> dict[str, Any]: ...

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
    @property
    def blocking(self) -> str: ...
    def judge(self, exposures: dict[str, _Reals], bands: list[str]) -> tuple[dict[str, Any], list[str]]: ...
    def flags(self, exposures: dict[str, _Reals], bands: list[str]) -> tuple[_Columns, list[str]]: ...
    def passes(
        self, exposures: dict[str, _Reals], include_dark: bool, samples: int, limits_mag: Optional[list[float]] = None
    ) -> tuple[_Columns, list[str]]: ...
    def clear_windows(
        self,
        exposures: dict[str, _Reals],
        bands: list[str],
        exposure_s: float,
        min_altitude_deg: float,
        blocking: str | None = None,
        max_sun_altitude_deg: Optional[float] = None,
    ) -> tuple[dict[str, Any], list[str]]: ...
    def overhead(
        self,
        jd1: float,
        jd2: float,
        seconds: list[float],
        min_altitude_deg: float,
        include_dark: bool,
        light: bool,
        limits_mag: list[float] = ...,
    ) -> tuple[dict[str, Any], list[str]]: ...
