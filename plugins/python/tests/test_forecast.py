"""Passes of a night are identical to those of the command line program; errors for invalid arguments."""

import csv
import datetime
import os
import subprocess
import warnings
from decimal import Decimal

import numpy as np
import pytest
from astropy import units as u
from astropy.table import QTable
from astropy.time import Time

from conftest import START
from test_threads import steps_while
import streakcast

NIGHT = "2026-08-14"
#: Names of some planes of the first shells, with passes in the evening and morning; few enough for a debug build.
PLANES = ["S1 P2", "S1 P6"]


@pytest.fixture(scope="module")
def sky():
    return streakcast.StreakModel(mpc="X05", shells="starlink-gen1")


def text_of(cell, decimals):
    """Formats a number as the command line program does, with the decimals of its column."""
    return f"{float(getattr(cell, 'value', cell)):.{decimals}f}"


def is_missing(cell):
    if cell is None or cell is np.ma.masked or bool(np.any(getattr(cell, "mask", False))):
        return True
    return isinstance(cell, str) and not cell or not isinstance(cell, str) and np.ndim(cell) == 0 and is_nan(cell)


def is_nan(cell):
    value = getattr(cell, "value", cell)
    return isinstance(value, (float, np.floating)) and np.isnan(value)


def assert_equal(result, printed, name):
    """Compares a cell with a value of the JSON output, to all printed digits."""
    if printed is None:
        assert is_missing(result), (name, result)
    elif isinstance(printed, Decimal):
        assert Decimal(text_of(result, -printed.as_tuple().exponent)) == printed, (name, result, printed)
    elif isinstance(printed, str) and printed.endswith("Z") and name.endswith("utc"):
        assert same_moment(result, printed), (name, result, printed)
    elif isinstance(printed, bool):
        assert bool(result) is printed, name
    else:
        assert result == printed, (name, result, printed)


def same_moment(result, printed):
    """Returns True if times agree to half of the last printed digit, plus 1 ns for the conversion by two doubles."""
    if isinstance(result, str):
        return result == printed
    digits = len(printed.split(".")[1]) - 1 if "." in printed else 0
    return abs((result - Time(printed[:-1], scale="utc")).to_value("s")) <= 0.5 * 10.0**-digits + 1e-9


def assert_same_passes(result, printed):
    assert len(result) == len(printed) > 0
    for row, expected in zip(result, printed):
        for name, value in expected.items():
            if name != "samples":
                assert_equal(row[name], value, name)
                continue
            assert len(row["samples"]) == len(value)
            for point, other in zip(row["samples"], value):
                for part in other:
                    assert_equal(point[part], other[part], part)


def test_verif_a_night_equals_the_command_line(sky, command_line):
    arguments = ["forecast", "--shells", "starlink-gen1", "--mpc", "X05", "--night", NIGHT, "--name", *PLANES]
    answer = command_line(*arguments, "--max-mag", "6", "--samples", "5")
    result = sky.forecast(NIGHT, name=PLANES, max_mag=6, samples=5)
    assert_same_passes(result.passes, answer["passes"])
    assert (result.passes["night"] == 0).all() and len(result.nights) == 1
    for name, value in answer["night"][0].items():
        assert_equal(result.nights[0][name], value, name)
    assert answer["night"][0]["passes_too_faint"] > 0
    # All options together.
    answer = command_line(
        *arguments, "--sun-altitude-deg=-12", "--min-altitude", "20", "--min-culmination", "40", "--generation", "starlink-v1.5", "--include-dark"
    )
    result = sky.forecast(
        datetime.date(2026, 8, 14), name=PLANES, max_sun_altitude=-12 * u.deg, min_altitude=20 * u.deg, min_culmination=40,
        generation="starlink-v1.5", include_dark=True,
    )  # fmt: skip
    assert_same_passes(result.passes, answer["passes"])


def test_verif_a_time_span_equals_the_command_line(sky, command_line):
    end = "2026-08-15T00:20:00Z"
    answer = command_line("forecast", "--shells", "starlink-gen1", "--mpc", "X05", "--start", START, "--end", end, "--max-mag", "5.1")
    expected = sky.forecast(start=START, end=end, max_mag=5.1)
    assert_same_passes(expected.passes, answer["passes"])
    other = sky.forecast(start=Time(START[:-1]).mjd, end=Time(end[:-1]), scale="utc", max_mag=5.1)
    assert list(other.passes["norad_id"]) == list(expected.passes["norad_id"])


def test_verif_a_real_night_equals_the_command_line(data, tmp_path):
    elements = data / "tle" / "active" / "active_2026-04-25.txt"
    path = tmp_path / "night.csv"
    binary = os.environ.get("STREAKCAST_BIN") or pytest.fail("set STREAKCAST_BIN, or run plugins/test.sh")
    names = ["STARLINK-311", "ONEWEB-01", "ISS (", "COSMOS 22"]
    done = subprocess.run(
        [binary, "forecast", "--elements", elements, "--mpc", "X05", "--night", "2026-04-25", "--name", *names, "-o", path],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    printed = list(csv.DictReader(line for line in path.read_text().splitlines() if not line.startswith("#")))
    model = streakcast.StreakModel(mpc="X05", elements=elements)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = model.forecast("2026-04-25", name=names).passes
    assert len(result) == len(printed) > 50
    for row, expected in zip(result, printed):
        for name, value in expected.items():
            if name in ("norad_id", "name", "mag_source", "position_source"):
                assert str(row[name]) == value
            elif not value:
                assert is_missing(row[name]), name
            elif name == "in_fitted_range":
                assert str(bool(row[name])).lower() == value
            else:
                assert_equal(row[name], value if name.endswith("utc") else Decimal(value), name)
    # The warnings are the same, with argument names instead of flags.
    mine = [str(one.message) for one in caught if issubclass(one.category, streakcast.StreakcastWarning)]
    (prior,) = [line for line in mine if "prior" in line]
    assert f"warning: {prior}".replace("qs_mag", "--qs-mag") in done.stderr.splitlines()
    assert f"{sum(source == 'prior' for source in result['mag_source'])} passes shown" in prior


def test_several_nights_and_forms(sky):
    nights = sky.forecast([NIGHT, "2026-08-16"], norad=[900000539, 900002197], samples=2)
    alone = [sky.forecast(night, norad=[900000539, 900002197]).passes for night in (NIGHT, "2026-08-16")]
    assert len(nights.nights) == 2 and list(nights.passes["night"]) == [0] * len(alone[0]) + [1] * len(alone[1])
    assert list(nights.passes["peak_magnitude"]) == [*alone[0]["peak_magnitude"], *alone[1]["peak_magnitude"]]
    assert isinstance(nights.passes, QTable) and nights.passes["range_km"].unit == u.km
    plain = sky.forecast(NIGHT, norad=900000539, output="dict")
    assert plain.passes["peak_utc"].dtype == np.dtype("datetime64[ns]") and plain.passes["peak_magnitude"].dtype == float
    # Without passes the table has columns but no rows, and the table of nights contains a reason.
    none = sky.forecast(NIGHT, norad=900000539, max_mag=-8)
    assert len(none.passes) == 0 and "peak_magnitude" in none.passes.colnames
    assert "brighter than mag -8" in none.nights["why_empty"][0]


def test_invalid_arguments_are_reported(sky):
    cases = [
        (dict(night="8/14/2026"), "invalid night '8/14/2026'; allowed: the local date of the evening"),
        (dict(), "specify night, or start and end"),
        (dict(night=[]), "night is empty; allowed"),
        (dict(night=NIGHT, start=START, end=START), "specify night, or start and end"),
        (dict(start=START), "start and end require each other"),
        (dict(start=START, end="2026-08-13T00:00:00Z"), "the end not before the start"),
        (dict(night=NIGHT, min_altitude=95), "min_altitude is 95 deg; allowed: 0 deg to below 90 deg"),
        (dict(night=NIGHT, max_sun_altitude=-100), "max_sun_altitude is -100 deg"),
        (dict(night=NIGHT, max_mag=float("nan")), "max_mag is nan"),
        (dict(night=NIGHT, max_sun_altitude=float("nan")), "max_sun_altitude is nan; allowed: a number of deg"),
        (dict(night=NIGHT, samples=20_000), "samples is 20000; allowed: 0 to 10000"),
        (dict(night=NIGHT, samples=-1), "samples is -1; allowed: 0 or more"),
        (dict(night=NIGHT, generation="starlink"), "unknown generation 'starlink'; allowed: .*starlink-v2mini"),
        (dict(night=NIGHT, name="ISS (ZARYA)"), "none of the 4408 satellites has a name with ISS"),
        (dict(night=NIGHT, norad=0), "norad is 0; allowed: 1 or more"),
        (dict(night=NIGHT, norad=10**10), "1 to 999999999"),
        (dict(night=NIGHT, output="pandas"), "allowed: auto, qtable, dict"),
    ]
    for options, message in cases:
        with pytest.raises(ValueError, match=message):
            sky.forecast(**options)
    for options in (dict(night=NIGHT, norad="ISS"), dict(night=NIGHT, name=25544), dict(night=NIGHT, samples=1.5)):
        with pytest.raises(TypeError, match="allowed"):
            sky.forecast(**options)
    for night in (Time(NIGHT), Time([NIGHT, NIGHT])):
        with pytest.raises(TypeError, match="night is a Time; allowed: local dates of evenings"):
            sky.forecast(night)
    with pytest.raises(TypeError, match="scale"):
        sky.forecast(start=61266.9, end=61267.1)


def test_other_threads_run_during_a_forecast(sky):
    work = lambda: sky.forecast(NIGHT)  # noqa: E731
    work()
    assert steps_while(work) > 10
