"""Type annotations: every public function, method, property and field has one, and none of them is `Any`."""

import ast
import dataclasses
import inspect
import typing
from pathlib import Path

import astropy.coordinates
import astropy.io.fits
import astropy.nddata
import astropy.table
import astropy.time
import astropy.units
import astropy.wcs
import distributed
import numpy as np
import numpy.typing as npt
import pytest
import typing_extensions

import streakcast
from streakcast import dask, hosts, plots
from streakcast import typing as types

PACKAGE = Path(streakcast.__file__).parent
#: Names that the package imports only for type checks.
NAMES = {
    "AstropyTable": astropy.table.Table,
    "Client": distributed.Client,
    "CompImageHDU": astropy.io.fits.CompImageHDU,
    "EarthLocation": astropy.coordinates.EarthLocation,
    "HDUList": astropy.io.fits.HDUList,
    "Header": astropy.io.fits.Header,
    "ImageHDU": astropy.io.fits.ImageHDU,
    "NDData": astropy.nddata.NDData,
    "PrimaryHDU": astropy.io.fits.PrimaryHDU,
    "QTable": astropy.table.QTable,
    "Quantity": astropy.units.Quantity,
    "SkyCoord": astropy.coordinates.SkyCoord,
    "StreakModel": streakcast.StreakModel,
    "Time": astropy.time.Time,
    "Unpack": typing_extensions.Unpack,
    "WCS": astropy.wcs.WCS,
    "Self": typing_extensions.Self,
}
#: Types of NumPy, which contain `Any` for the shape and, in tables, for the data type of an array.
OF_NUMPY = (*typing.get_args(npt.ArrayLike), np.ndarray)


def hints(thing):
    return typing.get_type_hints(thing, localns={**vars(types), **NAMES})


def contains_any(hint, seen=()):
    """Returns True if a type is `Any` or has it as a parameter, except in types of NumPy."""
    if hint is typing.Any:
        return True
    if hint in OF_NUMPY or typing.get_origin(hint) in OF_NUMPY or hint in seen:
        return False
    if typing.is_typeddict(hint):
        return any(contains_any(part, (*seen, hint)) for part in hints(hint).values())
    parts = typing.get_args(hint)
    flat = [one for part in parts for one in (part if isinstance(part, list) else [part])]
    return any(contains_any(part, (*seen, hint)) for part in flat if not isinstance(part, (str, int)))


def members(kind):
    """Returns the functions of a class that users call, its constructor included, by name."""
    found = {}
    for name, thing in inspect.getmembers(kind):
        if name.startswith("_") and name != "__init__":
            continue
        thing = thing.fget if isinstance(thing, property) else getattr(thing, "func", thing)
        if inspect.isroutine(thing) and str(getattr(thing, "__module__", "")).startswith("streakcast"):
            found[f"{kind.__name__}.{name}"] = thing
    return found


def public():
    """Returns all functions and methods, and the types with fields, by name."""
    functions, records = {}, {}
    for module, names in (
        (streakcast, streakcast.__all__), (plots, plots.__all__), (hosts, ["Hook"]), (dask, ["annotate", "read"]),
    ):  # fmt: skip
        for name in names:
            thing = getattr(module, name)
            if inspect.isclass(thing):
                functions.update(members(thing))
                if issubclass(thing, tuple) or dataclasses.is_dataclass(thing):
                    records[name] = thing
            elif callable(thing):
                functions[name] = thing
    records.update({name: getattr(types, name) for name in types.__all__ if typing.is_typeddict(getattr(types, name))})
    return functions, records


FUNCTIONS, RECORDS = public()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_signatures_have_no_any(name):
    function = FUNCTIONS[name]
    annotations = hints(function)
    for parameter in inspect.signature(function).parameters:
        assert parameter in annotations or parameter in ("self", "cls"), f"{parameter} has no type"
    assert "return" in annotations
    assert [parameter for parameter, hint in annotations.items() if contains_any(hint)] == []


@pytest.mark.parametrize("name", RECORDS)
def test_fields_have_no_any(name):
    annotations = hints(RECORDS[name])
    assert annotations and [field for field, hint in annotations.items() if contains_any(hint)] == []


@pytest.mark.parametrize("name", types.__all__)
def test_named_types_have_no_any(name):
    assert not contains_any(hints(type("Alias", (), {"__annotations__": {"it": getattr(types, name)}}))["it"])


def test_any_is_found_in_every_place():
    """The tests above can fail."""

    class Options(typing.TypedDict):
        one: typing.Any

    for hint in (
        typing.Any, typing.Optional[typing.Any], list[typing.Any], dict[str, list[typing.Any]], typing.Callable[[typing.Any], int],
        typing.Callable[[], typing.Any], Options, typing_extensions.Unpack[Options],
    ):  # fmt: skip
        assert contains_any(hint), hint
    assert not contains_any(npt.NDArray[np.float64]) and not contains_any(typing.Union[npt.ArrayLike, None])
    assert {"StreakModel.__init__", "StreakModel.assess", "StreakModel.location", "Hook.check_site", "Picture.save"} <= set(FUNCTIONS)
    assert {"inject", "learn", "sky_map", "field", "annotate", "Injected.added"} <= set(FUNCTIONS)
    assert {"Assessment", "Injected", "ModelOptions", "InjectionOptions"} <= set(RECORDS)


def test_both_forms_of_inject_have_the_same_arguments():
    function, options = hints(streakcast.inject), hints(types.InjectionOptions)
    explicit = {"self", "frame", "output", "model", "header", "start", "exposure", "return"}
    assert {name: hint for name, hint in function.items() if name not in explicit} == options


def test_the_compiled_part_has_no_any():
    names = {node.id for node in ast.walk(ast.parse((PACKAGE / "_core.pyi").read_text())) if isinstance(node, ast.Name)}
    assert "Column" in names and "Any" not in names
