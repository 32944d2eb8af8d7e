"""Positions of satellites are identical to those of the command line program; errors for invalid arguments."""

import numpy as np
import pytest
from astropy import units as u
from astropy.table import QTable
from astropy.time import Time

from conftest import START
from test_forecast import assert_equal
import streakcast

NAMES = ["S1 P24-1", "S1 P60-2"]


def test_verif_places_equal_the_command_line(model, command_line):
    end = "2026-08-14T23:30:05Z"
    arguments = ["ephemeris", "--shells", "starlink-gen1", "--mpc", "X05", "--start", START, "--end", end, "--step", "20s", "--name", *NAMES]
    answer = command_line(*arguments)["ephemeris"]
    times = Time(START[:-1], scale="utc") + np.arange(4) * 20 * u.s
    result = model.ephemeris(times, name=NAMES)
    assert isinstance(result, QTable) and len(result) == len(answer) > 40
    for row, expected in zip(result, answer):
        for name, value in expected.items():
            assert_equal(row[name], value, name)
    assert result["ra_deg"].unit == u.deg and result["range_rate_km_s"].unit == u.km / u.s
    # The result does not depend on the shape of the times, and arrays do not require astropy.
    arrays = model.ephemeris(times.reshape(2, 2), name=NAMES, output="dict")
    assert np.array_equal(arrays["ra_deg"], result["ra_deg"].value)
    assert arrays["along_track_sigma_s"].shape == (len(result),)
    up = model.ephemeris(times, name=NAMES, min_altitude=10 * u.deg)
    assert len(up) == np.sum(result["altitude_deg"] >= 10 * u.deg)
    one = int(result["norad_id"][0])
    assert np.array_equal(model.ephemeris(times, norad=one)["dec_deg"], result["dec_deg"][:4])


def test_errors_name_what_is_allowed(model):
    with pytest.raises(ValueError, match="at least one of them"):
        model.ephemeris(START)
    with pytest.raises(TypeError, match="scale"):
        model.ephemeris(61266.97, name=NAMES)
    with pytest.raises(ValueError, match="times is empty"):
        model.ephemeris([], name=NAMES, scale="utc")
    with pytest.raises(streakcast.StreakcastError, match="has a name with NO SUCH"):
        model.ephemeris(START, name="NO SUCH")
    with pytest.raises(ValueError, match="min_altitude is nan; allowed: a number of deg"):
        model.ephemeris(START, name=NAMES, min_altitude=np.nan)
    with pytest.raises(streakcast.StreakcastError, match="^min_altitude is 91"):
        model.ephemeris(START, name=NAMES, min_altitude=91)
