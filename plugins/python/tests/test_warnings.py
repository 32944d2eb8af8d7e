"""Warnings have one line, and point to the line of the caller."""

import inspect
import itertools
import pickle
import warnings

import numpy as np
import pytest
from astropy.time import Time

import streakcast
from conftest import START, TARGET
from streakcast import _state
from streakcast.hosts import Hook
from test_quantities import frame_header

END = "2026-08-14T23:39:05Z"
FRAME = np.zeros((100, 100), "float32")


def new_model(number=itertools.count()):
    """Returns a model at another site each time: models of one sky share the warnings that are already issued."""
    lon = -70.75 + 1e-6 * next(number)
    return streakcast.StreakModel(lat=-30.24, lon=lon, height=2663, shells="starlink-gen1", telescope="rubin", limit_mag=7)


def inject_random_streaks():
    return streakcast.inject(
        FRAME, header=frame_header(), start=START, exposure=30.0, random_streaks=1, magnitude=5.0, zero_point=25.0, seeing="10arcmin",
    )  # fmt: skip


def caught(call):
    """Returns the warnings of a call, in which each filter is off."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        call()
    return [one for one in found if issubclass(one.category, streakcast.StreakcastWarning)]


CALLS = {
    "assess": lambda model: model.assess(TARGET, START, 30.0),
    "flag": lambda model: model.flag(TARGET, START, 30.0),
    "passes": lambda model: model.passes(TARGET, START, 30.0),
    "next_start": lambda model: model.next_start(TARGET, START, 30.0),
    "windows": lambda model: model.windows(TARGET, START, END, 30.0),
    "check_pointings": lambda model: model.check_pointings([198.9], [7.7], [61266.978], 30.0, scale="utc"),
    "forecast": lambda model: model.forecast(start=START, end=END),
    "forecast by day": lambda model: model.forecast(start=START, end=END, max_sun_altitude=None),
    "overhead": lambda model: model.overhead(START),
    "ephemeris": lambda model: model.ephemeris(START, norad=900003951),
    "identify": lambda model: model.identify(place=TARGET, position_angle=45.0, start=START, exposure=30.0),
    "StreakModel.inject": lambda model: model.inject(
        FRAME, header=frame_header(), start=START, exposure=30.0, zero_point=25.0, seeing="10arcmin"
    ),
    "inject": lambda model: inject_random_streaks(),
}


@pytest.mark.parametrize("name", CALLS)
def test_warnings_point_to_the_caller(name):
    model, call = new_model(), CALLS[name]
    found = caught(lambda: call(model))
    assert found
    where = inject_random_streaks if name == "inject" else call
    lines, first = inspect.getsourcelines(where)
    for one in found:
        assert one.filename == __file__
        assert first <= one.lineno < first + len(lines)
        assert "\n" not in str(one.message)


def test_a_warning_with_other_numbers_is_not_repeated():
    model = new_model()
    model._open()[0].news()
    calls = [["3 of 9,000 old", "3 of 8 old", "starlink-gen1 is old"], ["4 of 9,001 old"], ["4 of 9,002 old", "starlink-gen2 is old"]]
    found = caught(lambda: [model._warn_once(warnings_of_call) for warnings_of_call in calls])
    # Different warnings of one call, and names with other digits, are not omitted.
    assert [str(one.message) for one in found] == [*calls[0], calls[2][1]]


def test_warnings_about_frames_are_issued_for_each_call():
    """All frames in memory have the same name."""
    model, shot = new_model(), dict(header=frame_header(), start=START, exposure=30.0)
    early = frame_header()
    early.update({"DATE-OBS": START[:-1], "TIMESYS": "UTC", "EXPTIME": 30.0, "UT": "23:29:02"})
    calls = {
        "more than half of the pixels": lambda: model.mask(FRAME, width="10deg", **shot),
        "the gain is unknown": lambda: model.measure(FRAME, seeing="10arcmin", **shot),
        "UT": lambda: model.identify(frame=FRAME, header=early, pixels=((10, 10), (90, 90))),
    }
    for words, call in calls.items():
        first, second = ([str(one.message) for one in caught(call)] for _ in range(2))
        # Warnings about the elements are issued once.
        assert [message for message in first if "simulated" not in message] == second, (first, second)
        assert any(words in message for message in second), (words, second)


def test_warnings_of_many_nights_are_merged():
    model = new_model()
    model._open()[0].news()
    nights = [f"30{night % 10} of 15,834 old (the farthest by {night}.5 days)" for night in range(10, 23)]
    found = caught(lambda: [model._warn_once(nights) for _ in range(2)])
    assert [str(one.message) for one in found] == [f"{nights[0]} (and 12 similar warnings, with other numbers or dates)"]


def test_names_in_warnings_differ():
    without = _state.without_numbers
    assert without("3 of 1,234 records, the farthest by 4.5 days (2026-10-01)") == "# of #### records, the farthest by # days (date)"
    assert without("at 2026-10-01T12:30:00Z") == without("at 2026-10-02T09:00:00Z") == "at date"
    assert without("constellation starlink-gen1 (4,408 satellites)") == "constellation starlink-gen1 (#### satellites)"
    assert without("STARLINK-1008 is old") == "STARLINK-1008 is old"
    # A large change is a new warning.
    assert without("3 of 9,000 old") != without("8,900 of 9,000 old") and without("1.2 %") != without("45.0 %")
    assert without("brdf:starlink-v1.5") == "brdf:starlink-v1.5"


def test_a_warning_of_changed_files_points_to_the_caller(tmp_path):
    path = tmp_path / "site.toml"
    path.write_text('site = "Rubin Observatory"\n')
    model = streakcast.StreakModel(config=path, shells="starlink-gen1", fov="3.5deg", on_changed_file="warn")
    pickled = pickle.dumps(model)
    path.write_text('site = "Rubin Observatory"\nmag_system = "AB"\n')
    found = caught(lambda: pickle.loads(pickled).site)
    assert [one.filename for one in found] == [__file__] and "changed since" in str(found[0].message)


def test_a_handler_receives_the_warnings_of_an_injection():
    hook = Hook(new_model(), "test")
    assert caught(lambda: hook.evaluate(CALLS["StreakModel.inject"], None)) == []
    assert hook.counts["warned"] >= 1 and hook.counts["failed"] == 0


def test_bands_without_a_limit_are_named():
    model = streakcast.StreakModel(mpc="X05", shells="starlink-gen1", telescope="rubin", limit_mag={"g": 9, "r": 8})
    for band, expected in ((None, "none"), ("gg", "gg"), (["g", "r"], None)):
        found = [str(one.message) for one in caught(lambda: model.assess(([198.9] * 2, [7.7] * 2), START, 30.0, band=band))]
        of_bands = [message for message in found if "no value for band" in message]
        assert of_bands == ([] if expected is None else [f"limit_mag of the policy has no value for band {expected} and no default"])


def test_delays_and_windows_use_the_limit_of_the_band():
    limits = dict(shells="starlink-gen1", telescope="rubin", limit_mag={"g": -20, "r": 20})
    model = streakcast.StreakModel(mpc="X05", **limits)
    starts = {band: model.next_start(TARGET, START, 30.0, rule="acceptable", band=band) for band in ("g", "r")}
    # No satellite is brighter than magnitude -20; one fainter than 20 does not cross.
    assert starts["g"] == Time(START) and starts["r"] > Time(START)
    without = streakcast.StreakModel(mpc="X05", **limits)
    found = [str(one.message) for one in caught(lambda: without.windows(TARGET, START, END, 30.0, band="gg"))]
    assert any("no value for band gg" in message for message in found), found


def test_the_height_of_the_site_is_named_in_errors():
    with pytest.raises(ValueError, match="^height_m is nan"):
        streakcast.sky_map("v2mini", sun_altitude=-14, lat=-30, lon=-70, height_m=np.nan)
