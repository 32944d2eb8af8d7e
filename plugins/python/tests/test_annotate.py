"""Annotation of schedule files equals that of the command line."""

import csv
import os
import sqlite3
import subprocess
from pathlib import Path

import pytest

import streakcast

SCHEDULE = Path(__file__).parents[3] / "examples" / "night.csv"


@pytest.fixture(scope="module")
def model():
    return streakcast.StreakModel(mpc="X05", shells="starlink-gen1", fov="3.5deg", limit_mag=7, telescope="rubin", mjd_scale="utc")


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def test_a_file_equals_that_of_the_command_line(model, tmp_path):
    binary = os.environ.get("STREAKCAST_BIN") or pytest.fail("set STREAKCAST_BIN, or run plugins/test.sh")
    typed = "--shells starlink-gen1 --mpc X05 --fov 3.5deg --limit-mag 7 --telescope rubin -q".split()
    subprocess.run([binary, "annotate", *typed, "--schedule", SCHEDULE, "-o", tmp_path / "typed.csv"], check=True)
    written = model.annotate(SCHEDULE, tmp_path / "out.csv")
    assert written == [tmp_path / "out.csv", tmp_path / "out.streaks.csv"]
    for name in ("{}.csv", "{}.streaks.csv"):
        ours, theirs = (rows_of(tmp_path / name.format(stem)) for stem in ("out", "typed"))
        assert ours == theirs and len(ours) > 5
    with pytest.raises(streakcast.StreakcastError, match="already has columns"):
        model.annotate(tmp_path / "out.csv", tmp_path / "again.csv")
    model.annotate(tmp_path / "out.csv", tmp_path / "out.csv", replace=True)
    assert rows_of(tmp_path / "out.csv") == rows_of(tmp_path / "typed.csv")


def test_invalid_and_repeated_rows_of_an_opsim_database(model, data, tmp_path):
    source = data / "schedules" / "sample_opsim.db"
    twice = tmp_path / "twice.db"
    with sqlite3.connect(source) as base, sqlite3.connect(twice) as copy:
        base.backup(copy)
        first, second = (row[0] for row in copy.execute("SELECT observationId FROM observations LIMIT 2").fetchall())
        copy.execute("INSERT INTO observations SELECT * FROM observations WHERE observationId = ?", (second,))
        copy.execute("UPDATE observations SET fieldRA = NULL WHERE observationId = ?", (first,))
    model.annotate(source, tmp_path / "once.db")
    with pytest.warns(streakcast.StreakcastWarning, match=f"1 exposure is invalid; first '?{first}'?: right ascension is missing"):
        model.annotate(twice, tmp_path / "out.db")

    def table(path, query):
        with sqlite3.connect(path) as base:
            return base.execute(query, (first,) if "?" in query else ()).fetchall()

    assert table(tmp_path / "out.db", "SELECT verdict, n_streaks FROM streak_flags WHERE exposure_id = ?") == [("invalid", None)]
    others = "SELECT * FROM streak_flags WHERE exposure_id <> ?"
    assert table(tmp_path / "out.db", others) == table(tmp_path / "once.db", others)
    counts = [table(tmp_path / "out.db", f"SELECT count(*) FROM {name}")[0][0] for name in ("observations", "observations_streaks", "streak_flags")]
    assert counts[0] == counts[1] == counts[2] + 1
    # Numbers of a file that does not state a scale need one.
    without = streakcast.StreakModel(mpc="X05", shells="starlink-gen1", fov="3.5deg")
    with pytest.raises(streakcast.StreakcastError, match="time scale"):
        without.annotate(source, tmp_path / "none.db")


def test_next_starts_are_those_of_the_flags(model):
    from astropy.time import Time

    target, start = ([198.9, 190.9], [7.7, -27.9]), "2026-08-14T23:29:05Z"
    flags = model.flag(target, start, 30.0)
    for rule in ("clear", "acceptable"):
        starts = model.next_start(target, start, 30.0, rule=rule)
        assert isinstance(starts, Time) and (starts == flags[f"next_{rule}_start_utc"]).all()
        arrays = model.next_start(target, start, 30.0, rule=rule, output="dict")
        assert arrays.dtype == "datetime64[ns]" and (arrays == starts.datetime64).all()
    assert model.next_start((198.9, 7.7), start, 30.0).shape == ()
    with pytest.raises(ValueError, match="rule is 'any'; allowed: clear, acceptable"):
        model.next_start((198.9, 7.7), start, 30.0, rule="any")
