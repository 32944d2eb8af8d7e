"""Array shapes and astropy types of arguments and results."""

import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import AltAz, EarthLocation, SkyCoord
from astropy.table import QTable
from astropy.time import Time

from conftest import START, TARGET
import streakcast
from streakcast import _times


def test_numbers_for_one_and_arrays_for_many(model):
    one = model.assess(TARGET, START, 30.0)
    assert isinstance(one.n_streaks, int) and isinstance(one.p_any, float) and one.crosses is True
    assert one.p_any_is_lower_limit is False
    assert one.verdict == "avoid" and one.avoid and not one.clear
    assert 0.0 < one.lost_fraction < 0.1 and one.brightest_mag < 7.0
    many = model.assess((np.full((2, 3), TARGET[0]), TARGET[1]), START, np.array([30.0, 30.0, 1e-3]))
    assert many.verdict.shape == many.p_any.shape == (2, 3)
    np.testing.assert_array_equal(many.n_streaks[:, :2], one.n_streaks)
    empty = model.assess((np.array([]), np.array([])), np.array([]), 30.0, scale="utc")
    assert empty.verdict.shape == (0,)
    assert len(model.flag((np.array([]), np.array([])), np.array([]), 30.0, scale="utc")) == 0


def test_unaligned_arrays(model):
    def unaligned(array):
        return np.frombuffer(b"-" + np.asarray(array).tobytes(), dtype=array.dtype, offset=1)

    start = np.array([61266.97856481])
    assert not unaligned(start).flags.aligned
    jd1, jd2 = _times.to_tai(start, "utc", "start")
    expected = model.assess(TARGET, _times.TwoPartTai(jd1, jd2), 30.0)
    same = model.assess(TARGET, _times.TwoPartTai(unaligned(jd1), unaligned(jd2)), 30.0)
    np.testing.assert_array_equal(same.p_any, expected.p_any)


def test_astropy_in(model):
    expected = model.assess(TARGET, START, 30.0)
    time = Time(START[:-1], scale="utc")
    coordinate = SkyCoord(TARGET[0], TARGET[1], unit="deg")
    for target in (coordinate, coordinate.galactic, coordinate.fk5, (TARGET[0] / 15 * u.hourangle, TARGET[1] * u.deg)):
        answer = model.assess(target, time, 0.5 * u.min)
        assert answer.n_streaks == expected.n_streaks
        assert answer.streak_length_deg == pytest.approx(expected.streak_length_deg, abs=1e-3)
    array = model.assess(SkyCoord([TARGET[0]] * 3, [TARGET[1]] * 3, unit="deg"), time + [0, 30, 60] * u.s, 30 * u.s)
    assert array.n_streaks.shape == (3,) and array.n_streaks[0] == expected.n_streaks
    assert isinstance(model.location, EarthLocation)
    up = model.location.to_geodetic()
    assert up.lat.deg == pytest.approx(model.site.latitude_deg, abs=1e-9)


def test_astropy_site_and_field(model):
    built = streakcast.StreakModel(
        site=model.location, shells="starlink-gen1", telescope="rubin", fov=210 * u.arcmin, limit_mag=7, epoch=Time(START)
    )
    of_built, of_model = built.assess(TARGET, START, 30.0), model.assess(TARGET, START, 30.0)
    assert of_built.n_streaks == of_model.n_streaks
    # The latitude has all digits after the conversion to JSON and back.
    assert of_built.streak_length_deg == pytest.approx(of_model.streak_length_deg, abs=1e-9)


def test_qtable_out(model):
    passes = model.passes(([TARGET[0]] * 2, [TARGET[1]] * 2), START, 30.0, samples=3)
    assert isinstance(passes, QTable)
    assert passes["range_km"].unit == u.km and passes["angular_rate_deg_s"].unit == u.deg / u.s
    assert isinstance(passes["enter_utc"], Time) and passes["enter_utc"].scale == "utc"
    assert (passes["exit_utc"] >= passes["enter_utc"]).all()
    assert set(passes["exposure_id"]) == {0, 1}
    assert passes["range_km"].info.description
    assert [set(sample) >= {"ra_deg", "dec_deg", "magnitude"} for sample in passes["samples"][0]] == [True] * 3
    flags = model.flag(TARGET, START, 30.0)
    assert isinstance(flags, QTable) and list(flags["norad_ids"][0])
    # Plain columns can be formatted as text.
    plain = passes[[name for name in passes.colnames if name not in ("samples", "chords", "lit_chords")]]
    assert "range_km" in "".join(plain.pformat(max_lines=4, max_width=-1))


def test_dictionaries_out_without_astropy(model):
    flags = model.flag(TARGET, START, 30.0, output="dict")
    assert flags["next_clear_start_utc"].dtype == np.dtype("datetime64[ns]")
    assert flags["verdict"][0] == "avoid" and flags["n_streaks"].dtype == np.int64
    with pytest.raises(ValueError, match="allowed: auto, qtable, dict"):
        model.flag(TARGET, START, 30.0, output="pandas")


def test_missing_times_are_masked(model):
    # Satellites that are above the horizon at the start have no rise time.
    span = dict(start=START, end="2026-08-14T23:34:05Z", min_altitude=20 * u.deg)
    passes = model.forecast(**span, include_dark=True, samples=2).passes
    assert len(passes) > 10
    masked = np.asarray(passes["rise_utc"].mask)
    assert masked.any() and not masked.all()
    for row in passes[~masked & ~np.asarray(passes["set_utc"].mask)]:
        np.testing.assert_allclose([point["altitude_deg"] for point in row["samples"]], 20.0, atol=1e-4)
    assert (passes["max_altitude_deg"] >= 19.9999 * u.deg).all()
    assert len(model.forecast(**span).passes) <= len(passes)


def test_check_pointings_has_the_conventions_of_rubin_sim(model):
    mjd = Time(START[:-1], scale="utc").mjd
    ra, dec = np.array([TARGET[0], 10.0]), np.array([TARGET[1], 80.0])
    lengths_deg, n_streaks = model.check_pointings(ra, dec, np.array([mjd, mjd]), 30.0, scale="utc")
    passes = model.passes(TARGET, START, 30.0)
    assert n_streaks[0] == len(passes)
    assert lengths_deg[0] == pytest.approx(passes["streak_length_deg"].to_value("deg").sum())
    # Declination 80 deg is never above the horizon of Cerro Pachon.
    assert n_streaks[1] == 0 and lengths_deg[1] == 0.0


def test_magnitudes_over_arrays():
    azimuth, altitude = np.meshgrid(np.arange(0.0, 360.0, 45.0), [10.0, 45.0, 90.0])
    magnitude, range_km = streakcast.sky_magnitudes("v2mini", azimuth, altitude, sun_altitude=-18 * u.deg, mpc="X05")
    assert magnitude.shape == range_km.shape == azimuth.shape
    assert (np.diff(range_km, axis=0) < 0).all()
    assert 2.0 < np.nanmin(magnitude) < 9.0
    one, near_km = streakcast.sky_magnitudes("v2mini", 0.0, 90.0, sun_altitude=-18, mpc="X05")
    assert (one, near_km) == (magnitude[2, 0], range_km[2, 0])
    standard = streakcast.standard_magnitudes("starlink-v1.5", -10, np.arange(0, 360, 30), [[-80], [-60]])
    assert standard.shape == (2, 12)
    assert "v2mini" in streakcast.model_names()


def test_below_the_horizon_is_invalid(model):
    answer = model.assess((10.0, 80.0), START, 30.0)
    assert answer.verdict == "invalid" and not answer.crosses and np.isnan(answer.p_any)


def test_altaz_targets(model):
    frame = AltAz(obstime=Time(START[:-1], scale="utc"), location=model.location)
    target = SkyCoord(alt=[30, 60] * u.deg, az=[280, 260] * u.deg, frame=frame)
    # Within the radius of the field, plus the change of altitude in ten minutes (2.5 degrees).
    passes = model.passes(target, START, 600.0)
    for index, altitude_deg in enumerate([30.0, 60.0]):
        mine = passes[passes["exposure_id"] == index]
        assert len(mine) > 0
        assert np.all(np.abs(mine["altitude_deg"].to_value("deg") - altitude_deg) < 1.75 + 2.6)


def test_clear_windows_as_plain_arrays(model):
    end = "2026-08-14T23:50:00Z"
    times, plain = (model.windows(TARGET, START, end, 30.0, output=output) for output in ("qtable", "dict"))
    assert isinstance(times.first_start, Time) and plain.first_start.dtype == "datetime64[ns]" and len(times.target) >= 2
    for one, other in ((times.first_start, plain.first_start), (times.last_start, plain.last_start)):
        assert np.abs(one.datetime64 - other).max() < np.timedelta64(1, "us")
    with pytest.raises(ValueError, match="output is 'table'; allowed: auto, qtable, dict"):
        model.windows(TARGET, START, end, 30.0, output="table")
