"""Methods with earlier names or results."""

import pytest

TARGET, START, END = (198.9, 7.7), "2026-08-14T23:29:05Z", "2026-08-14T23:34:05Z"


def test_renamed_methods_give_the_results_of_the_new_ones(model):
    with pytest.warns(DeprecationWarning, match="^flags is deprecated; use flag$") as caught:
        old = model.flags(TARGET, START, 30.0)
    assert caught[0].filename == __file__
    new = model.flag(TARGET, START, 30.0)
    assert old.colnames == new.colnames and (old["next_clear_start_utc"] == new["next_clear_start_utc"]).all()
    with pytest.warns(DeprecationWarning, match="^clear_windows is deprecated; use windows$"):
        old = model.clear_windows(TARGET, START, END, 30.0, output="dict")
    windows = model.windows(TARGET, START, END, 30.0, output="dict")
    assert len(windows.target) > 0 and all((a == b).all() for a, b in zip(old, windows))


def test_next_clear_start_gives_the_delay(model):
    with pytest.warns(DeprecationWarning, match="use next_start"):
        delay_s = model.next_clear_start(TARGET, START, 30.0)
    assert delay_s == model.flag(TARGET, START, 30.0)["delay_s"][0].value > 0.0


def test_visible_passes_are_those_of_a_forecast_by_day_and_night(model):
    with pytest.warns(DeprecationWarning, match="use forecast"):
        old = model.visible_passes(START, END, min_altitude=20, lit_only=False)
    new = model.forecast(start=START, end=END, min_altitude=20, max_sun_altitude=None, include_dark=True).passes
    assert list(old["norad_id"]) == list(new["norad_id"]) and len(old) > 10
