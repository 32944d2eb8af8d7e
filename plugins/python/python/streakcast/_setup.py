"""Conversion of the arguments of a model to the configuration document, as used by all interfaces of streakcast."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from difflib import get_close_matches

import numpy as np

from ._core import SetupError
from ._quantities import check_unmasked, is_of, is_quantity, number
from .typing import FieldOptions, FloatArray, Json, PathLike

#: Keys that affect positions and brightness of satellites. The other keys affect field and policy.
SKY_KEYS = frozenset(
    {
        "elements", "shells", "accept_bad_checksums", "site", "mpc", "lat", "lon", "height", "observer_elements",
        "observer_norad", "limb_height_km", "max_zenith_angle", "min_sun_angle", "min_limb_angle", "drag", "shadow", "eop",
        "qs_mag", "model", "models", "learned", "measured",
    }
)  # fmt: skip
#: Keys that an engine uses in addition to the satellites.
ENGINE_KEYS = frozenset(FieldOptions.__annotations__) - {"mjd_scale"} | {"time_scale"}
#: Units of keys that do not end with their unit.
_KEY_UNITS = {
    **dict.fromkeys(("lat", "lon", "max_zenith_angle", "min_sun_angle", "min_limb_angle"), "deg"),
    "height": "m",
    "extinction": "mag",
}
#: Units at the ends of the names of other keys.
_UNITS = ("arcmin", "arcsec", "deg", "km", "m", "mag", "s", "um")
#: Types of values in the document, and their names in errors, of keys whose type is not checked by their converter.
_KINDS: dict[str, tuple[tuple[type, ...], str]] = {
    **dict.fromkeys(("mpc", "band", "mag_system", "blocking", "drag", "shadow", "mjd_scale"), ((str,), "a string")),
    **dict.fromkeys(("accept_bad_checksums", "earthshine", "sun_distance"), ((bool,), "True, False")),
    **dict.fromkeys(("lat", "lon", "height", "limb_height_km"), ((int, float), "a number")),
    **dict.fromkeys(("max_zenith_angle", "min_sun_angle", "min_limb_angle"), ((int, float), "a number")),
    **dict.fromkeys(("extinction", "min_probability", "bright_share"), ((int, float), "a number")),
    "observer_norad": ((int,), "a whole number"),
    **dict.fromkeys(
        ("limit_mag", "limit_surface_brightness"),
        ((int, float, dict), "a number, or numbers by band, {'g': 7, 'default': 6}"),
    ),
    "site": ((str, dict), "a name, an EarthLocation, or {'latitude_deg': ..., 'longitude_deg': ..., 'height_m': ...}"),
}


def document(arguments: Mapping[str, object]) -> dict[str, Json]:
    """Returns the document of the given arguments: numbers, strings, lists and dictionaries, with absolute paths."""
    given: dict[str, Json] = {}
    for key, value in arguments.items():
        if value is None:
            continue
        name = "time_scale" if key == "mjd_scale" else key
        if name not in SKY_KEYS and name not in ENGINE_KEYS:
            known = sorted(SKY_KEYS | ENGINE_KEYS - {"time_scale"} | {"config", "epoch", "mjd_scale"})
            nearest = get_close_matches(key, known, 1, 0.8)
            hint = f"did you mean {nearest[0]}?" if nearest else f"allowed: {', '.join(known)}"
            raise TypeError(f"StreakModel has no argument '{shortened(key)}'; {hint}")
        given[name] = _CONVERTERS.get(key, _plain)(key, value)
        _check_kind(key, given[name])
        _check_finite(key, given[name])
    return given


def shortened(text: str) -> str:
    """Returns a given text as shown in errors: its first 60 characters."""
    return text if len(text) <= 60 else f"{text[:60]}..."


def _check_kind(key: str, value: Json) -> None:
    """Raises an error if the value has another type than its key."""
    if key not in _KINDS:
        return
    kinds, allowed = _KINDS[key]
    # In Python, bool is a kind of int.
    if not isinstance(value, kinds) or (isinstance(value, bool) and bool not in kinds):
        raise SetupError(f"{key} is {shortened(repr(value))}; allowed: {allowed}")


def _check_finite(what: str, value: Json) -> None:
    """Raises an error for NaN and infinity, also in lists and dictionaries."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for name, item in items:
        _check_finite(f"{what}[{name!r}]", item)
    if isinstance(value, float) and not np.isfinite(value):
        raise SetupError(f"{what} is {value}; allowed: finite numbers")


def absolute(path: PathLike) -> str:
    """Returns the absolute path, which is also valid in other processes."""
    if not isinstance(path, (str, os.PathLike)):
        raise TypeError(f"{type(path).__name__} is given as a path; allowed: a string or a path")
    return str(os.path.abspath(os.fspath(path)))


def _unit_of(key: str) -> str:
    """Returns the unit of a key: that at the end of its name; empty if there is none."""
    unit = key.rpartition("_")[2]
    return _KEY_UNITS.get(key, unit if unit in _UNITS and unit != key else "")


def _plain(key: str, value: object) -> Json:
    """Returns the value in JSON types; NumPy scalars are converted, and quantities to the unit of their key."""
    if isinstance(value, Mapping):
        # In a table of limits by band, the unit is that of the table.
        return {str(name): _plain(str(name) if _unit_of(str(name)) else key, item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(key, item) for item in value]
    if isinstance(value, (str, bool, int, float)):
        return value
    if isinstance(value, os.PathLike):
        return absolute(value)
    if is_quantity(value):
        numbers: Json = _in_unit(key, value, _unit_of(key)).tolist()
        return numbers
    check_unmasked(value, key, "allowed: a value")
    if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.shape == ()):
        item: Json = value.item()
        return item
    raise SetupError(f"{key} is {type(value).__name__}; allowed: strings, numbers, and lists and dictionaries of these")


def _in_unit(key: str, value: object, unit: str) -> FloatArray:
    """Returns one or several quantities as numbers in a unit."""
    try:
        return number(value, unit, key)
    except ValueError as error:
        raise SetupError(str(error)) from None


def _paths(key: str, value: object) -> list[Json]:
    if isinstance(value, (str, os.PathLike)):
        return [absolute(value)]
    if isinstance(value, Iterable):
        return [_path(key, path) for path in value]
    raise SetupError(f"{key} is {type(value).__name__}; allowed: a path, or a list of paths")


def _path(key: str, value: object) -> str:
    if not isinstance(value, (str, os.PathLike)):
        raise SetupError(f"{key} is {type(value).__name__}; allowed: a path")
    return absolute(value)


def _path_or_table(key: str, value: object) -> Json:
    return _plain(key, value) if isinstance(value, Mapping) else _path(key, value)


def _names(key: str, value: object) -> Json:
    """Returns names of presets unchanged, and paths of TOML files as absolute paths."""
    if isinstance(value, Mapping):
        return _plain(key, value)
    if isinstance(value, (list, tuple)):
        return [_names(key, item) for item in value]
    text = os.fspath(value) if isinstance(value, (str, os.PathLike)) else None
    if text is None:
        raise SetupError(f"{key} is {type(value).__name__}; allowed: a name or a TOML file")
    return absolute(text) if text.endswith(".toml") else text


def _band(key: str, value: object) -> Json:
    """Returns names of bands unchanged, and paths of response files as absolute paths."""
    text = os.fspath(value) if isinstance(value, (str, os.PathLike)) else None
    if text is None:
        raise SetupError(f"{key} is {shortened(repr(value))}; allowed: a string")
    return absolute(text) if "." in text or os.sep in text else text


def _site(key: str, value: object) -> Json:
    if is_of("astropy.coordinates", "EarthLocation", value):
        geodetic = getattr(value, "to_geodetic")("WGS84")
        name = getattr(getattr(value, "info"), "name", None)
        return {
            **({"name": str(name)} if name else {}),
            "latitude_deg": float(geodetic.lat.to_value("deg")),
            "longitude_deg": float(geodetic.lon.to_value("deg")),
            "height_m": float(geodetic.height.to_value("m")),
        }
    return _plain(key, value)


def _fov(key: str, value: object) -> Json:
    """Returns a diameter, or width and height, as a string with the unit. Numbers without a unit are rejected later."""
    if is_quantity(value) or (isinstance(value, (list, tuple)) and any(is_quantity(side) for side in value)):
        return "x".join(repr(side) for side in _in_unit(key, value, "deg").ravel().tolist()) + "deg"
    return _plain(key, value)


def _seconds(key: str, value: object) -> Json:
    """Returns a duration as a string with its unit. Numbers without a unit are rejected later."""
    if not is_quantity(value):
        return _plain(key, value)
    length_s = _in_unit(key, value, "s")
    if length_s.shape != ():
        raise SetupError(f"{key} has the shape {length_s.shape}; allowed: one number")
    return f"{float(length_s)!r}s"


def _models(key: str, value: object) -> Json:
    table = _plain(key, value)
    if not isinstance(table, dict):
        raise SetupError("models is not a dictionary; allowed: {'files': [...], 'generations': {...}, 'qs_mag': ...}")
    for paths in ("files", "qs_mag"):
        if paths in table:
            table[paths] = _paths(key, table[paths]) if paths == "files" else _path(key, table[paths])
    return table


def _model(key: str, value: object) -> Json:
    """Returns names or absolute paths of models, each after its generation of satellites, as for ``--model``."""
    if isinstance(value, (str, os.PathLike)):
        value = {None: value}
    if not isinstance(value, Mapping):
        raise SetupError(f"{key} is {type(value).__name__}; allowed: a name, a JSON file, or {{kind: name or file}}")
    assigned: list[Json] = []
    for kind, model in value.items():
        text = os.fspath(model)
        text = absolute(text) if text.lower().endswith(".json") or os.sep in text else text
        assigned.append(text if kind is None else f"{kind}={text}")
    return assigned


_CONVERTERS: dict[str, Callable[[str, object], Json]] = {
    "model": _model,
    "elements": _paths,
    "shells": _names,
    "telescope": _names,
    "band": _band,
    "eop": _path,
    "qs_mag": _path,
    "learned": _path,
    "measured": _paths,
    "observer_elements": _path,
    "field": _path_or_table,
    "policy": _path_or_table,
    "site": _site,
    "fov": _fov,
    "max_delay": _seconds,
    "models": _models,
}
