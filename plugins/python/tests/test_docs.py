"""Public functions have documented arguments and results, and type annotations are part of the package."""

import inspect
import re
from pathlib import Path

import pytest

import streakcast
from streakcast.typing import ModelOptions

FUNCTIONS = {
    name: thing for name, thing in vars(streakcast).items() if inspect.isfunction(thing) and name in streakcast.__all__
}
METHODS = {
    f"StreakModel.{name}": thing
    for name, thing in inspect.getmembers(streakcast.StreakModel, inspect.isfunction)
    if not name.startswith("_")
}


@pytest.mark.parametrize("name", [*FUNCTIONS, *METHODS])
def test_every_argument_is_documented(name):
    function = {**FUNCTIONS, **METHODS}[name]
    text = inspect.getdoc(function)
    arguments = [argument for argument in inspect.signature(function).parameters if argument != "self"]
    if arguments:
        assert "Parameters\n----------" in text
        parameters = re.search(r"Parameters\n-+\n(.*?)(\n\n\w+\n-+|\Z)", text, re.DOTALL).group(1)
        for argument in arguments:
            assert re.search(rf"(^|\n|, |\*)(\*\*)?{argument}\b", parameters), argument
    assert "Returns\n-------" in text


def test_every_further_argument_of_a_model_is_described():
    text = inspect.getdoc(streakcast.StreakModel)
    for name in ModelOptions.__annotations__:
        assert re.search(rf"^({name} : | *- .*``{name}``)", text, re.MULTILINE), name


def test_types_are_shipped():
    folder = Path(streakcast.__file__).parent
    assert (folder / "py.typed").is_file() and (folder / "_core.pyi").is_file()
    for function in [*FUNCTIONS.values(), *METHODS.values()]:
        assert "return" in function.__annotations__, function


def test_models_have_the_documented_methods():
    assert {f"StreakModel.{name}" for name in ("assess", "passes", "forecast", "identify", "inject", "windows", "reloaded", "key")} <= set(METHODS)


def test_all_names_exist():
    for name in streakcast.__all__:
        assert hasattr(streakcast, name)
