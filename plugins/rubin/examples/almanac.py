"""Almanac, tiling and dark sky for a few nights by astropy (1 MB), instead of the 2 GB of data of rubin_scheduler."""

from __future__ import annotations

import os
from pathlib import Path

import healpy as hp
import numpy as np
from astropy import units as u
from astropy.coordinates import AltAz, EarthLocation, SkyCoord, get_body
from astropy.time import Time
from astropy.utils import iers
from rubin_scheduler.utils import Site

iers.conf.auto_download = False

#: Number of days before and after the night.
SPAN_DAYS = 6.0
#: Step of the tables, days; rubin_scheduler interpolates with parabolas.
STEP_DAYS = 15.0 / 1440.0
DARK_SKY_MAG_ARCSEC2 = {"u": 22.9, "g": 22.3, "r": 21.2, "i": 20.5, "z": 19.6, "y": 18.6}
PLANETS = ("venus", "mars", "jupiter", "saturn")


def location() -> EarthLocation:
    """Returns the site of rubin_scheduler."""
    site = Site("LSST")
    return EarthLocation.from_geodetic(lon=site.longitude, lat=site.latitude, height=site.height)


def noon_of(evening: str) -> float:
    """Returns the MJD (UTC) of 16h UTC of a date, which is about noon at Rubin before the night of this date."""
    return float(Time(f"{evening}T16:00:00", scale="utc").mjd)


def _angles(body: SkyCoord) -> tuple[np.ndarray, np.ndarray]:
    icrs = body.icrs if body.frame.name != "gcrs" else SkyCoord(body.ra, body.dec)
    return icrs.ra.rad, icrs.dec.rad


def _crossings(mjd: np.ndarray, altitude_deg: np.ndarray, level_deg: float, rising: bool) -> np.ndarray:
    """Returns the times at which an altitude crosses a value, by linear interpolation."""
    above = altitude_deg - level_deg
    at = np.flatnonzero((above[:-1] < 0) & (above[1:] >= 0) if rising else (above[:-1] >= 0) & (above[1:] < 0))
    return mjd[at] + STEP_DAYS * above[at] / (above[at] - above[at + 1])


def make(evening: str, folder: Path) -> Path:
    """Writes the files for one evening, and configures rubin_scheduler to use their folder."""
    models, sky = folder / "site_models", folder / "skybrightness_pre"
    models.mkdir(parents=True, exist_ok=True)
    sky.mkdir(exist_ok=True)
    noon = noon_of(evening)
    mjd = np.arange(noon - SPAN_DAYS, noon + SPAN_DAYS, STEP_DAYS)
    times = Time(mjd, format="mjd", scale="utc")
    site_location = location()
    horizontal = AltAz(obstime=times, location=site_location)

    bodies = {name: get_body(name, times, site_location, ephemeris="builtin") for name in ("sun", "moon", *PLANETS)}
    columns: dict[str, np.ndarray] = {"mjd": mjd}
    for name in ("sun", "moon"):
        horizontal_position = bodies[name].transform_to(horizontal)
        right_ascension, declination = _angles(bodies[name])
        columns |= {
            f"{name}_alt": horizontal_position.alt.rad,
            f"{name}_az": horizontal_position.az.rad,
            f"{name}_RA": right_ascension,
            f"{name}_dec": declination,
        }
    elongation = bodies["sun"].separation(bodies["moon"], origin_mismatch="ignore").rad
    columns["moon_phase"] = 50.0 * (1.0 - np.cos(elongation))
    _save(models / "sun_moon.npz", "sun_moon_info", columns)

    planets: dict[str, np.ndarray] = {"mjd": mjd}
    for name in PLANETS:
        planets[f"{name}_RA"], planets[f"{name}_dec"] = _angles(bodies[name])
    _save(models / "planet_locations.npz", "planet_loc", planets)

    sun, moon = np.degrees(columns["sun_alt"]), np.degrees(columns["moon_alt"])
    sunsets = _crossings(mjd, sun, -0.83, rising=False)[:-1]
    after = {
        "sunset": sunsets,
        "sun_n12_setting": _next(sunsets, _crossings(mjd, sun, -12.0, rising=False)),
        "sun_n18_setting": _next(sunsets, _crossings(mjd, sun, -18.0, rising=False)),
        "sun_n18_rising": _next(sunsets, _crossings(mjd, sun, -18.0, rising=True)),
        "sun_n12_rising": _next(sunsets, _crossings(mjd, sun, -12.0, rising=True)),
        "sunrise": _next(sunsets, _crossings(mjd, sun, -0.83, rising=True)),
        "moonrise": _next(sunsets, _crossings(mjd, moon, 0.125, rising=True)),
        "moonset": _next(sunsets, _crossings(mjd, moon, 0.125, rising=False)),
    }
    _save(models / "sunsets.npz", "almanac", {"night": np.arange(sunsets.size), **after})

    # 5,292 points that cover the sphere (HEALPix cells of nside 21). The tiling of rubin_scheduler has the same number.
    points = np.column_stack(hp.pix2vec(21, np.arange(hp.nside2npix(21))))
    np.savetxt(models / "icover.3.5292.23.0.txt", points.ravel())
    dark = {band: np.full(hp.nside2npix(32), mag) for band, mag in DARK_SKY_MAG_ARCSEC2.items()}
    np.savez(sky / "dark_maps.npz", dark_maps=_structured(dark))
    (folder / "versions.txt").write_text("site_models,made_by_almanac.py\n")
    return use(folder)


def use(folder: Path) -> Path:
    """Sets the folder of rubin_scheduler by RUBIN_SIM_DATA_DIR."""
    os.environ["RUBIN_SIM_DATA_DIR"] = str(folder)
    return folder


def _next(starts: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Returns the first time after each start, or the last time if there is none."""
    return times[np.minimum(np.searchsorted(times, starts), times.size - 1)]


def _structured(columns: dict[str, np.ndarray]) -> np.ndarray:
    size = len(next(iter(columns.values())))
    table = np.zeros(size, dtype=[(name, int if name == "night" else float) for name in columns])
    for name, values in columns.items():
        table[name] = values
    return table


def _save(path: Path, name: str, columns: dict[str, np.ndarray]) -> None:
    np.savez(path, **{name: _structured(columns)})


class ConstantSky:
    """Sky of constant brightness, instead of the tables of rubin_scheduler."""

    nside = 32

    def __init__(self) -> None:
        self._maps = {band: np.full(hp.nside2npix(self.nside), mag) for band, mag in DARK_SKY_MAG_ARCSEC2.items()}

    def return_mags(self, mjd: float, indx: object = None, bands: object = None, **_: object) -> dict[str, np.ndarray]:
        """Returns magnitudes per square arcsecond, for whole maps or for given cells."""
        if indx is None:
            return self._maps
        return {band: one[np.ravel(indx)] for band, one in self._maps.items()}
