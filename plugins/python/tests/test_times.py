"""Times of all types require a scale, and the scale affects the result."""

import datetime

import numpy as np
import pytest
from astropy import units as u
from astropy.time import Time

import streakcast

from conftest import START, TARGET


def every_form():
    time = Time(START[:-1], scale="utc")
    return [
        (START, None),
        (time, None),
        (time.tt, None),
        (time.tdb, None),
        (datetime.datetime(2026, 8, 14, 23, 29, 5, tzinfo=datetime.timezone.utc), None),
        (datetime.datetime(2026, 8, 15, 1, 29, 5, tzinfo=datetime.timezone(datetime.timedelta(hours=2))), None),
        ("2026-08-14T20:29:05-03:00", None),
        (START[:-1], "utc"),
        (np.datetime64(START[:-1]), "utc"),
        (time.utc.mjd, "utc"),
        (time.tai.mjd, "tai"),
        (time.tt.mjd, "tt"),
        (time.tai.isot, "tai"),
    ]


@pytest.mark.parametrize("start, scale", every_form())
def test_one_time_in_every_form(model, start, scale):
    expected = model.assess(TARGET, START, 30.0)
    answer = model.assess(TARGET, start, 30.0, scale=scale)
    assert answer.n_streaks == expected.n_streaks > 0
    # MJD in a double has a resolution of a microsecond. TDB, which is within 2 ms of TT, is converted by astropy.
    assert answer.streak_length_deg == pytest.approx(expected.streak_length_deg, abs=1e-4)


def test_sequences_of_times(model):
    times = Time(START[:-1], scale="utc") + [0.0, 60.0] * u.s
    expected = model.assess(TARGET, times, 30.0)
    objects = np.empty(2, dtype=object)
    objects[:] = list(times)
    for given in (list(times), tuple(times), objects, [times[0], times[1].tt], [times[0], times[1].isot + "Z"]):
        answer = model.assess(TARGET, given, 30.0)
        np.testing.assert_array_equal(answer.n_streaks, expected.n_streaks)
        np.testing.assert_allclose(answer.streak_length_deg, expected.streak_length_deg, atol=1e-6)
    assert model.assess(TARGET, [list(times)], 30.0).n_streaks.shape == (1, 2)
    # Whole days as integers of any kind, also in columns of objects as pandas has them.
    days = np.array([61266.0, 61267.0])
    expected = model.assess(TARGET, days, 30.0, scale="utc")
    for given in (days.astype(np.int64), days.astype(np.uint16), days.astype(int).astype(object), days.astype(object)):
        answer = model.assess(TARGET, given, 30.0, scale="utc")
        np.testing.assert_array_equal(answer.verdict, expected.verdict)
        np.testing.assert_array_equal(answer.elements_age_days, expected.elements_age_days)
    with pytest.raises(TypeError, match=r"start\[1\] is a bare number without a time scale"):
        model.assess(TARGET, [times[0], 61266.9785], 30.0)
    # Cells of a row of a table.
    row = model.passes(TARGET, START, 30.0)[0]
    ends = tuple((row[f"{end}_ra_deg"], row[f"{end}_dec_deg"]) for end in ("enter", "exit"))
    found = model.identify(ends, (row["enter_utc"], row["exit_utc"]))
    assert found.candidates["norad_id"][0] == row["norad_id"]


@pytest.mark.parametrize("start", [[], (), np.array([]), np.array([], dtype=object), np.array([], dtype="datetime64[s]")])
def test_no_times_need_no_scale(model, start):
    assert model.assess(([], []), start, 30.0).n_streaks.shape == (0,)


@pytest.mark.parametrize(
    "start",
    [
        61266.9785,
        61266,
        np.float32(61266.9785),
        np.array([61266.9785, 61266.98]),
        START[:-1],
        [START, START[:-1]],
        np.datetime64(START[:-1]),
        datetime.datetime(2026, 8, 14, 23, 29, 5),
        None,
        object(),
        [None],
        True,
    ],
)
def test_a_bare_time_is_a_type_error(model, start):
    with pytest.raises(TypeError, match="scale"):
        model.assess(TARGET, start, 30.0)
    with pytest.raises(TypeError, match="scale"):
        model.check_pointings(TARGET[0], TARGET[1], start, 30.0)


def test_tai_read_as_utc_changes_the_result(model):
    starts = Time(START[:-1], scale="utc").mjd + np.arange(60) / 1440.0
    ra, dec = np.linspace(190.0, 210.0, 60), np.linspace(-20.0, 10.0, 60)
    utc = model.assess((ra, dec), starts, 30.0, scale="utc")
    tai = model.assess((ra, dec), starts, 30.0, scale="tai")
    assert utc.crosses.sum() > 3
    # After 37 s almost no satellite is still in the field.
    assert (utc.streak_length_deg != tai.streak_length_deg)[utc.crosses | tai.crosses].all()


def test_the_scale_of_the_model(model):
    mjd = Time(START[:-1], scale="utc").tai.mjd
    tai = model.with_options(mjd_scale="tai")
    assert tai.mjd_scale == "tai" and model.mjd_scale is None
    assert tai.assess(TARGET, mjd, 30.0).n_streaks == model.assess(TARGET, START, 30.0).n_streaks
    # A string with a time zone uses it.
    assert tai.assess(TARGET, START, 30.0).n_streaks == model.assess(TARGET, START, 30.0).n_streaks
    # The scale of a call overrides that of the model.
    of_tai, of_model = tai.assess(TARGET, mjd, 30.0, scale="utc"), model.assess(TARGET, mjd, 30.0, scale="utc")
    assert (of_tai.n_streaks, of_tai.p_any) == (of_model.n_streaks, of_model.p_any)


@pytest.mark.parametrize("scale", ["ut1", "local", "", "UTC+1"])
def test_unknown_scales(model, scale):
    with pytest.raises(ValueError, match="allowed: utc, tai, tt"):
        model.assess(TARGET, 61266.9785, 30.0, scale=scale)


def test_nanoseconds_survive_the_round_trip(model):
    start = Time("2026-08-14T23:29:05.123456789", scale="utc")
    answer = model.flag(TARGET, start, 30.0)
    clear = answer["next_clear_start_utc"][0]
    delay_s = answer["delay_s"].value[0]
    assert delay_s > 0.0
    assert abs((clear - start).sec - delay_s) < 1e-6


def test_numbers_of_single_precision_and_other_units_are_errors():
    model = streakcast.StreakModel(mpc="X05", shells="starlink-gen1", fov="3.5deg")
    mjd = np.array([61266.9785])
    with pytest.raises(TypeError, match=r"start is float32, which has MJD in steps of 338 s; allowed: float64"):
        model.assess(TARGET, mjd.astype("float32"), 30.0, scale="utc")
    with pytest.raises(TypeError, match="start is float32"):
        model.assess(TARGET, mjd.astype("float32") * u.day, 30.0, scale="utc")
    with pytest.raises((TypeError, ValueError), match="start"):
        model.assess(TARGET, mjd * u.deg, 30.0, scale="utc")
    days = model.assess(TARGET, mjd * u.day, 30.0, scale="utc")
    assert days.n_streaks == model.assess(TARGET, mjd, 30.0, scale="utc").n_streaks
    with pytest.raises(TypeError, match="scale local"):
        model.assess(TARGET, Time(mjd, format="mjd", scale="local"), 30.0)


def test_exposures_of_no_time_are_errors():
    model = streakcast.StreakModel(mpc="X05", shells="starlink-gen1", fov="3.5deg")
    with pytest.raises(ValueError, match=r"exposure\[1\] is 0 s; allowed: above 0 s"):
        model.assess(TARGET, START, [30.0, 0.0])
    with pytest.raises(ValueError, match="exposure is 0 s; allowed: above 0 s"):
        model.windows(TARGET, START, "2026-08-14T23:59:05Z", 0.0)


def test_the_top_of_the_configuration_gives_defaults(tmp_path):
    config = tmp_path / "streakcast.toml"
    config.write_text('mpc = "X05"\nshells = "starlink-gen1"\nfov = "3deg x 0.5deg"\nrotation = 50.0\ninclude_dark = true\nsamples = 5\n')
    plain = tmp_path / "plain.toml"
    plain.write_text('mpc = "X05"\nshells = "starlink-gen1"\nfov = "3deg x 0.5deg"\n')
    model, other = streakcast.StreakModel(config=config), streakcast.StreakModel(config=plain)
    np.testing.assert_equal(model.assess(TARGET, START, 60.0), other.assess(TARGET, START, 60.0, rotation=50.0))
    turned = other.passes(TARGET, START, 60.0, rotation=50.0, include_dark=True, samples=5, output="dict")
    given = model.passes(TARGET, START, 60.0, output="dict")
    assert set(given) == set(turned) and "samples" in given
    np.testing.assert_array_equal(given["norad_id"], turned["norad_id"])
