"""Magnitudes and maps of brightness models, without satellites or element sets."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from . import _core
from ._quantities import aligned, count, finite_scalar, number, scalar
from ._setup import document
from ._tables import table_of
from .typing import FloatArrayLike, FloatLike, FloatOrArray, LightOptions, Options, Output, SkyLightOptions, Table

if TYPE_CHECKING:
    from typing_extensions import Unpack


def model_names(models: Options | None = None) -> list[str]:
    """Returns the names of the brightness models.

    Parameters
    ----------
    models : dict, optional
        ``{"files": [...]}``: model files in addition to the bundled ones.

    Returns
    -------
    list of str
    """
    return _core.model_names(json.dumps(document({"models": models})))


def standard_magnitudes(
    model: str,
    sun_latitude: FloatArrayLike,
    observer_longitude: FloatArrayLike,
    observer_latitude: FloatArrayLike,
    height: FloatArrayLike = 550.0,
    **light: Unpack[LightOptions],
) -> FloatOrArray:
    """Returns magnitudes at 1000 km for directions in the body frame of a satellite, in full sunlight, Sun at 1 au.

    Parameters
    ----------
    model : str
        A name of `model_names`, or a path that ends in ``.json``.
    sun_latitude : float, array or `~astropy.units.Quantity`
        Latitude of the Sun above the plane of the chassis, degrees.
    observer_longitude, observer_latitude : float, array or `~astropy.units.Quantity`
        Longitude of the observer from the Sun's azimuth, and latitude above the plane of the chassis, degrees.
    height : float, array or `~astropy.units.Quantity`
        Height of the satellite above 6378.137 km, km; used only for earthshine.
    **light
        ``band, mag_system, earthshine, models``.

    Returns
    -------
    float or array
        In the broadcast shape; NaN where no lit surface is visible.
    """
    parts = np.broadcast_arrays(
        number(sun_latitude, "deg", "sun_latitude"),
        number(observer_longitude, "deg", "observer_longitude"),
        number(observer_latitude, "deg", "observer_latitude"),
        number(height, "km", "height"),
    )
    columns = [aligned(part.reshape(-1)) for part in parts]
    magnitudes = _core.standard_magnitudes(_setup("standard_magnitudes", light, LightOptions), str(model), *columns)
    return float(magnitudes[0]) if parts[0].shape == () else magnitudes.reshape(parts[0].shape)


def sky_magnitudes(
    model: str,
    azimuth: FloatArrayLike,
    altitude: FloatArrayLike,
    *,
    sun_altitude: FloatLike,
    sun_azimuth: FloatLike = 0.0,
    height: FloatLike = 550.0,
    **light: Unpack[SkyLightOptions],
) -> tuple[FloatOrArray, FloatOrArray]:
    """Returns apparent magnitudes of satellites at one height in directions above a site.

    Parameters
    ----------
    model : str
        Name from `model_names`, or a path that ends in ``.json``.
    azimuth, altitude : float, array or `~astropy.units.Quantity`
        Directions of the satellites: azimuth from north through east, altitude without refraction, degrees.
    sun_altitude, sun_azimuth : float or `~astropy.units.Quantity`
        Geometric position of the Sun, degrees; negative altitudes are below the horizon.
    height : float or `~astropy.units.Quantity`
        Height of the satellites above 6378.137 km, km. That of the site is ``height_m``.
    **light
        ``band, mag_system, earthshine, extinction, models, shadow``, and the site as ``site, mpc, lat, lon, height_m``.
        Without a site the Earth is a sphere.

    Returns
    -------
    magnitude : float or array
        NaN in the Earth's shadow, and where no lit surface is visible.
    range_km : float or array
        Range from observer to satellite.
    """
    parts = np.broadcast_arrays(number(azimuth, "deg", "azimuth"), number(altitude, "deg", "altitude"))
    columns = [aligned(part.reshape(-1)) for part in parts]
    magnitude, range_km = _core.sky_magnitudes(
        _setup("sky_magnitudes", light, SkyLightOptions),
        str(model),
        columns[0],
        columns[1],
        scalar(sun_altitude, "deg", "sun_altitude"),
        scalar(sun_azimuth, "deg", "sun_azimuth"),
        scalar(height, "km", "height"),
    )
    if parts[0].shape == ():
        return float(magnitude[0]), float(range_km[0])
    return magnitude.reshape(parts[0].shape), range_km.reshape(parts[0].shape)


def body_map(
    model: str,
    *,
    sun_latitude: FloatLike,
    height: FloatLike = 550.0,
    step: FloatLike | None = None,
    nside: int | None = None,
    output: Output = "auto",
    **light: Unpack[LightOptions],
) -> Table:
    """Returns magnitudes at 1000 km over the body frame of a satellite, as printed by ``streakcast map body``.

    Parameters
    ----------
    model : str
        Name from `model_names`, or a path that ends in ``.json``.
    sun_latitude : float or `~astropy.units.Quantity`
        Latitude of the Sun above the plane of the chassis, degrees.
    height : float or `~astropy.units.Quantity`
        Height of the satellite, km.
    step : float or `~astropy.units.Quantity`, optional
        Step of a regular grid, degrees; default 2.
    nside : int, optional
        Resolution of HEALPix cells (RING) instead of a regular grid.
    output : {"auto", "qtable", "dict"}
        As for `StreakModel.flag`.
    **light
        ``band, mag_system, earthshine, models``.

    Returns
    -------
    QTable or dict of arrays, ``(n_directions,)`` each
        ``healpix_cell`` (with ``nside``), ``observer_longitude_deg``, ``observer_latitude_deg``,
        ``standard_magnitude``; model and settings are in the table's ``meta``.
    """
    columns, facts = _core.body_map(
        _setup("body_map", light, LightOptions),
        str(model),
        scalar(sun_latitude, "deg", "sun_latitude"),
        scalar(height, "km", "height"),
        None if step is None else scalar(step, "deg", "step"),
        None if nside is None else count(nside, "nside", 1),
    )
    return table_of(columns, output, meta=json.loads(facts))


def sky_map(
    model: str,
    *,
    sun_altitude: FloatLike,
    sun_azimuth: FloatLike = 0.0,
    height: FloatLike = 550.0,
    step: FloatLike | None = None,
    nside: int | None = None,
    output: Output = "auto",
    **light: Unpack[SkyLightOptions],
) -> Table:
    """Returns apparent magnitudes over the sky of a site, as printed by ``streakcast map sky``.

    Parameters
    ----------
    model, sun_altitude, sun_azimuth, height, **light
        As for `sky_magnitudes`.
    step, nside, output
        As for `body_map`.

    Returns
    -------
    QTable or dict of arrays, ``(n_directions,)`` each
        ``healpix_cell`` (with ``nside``), ``azimuth_deg``, ``altitude_deg``, ``range_km``, ``magnitude``; model and
        settings are in the table's ``meta``.
    """
    columns, facts = _core.sky_map(
        _setup("sky_map", light, SkyLightOptions),
        str(model),
        scalar(sun_altitude, "deg", "sun_altitude"),
        scalar(sun_azimuth, "deg", "sun_azimuth"),
        scalar(height, "km", "height"),
        None if step is None else scalar(step, "deg", "step"),
        None if nside is None else count(nside, "nside", 1),
    )
    return table_of(columns, output, meta=json.loads(facts))


def _setup(function: str, light: Mapping[str, object], options: type[LightOptions]) -> str:
    """Returns the configuration document; the height of the site is named ``height_m`` here."""
    if light.get("height_m") is not None:
        finite_scalar(light["height_m"], "m", "height_m")
    for name in light:
        if name not in options.__annotations__:
            raise TypeError(f"{function} has no argument '{name}'; allowed: {', '.join(options.__annotations__)}")
    return json.dumps(document({"height" if name == "height_m" else name: value for name, value in light.items()}))
