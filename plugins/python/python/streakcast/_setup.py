"""Conversion of the arguments of a model to the configuration document, as used by all interfaces of streakcast."""

from __future__ import annotations

import os
from typing import Any

from ._core import SetupError
from ._quantities import is_of, scalar

#: Keys that affect positions and brightness of satellites. The other keys affect field and policy.
SKY_KEYS = frozenset(
    {
        "elements", "shells", "accept_bad_checksums", "site", "mpc", "lat", "lon", "height", "observer_elements",
        "observer_norad", "limb_height_km", "drag", "shadow", "eop", "qs_mag", "model", "models", "learned",
    }
)  # fmt: skip
#: Keys that an engine uses in addition to the satellites.
ENGINE_KEYS = frozenset(
    {
        "fov", "field", "telescope", "band", "mag_system", "earthshine", "extinction", "sun_distance", "limit_mag",
        "min_probability", "policy", "blocking", "max_delay", "time_scale",
    }
)  # fmt: skip


def document(arguments: dict[str, Any]) -> dict[str, Any]:
    """Returns the document of the given arguments: numbers, strings, lists and dictionaries, with absolute paths."""
    given: dict[str, Any] = {}
    for key, value in arguments.items():
        if value is None:
            continue
        if key == "mjd_scale":
            key = "time_scale"
        if key not in SKY_KEYS and key not in ENGINE_KEYS:
            allowed = ", ".join(sorted(SKY_KEYS | ENGINE_KEYS - {"time_scale"} | {"config", "epoch", "mjd_scale"}))
            raise TypeError(f"StreakModel has no argument '{key}'; allowed: {allowed}")
        given[key] = _CONVERTERS.get(key, _plain)(key, value)
    return given


def absolute(path: Any) -> str:
    """Returns the absolute path, which is also valid in other processes."""
    return str(os.path.abspath(os.fspath(path)))


def _plain(key: str, value: Any) -> Any:
    """Returns the value in JSON types; NumPy scalars are converted."""
    if isinstance(value, dict):
        return {str(name): _plain(key, item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(key, item) for item in value]
    if isinstance(value, (str, bool, int, float)):
        return value
    if isinstance(value, os.PathLike):
        return absolute(value)
    item = getattr(value, "item", None)
    if item is not None and getattr(value, "shape", None) == () and not is_of("astropy.units", "Quantity", value):
        return item()
    raise SetupError(f"{key} is {type(value).__name__}; allowed: strings, numbers, and lists and dictionaries of these")


def _paths(key: str, value: Any) -> list[str]:
    if isinstance(value, (str, os.PathLike)):
        return [absolute(value)]
    try:
        return [absolute(path) for path in value]
    except TypeError:
        raise SetupError(f"{key} is {type(value).__name__}; allowed: a path, or a list of paths") from None


def _path(key: str, value: Any) -> str:
    if not isinstance(value, (str, os.PathLike)):
        raise SetupError(f"{key} is {type(value).__name__}; allowed: a path")
    return absolute(value)


def _path_or_table(key: str, value: Any) -> Any:
    return _plain(key, value) if isinstance(value, dict) else _path(key, value)


def _names(key: str, value: Any) -> Any:
    """Returns names of presets unchanged, and paths of TOML files as absolute paths."""
    if isinstance(value, dict):
        return _plain(key, value)
    if isinstance(value, (list, tuple)):
        return [_names(key, item) for item in value]
    text = os.fspath(value) if isinstance(value, (str, os.PathLike)) else None
    if text is None:
        raise SetupError(f"{key} is {type(value).__name__}; allowed: a name or a TOML file")
    return absolute(text) if text.endswith(".toml") else text


def _site(key: str, value: Any) -> Any:
    if is_of("astropy.coordinates", "EarthLocation", value):
        geodetic = value.to_geodetic("WGS84")
        name = getattr(value.info, "name", None) or "site"
        return {
            "name": str(name),
            "latitude_deg": float(geodetic.lat.to_value("deg")),
            "longitude_deg": float(geodetic.lon.to_value("deg")),
            "height_m": float(geodetic.height.to_value("m")),
        }
    return _plain(key, value)


def _angle(key: str, value: Any) -> Any:
    """Returns a `Quantity` as a string with its unit. Numbers without a unit are passed on, and rejected later."""
    if is_of("astropy.units", "Quantity", value):
        return f"{scalar(value, 'deg', key)!r}deg"
    return _plain(key, value)


def _seconds(key: str, value: Any) -> Any:
    if is_of("astropy.units", "Quantity", value):
        return f"{scalar(value, 's', key)!r}s"
    return _plain(key, value)


def _models(key: str, value: Any) -> Any:
    table = _plain(key, value)
    if not isinstance(table, dict):
        raise SetupError("models is not a dictionary; allowed: {'files': [...], 'generations': {...}, 'qs_mag': ...}")
    for paths in ("files", "qs_mag"):
        if paths in table:
            table[paths] = _paths(key, table[paths]) if paths == "files" else _path(key, table[paths])
    return table


def _model(key: str, value: Any) -> list[str]:
    """Returns names or absolute paths of models, each after its generation of satellites, as for ``--model``."""
    if isinstance(value, (str, os.PathLike)):
        value = {None: value}
    if not isinstance(value, dict):
        raise SetupError(f"{key} is {type(value).__name__}; allowed: a name, a JSON file, or {{kind: name or file}}")
    assigned = []
    for kind, model in value.items():
        text = os.fspath(model)
        text = absolute(text) if text.lower().endswith(".json") or os.sep in text else text
        assigned.append(text if kind is None else f"{kind}={text}")
    return assigned


_CONVERTERS = {
    "model": _model,
    "elements": _paths,
    "shells": _names,
    "telescope": _names,
    "eop": _path,
    "qs_mag": _path,
    "learned": _path,
    "observer_elements": _path,
    "field": _path_or_table,
    "policy": _path_or_table,
    "site": _site,
    "fov": _angle,
    "max_delay": _seconds,
    "models": _models,
}
