"""Elements that are too old: verdicts are unknown, other requests are errors, and hooks count them."""

import logging

import numpy as np
import pytest

import streakcast
from streakcast.hosts import Hook

from test_hosts import elements, write

TARGET = (198.9, 7.7)
FRESH, OLD = "2026-08-14T23:29:05Z", "2029-08-14T23:29:05Z"
REASON = "elements 1096 days old: positions unknown"


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "elements.tle"
    write(path, elements(20))
    return streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg", limit_mag=7)


@pytest.mark.filterwarnings("ignore::streakcast.StreakcastWarning")
def test_verdicts_are_unknown(model):
    both = model.assess(TARGET, [FRESH, OLD], 30.0)
    assert both.verdict[0] != "unknown" and both.verdict[1] == "unknown"
    assert np.isfinite(both.p_any[0]) and np.isnan(both.p_any[1]) and np.isnan(both.p_crossing[1])
    assert abs(both.elements_age_days[1] - 1096.5) < 0.6
    assert np.isfinite(both.late_s[0]) and np.isnan(both.late_s[1])
    flags = model.flag(TARGET, [FRESH, OLD], 30.0, output="dict")
    assert list(flags["verdict"])[1] == "unknown" and REASON in str(flags["reasons"][1])
    assert abs(float(flags["elements_age_days"][1]) - 1096.5) < 0.6
    assert np.isfinite(flags["late_s"][0]) and np.isnan(flags["late_s"][1])


@pytest.mark.filterwarnings("ignore::streakcast.StreakcastWarning")
def test_other_requests_raise(model):
    for request in (
        lambda: model.passes(TARGET, OLD, 30.0),
        lambda: model.forecast("2029-08-14"),
        lambda: model.overhead(OLD),
    ):
        with pytest.raises(streakcast.UnknownPositionsError, match="days old: positions unknown"):
            request()


@pytest.mark.filterwarnings("ignore::streakcast.StreakcastWarning")
def test_hooks_count_and_log_once(model, caplog):
    hook = Hook(model, "test")
    with caplog.at_level(logging.WARNING, logger="streakcast.test"):
        for _ in range(3):
            assert hook.evaluate(lambda one: one.passes(TARGET, OLD, 30.0), "open") == "open"
    assert (hook.counts["unknown"], hook.counts["failed"]) == (3, 0)
    lines = [record.getMessage() for record in caplog.records if "positions unknown" in record.getMessage()]
    assert len(lines) == 1 and "counted as 'unknown'" in lines[0]


@pytest.mark.filterwarnings("ignore::streakcast.StreakcastWarning")
def test_unjudged_exposures_have_no_number_of_streaks(model):
    below = (18.9, 81.0)  # Never above the horizon of the site.
    assert model.assess(below, FRESH, 30.0).verdict == "invalid"
    for target, start in ((TARGET, OLD), (below, FRESH)):
        one = model.assess(target, start, 30.0)
        assert one.n_streaks is None and one.crosses is None
        flags = model.flag(target, start, 30.0)
        assert flags["n_streaks"].mask.all()
    both = model.assess(TARGET, [FRESH, OLD], 30.0)
    assert both.n_streaks.mask.tolist() == both.crosses.mask.tolist() == [False, True]
    lengths, streaks = model.check_pointings([TARGET[0], below[0]], [TARGET[1], below[1]], [61266.0, 61266.9785], 30.0, scale="utc")
    assert lengths[1] == 0.0 and streaks[1] == 0 and not np.ma.is_masked(streaks)
    lengths, streaks = model.check_pointings([TARGET[0]], [TARGET[1]], [62362.9785], 30.0, scale="utc")
    assert np.isnan(lengths[0]) and np.ma.is_masked(streaks)
