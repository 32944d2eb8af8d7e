"""Annotation of opsim databases: added tables, unchanged existing tables."""

import os
import sqlite3
import warnings

import brute_force
import night
import numpy as np
import pytest
import streakcast
from conftest import EVENING
from streakcast import StreakcastWarning
from streakcast_rubin import annotate, visit_columns
from streakcast_rubin._verdicts import sun_altitude_deg


@pytest.fixture(scope="module")
def opsim(folder):
    path = folder / "opsim.db"
    done = night.run(EVENING, "pairs", folder, hours=0.7, filename=str(path))
    return path, done.visits


def rows_of(path, query):
    with sqlite3.connect(path) as base:
        return base.execute(query).fetchall()


def test_a_copy_with_more_tables(opsim, models, truths, tmp_path):
    path, visits = opsim
    before = path.read_bytes()
    crossed = annotate(path, tmp_path / "out.db", models[40768])
    truth = brute_force.streaked(truths[40768], visits)
    assert truth.sum() > 5 and abs(crossed - truth.sum()) <= 1
    assert path.read_bytes() == before
    assert rows_of(tmp_path / "out.db", "SELECT * FROM observations") == rows_of(path, "SELECT * FROM observations")
    joined = rows_of(tmp_path / "out.db", "SELECT n_streaks, brightest_mag, verdict FROM observations_streaks ORDER BY observationId")
    assert len(joined) == len(visits)
    counted = rows_of(tmp_path / "out.db", "SELECT exposure_id, count(*) FROM streaks GROUP BY exposure_id")
    assert sorted(dict(counted).values()) == sorted(count for count, *_ in joined if count)
    assert all((magnitude is None) == (verdict == "clear") for _, magnitude, verdict in joined)
    assert ("time_scale", '"utc"') in rows_of(tmp_path / "out.db", "SELECT * FROM streak_provenance")
    # The visit array of rubin_scheduler gives the same result.
    columns = visit_columns(visits, models[40768])
    assert [int(one) for one in columns["n_streaks"]] == [count for count, *_ in joined]


def test_an_invalid_visit_leaves_the_others(opsim, models):
    visits = opsim[1][:8].copy()
    expected = visit_columns(visits, models[4408])
    visits["RA"][2], visits["mjd"][5], visits["exptime"][6] = np.nan, np.nan, -1.0
    with pytest.warns(StreakcastWarning, match="3 of 8 exposures have numbers missing or out of range, .*; first row 2: ra is NaN deg"):
        found = visit_columns(visits, models[4408].with_options())
    with pytest.raises(TypeError, match="start is float32"):
        visit_columns(visits.astype([(name, "f4" if name == "mjd" else kind) for name, (kind, *_) in visits.dtype.fields.items()]), models[4408])
    assert np.flatnonzero(found["verdict"] == "invalid").tolist() == [2, 5, 6]
    valid = [0, 1, 3, 4, 7]
    assert found["verdict"][valid].tolist() == expected["verdict"][valid].tolist()
    np.testing.assert_array_equal(found["streak_cost_s"][valid], expected["streak_cost_s"][valid])


def test_existing_tables_are_replaced_only_if_requested(opsim, models, tmp_path):
    annotate(opsim[0], tmp_path / "one.db", models[4408])
    with pytest.raises(ValueError, match="already has tables .*streak_flags"):
        annotate(tmp_path / "one.db", tmp_path / "two.db", models[4408])
    assert [one.name for one in tmp_path.iterdir()] == ["one.db"]
    annotate(tmp_path / "one.db", tmp_path / "two.db", models[4408], replace=True)
    query = "SELECT * FROM streak_flags"
    assert rows_of(tmp_path / "one.db", query) == rows_of(tmp_path / "two.db", query)


def test_invalid_databases_are_rejected(opsim, models, tmp_path):
    with pytest.raises(ValueError, match="none.db"):
        annotate(tmp_path / "none.db", tmp_path / "out.db", models[4408])
    (tmp_path / "text.db").write_text("not a database, but long enough that SQLite reads its header " * 11)
    with pytest.raises(ValueError, match="text.db"):
        annotate(tmp_path / "text.db", tmp_path / "out.db", models[4408])
    (tmp_path / "schedule.csv").write_text("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n1,2026-01-15T03:00:00Z,30,10,-30\n")
    with pytest.raises(ValueError, match="schedule.csv is no opsim database"):
        annotate(tmp_path / "schedule.csv", tmp_path / "out.db", models[4408])
    with sqlite3.connect(tmp_path / "poor.db") as base:
        base.execute("CREATE TABLE observations (observationId INTEGER, fieldRA REAL)")
    with pytest.raises(ValueError, match="poor.db"):
        annotate(tmp_path / "poor.db", tmp_path / "out.db", models[4408])
    assert not (tmp_path / "out.db").exists()
    assert not [one for one in tmp_path.iterdir() if one.suffix == ".part"]


def changed(opsim, path, *statements):
    with sqlite3.connect(path) as base, sqlite3.connect(opsim[0]) as full:
        full.backup(base)
        for statement in statements:
            base.execute(statement)
    return path


@pytest.mark.parametrize("column", ["fieldRA", "fieldDec", "observationStartMJD", "visitExposureTime"])
@pytest.mark.parametrize("value", ["NULL", "'unknown'", "9e999", "-9999"])
def test_invalid_visits(opsim, models, tmp_path, column, value):
    """Invalid visits have a verdict; the others are those of the whole database."""
    source = changed(opsim, tmp_path / "in.db", f"UPDATE observations SET {column} = {value} WHERE observationId = 3")
    annotate(source, tmp_path / "out.db", models[4408])
    annotate(opsim[0], tmp_path / "whole.db", models[4408])
    query = "SELECT * FROM streak_flags WHERE exposure_id {} 3 ORDER BY exposure_id"
    assert rows_of(tmp_path / "out.db", query.format("!=")) == rows_of(tmp_path / "whole.db", query.format("!="))
    values = "verdict, n_streaks, brightest_mag, p_any, streak_length_deg, streak_cost_s, reasons IS NULL"
    assert rows_of(tmp_path / "out.db", query.format("=").replace("*", values)) == [("invalid", *[None] * 5, 0)]


def test_a_missing_rotation_or_band_is_no_error(opsim, models, tmp_path):
    source = changed(opsim, tmp_path / "in.db", "UPDATE observations SET rotSkyPos = NULL, band = NULL")
    annotate(source, tmp_path / "out.db", models[4408])
    assert rows_of(tmp_path / "out.db", "SELECT count(*) FROM streak_flags WHERE verdict = 'invalid'") == [(0,)]


def test_repeated_visits(opsim, models, tmp_path):
    """Each row of the observations is one row of the view."""
    repeat = "INSERT INTO observations SELECT * FROM observations WHERE observationId < 5"
    source = changed(opsim, tmp_path / "in.db", repeat)
    before, after = (annotate(one, tmp_path / f"{index}.db", models[4408]) for index, one in enumerate((opsim[0], source)))
    counts = [rows_of(path, f"SELECT count(*) FROM {table}")[0][0] for path, table in
              ((source, "observations"), (tmp_path / "1.db", "observations_streaks"), (tmp_path / "0.db", "streak_flags"), (tmp_path / "1.db", "streak_flags"))]  # fmt: skip
    assert before == after and counts[0] == counts[1] and counts[2] == counts[3]
    other = changed(opsim, tmp_path / "other.db", "UPDATE observations SET observationId = 4 WHERE observationId = 3")
    with pytest.warns(StreakcastWarning, match="1 exposure has the exposure_id of an earlier one"):
        annotate(other, tmp_path / "out.db", models[4408])
    assert rows_of(tmp_path / "out.db", "SELECT name FROM sqlite_master WHERE type = 'view'") == []


def test_an_empty_database(opsim, models, tmp_path):
    with sqlite3.connect(tmp_path / "empty.db") as base, sqlite3.connect(opsim[0]) as full:
        full.backup(base)
        base.execute("DELETE FROM observations")
    with pytest.raises(ValueError, match="empty.db has columns but no exposures"):
        annotate(tmp_path / "empty.db", tmp_path / "out.db", models[4408])


@pytest.mark.parametrize("umask", [0o022, 0o027])
def test_the_copy_has_default_permissions(opsim, models, tmp_path, umask):
    before = os.umask(umask)
    try:
        annotate(opsim[0], tmp_path / "out.db", models[4408])
    finally:
        os.umask(before)
    assert (tmp_path / "out.db").stat().st_mode & 0o777 == 0o666 & ~umask
    assert [one.name for one in tmp_path.iterdir()] == ["out.db"]


@pytest.mark.parametrize(("scale", "count"), [("utc", 0), ("tai", 1)])
def test_the_altitude_of_the_sun_shows_a_wrong_scale(models, scale, count):
    """Altitudes in simulations are those at the times in UTC."""
    mjd = 61_155.0 + np.linspace(0.0, 0.3, 40)
    columns = ("RA", "dec", "rotSkyPos", "mjd", "exptime", "sunAlt")
    visits = np.zeros(len(mjd), dtype=[*((name, float) for name in columns), ("band", "U1")])
    visits["RA"], visits["dec"], visits["mjd"], visits["exptime"], visits["band"] = 3.0, -0.5, mjd, 30.0, "r"
    visits["sunAlt"] = np.radians(sun_altitude_deg(mjd, "utc", models[4408].site))
    for table, expected in ((visits, count), (visits[0:0], 0)):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            assert len(visit_columns(table, models[4408], mjd_scale=scale)["verdict"]) == len(table)
        texts = [str(one.message) for one in caught if "Sun of the visits" in str(one.message)]
        assert len(texts) == expected and all("mjd_scale='utc' agrees" in text for text in texts), texts
    # A visit of another epoch is invalid. At another site no scale agrees.
    visits["mjd"][0] = 1e9
    sydney = streakcast.StreakModel(lat=-33.9, lon=151.2, height=0, shells="starlink-gen1", telescope="rubin")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assert visit_columns(visits, sydney, mjd_scale=scale)["verdict"][0] == "invalid"
    assert any("Sun of the visits" in str(one.message) and "the site, the times or the unit" in str(one.message) for one in caught)
    # Columns that were not filled are not compared.
    visits["sunAlt"] = 0.0
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        visit_columns(visits, models[4408], mjd_scale=scale)
    assert not any("Sun of the visits" in str(one.message) for one in caught)
