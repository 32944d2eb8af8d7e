"""Results of a survey on a cluster equal those on one machine, also if workers are killed."""

import os
import signal
import sqlite3
import sys
import threading
import time
import warnings

import numpy as np
import pytest

import streakcast
import streakcast.dask

from survey import year

distributed = pytest.importorskip("distributed")

NIGHTS, EACH = 24, 60


@pytest.fixture(scope="module")
def visits():
    """Returns visits after dusk at Cerro Pachon, in a strip of the sky, on every 15th day of a year."""
    generator = np.random.default_rng(20260814)
    night, number = np.divmod(np.arange(NIGHTS * EACH), EACH)
    # The fraction 0.97 of a UTC day is 23:17 UTC. Sidereal time increases by about one degree per day.
    start = 61_240.97 + 15 * night + number * 34 / 86_400
    return {
        "ra_deg": (175.0 + 15 * night * 0.98565 + generator.uniform(0, 30, len(night))) % 360,
        "dec_deg": generator.uniform(-60, 0, len(night)),
        "start": start,
        "exposure_s": np.full(len(night), 30.0),
        "band": generator.choice(np.array(["g", "r", "i"]), len(night)),
    }


@pytest.fixture(scope="module")
def survey_model():
    return streakcast.StreakModel(
        mpc="X05", shells="starlink-gen1", telescope="rubin", limit_mag={"g": 7, "default": 6}, mjd_scale="utc"
    )


def same(result, expected):
    assert (result["visit"] == np.arange(len(expected.verdict))).all()
    assert (result["verdict"] == np.ravel(expected.verdict)).all()
    for name in ("n_streaks", "brightest_mag", "lost_fraction", "p_any", "streak_length_deg"):
        # Results are bit-identical, because whole nights are computed in both cases.
        np.testing.assert_array_equal(result[name], getattr(expected, name), err_msg=name)


def kill_a_worker(client, folder, after):
    """Kills a worker after some nights are complete. Returns an event that is set when this is done."""
    victim = next(iter(client.run(os.getpid).values()))
    killed = threading.Event()

    def watch():
        while len(list(folder.glob("night-*.parquet"))) < after:
            threading.Event().wait(0.005)
        os.kill(victim, signal.SIGKILL)
        killed.set()

    threading.Thread(target=watch, daemon=True).start()
    return killed


def test_verif_a_killed_worker_does_not_change_the_results(visits, survey_model, tmp_path):
    expected = survey_model.assess(
        (visits["ra_deg"], visits["dec_deg"]), visits["start"], visits["exposure_s"], band=visits["band"]
    )
    assert 50 < expected.n_streaks.sum() < NIGHTS * EACH
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        killed = kill_a_worker(client, tmp_path, NIGHTS // 3)
        files = streakcast.dask.annotate(visits, survey_model, client, tmp_path)
        assert killed.is_set() and len(files) == NIGHTS
        same(streakcast.dask.read(files), expected)
        assert sorted(tmp_path.iterdir()) == sorted(files)

        # A second run computes only missing and invalid files.
        written = {path: path.stat().st_mtime_ns for path in files}
        files[3].unlink()
        files[5].write_bytes(b"half of a file")
        (tmp_path / f".{files[7].name}.killed").write_bytes(b"partial file of a killed worker")
        again = streakcast.dask.annotate(visits, survey_model, client, tmp_path)
        same(streakcast.dask.read(again), expected)
        assert sorted(tmp_path.iterdir()) == sorted(files)
        assert {path for path in files if path.stat().st_mtime_ns != written[path]} == {files[3], files[5]}
        other = streakcast.dask.annotate(visits, survey_model.with_options(limit_mag=5), client, tmp_path)
        assert all(path.stat().st_mtime_ns != written[path] for path in other)


def test_workers_read_elements_from_their_path(data, visits, tmp_path):
    few = {name: column[: 3 * EACH] for name, column in visits.items()}
    # Dates and right ascensions are moved from summer to the week of the element sets.
    few["start"] = few["start"] - 85.0
    few["ra_deg"] = (few["ra_deg"] - 85.0 * 0.98565) % 360.0
    elements = data / "tle" / "active" / "active_2026-04-25.txt"
    model = streakcast.StreakModel(
        mpc="X05", elements=str(elements), telescope="rubin", limit_mag={"g": 7, "default": 6}, mjd_scale="utc"
    )
    expected = model.assess((few["ra_deg"], few["dec_deg"]), few["start"], few["exposure_s"], band=few["band"])
    assert expected.n_streaks.sum() > 10
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        files = streakcast.dask.annotate(few, model, client, tmp_path)
        assert len(files) == 3
        same(streakcast.dask.read(files), expected)


def test_a_growing_survey_with_streaks_next_starts_and_warnings(visits, tmp_path):
    growth = tmp_path / "growth.toml"
    growth.write_text(
        "[[period]]\nfrom = 2026-07-19\nshells = { starlink-gen1 = 0.5 }\n"
        "[[period]]\nfrom = 2026-08-20\nshells = { starlink-gen1 = 1.0, oneweb = 1.0 }\n"
    )
    model = streakcast.StreakModel(mpc="X05", shells=str(growth), telescope="rubin", limit_mag=6, mjd_scale="utc")
    few = {name: column[: 4 * EACH] for name, column in visits.items()}
    pointing, start, exposure_s = (few["ra_deg"], few["dec_deg"]), few["start"], few["exposure_s"]
    with pytest.warns(streakcast.StreakcastWarning):
        flags = model.flag(pointing, start, exposure_s, band=few["band"], output="dict")
    passes = model.passes(pointing, start, exposure_s, band=few["band"], output="dict")
    assert sorted(model.satellites(night, scale="utc") for night in start[:: 3 * EACH]) == [2204, 4408 + 6372]
    # The columns of Rubin's opsim databases. A visit of two snaps lasts visitTime.
    opsim = {"fieldRA": few["ra_deg"], "fieldDec": few["dec_deg"], "observationStartMJD": start, "filter": few["band"]}
    opsim |= {"visitExposureTime": exposure_s, "visitTime": exposure_s + 4.0, "numExposures": np.ones(len(start))}
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        for _ in range(2):
            with pytest.warns(streakcast.StreakcastWarning) as issued:
                files = streakcast.dask.annotate(
                    opsim, model, client, tmp_path / "nights", streaks=True, next_starts=True
                )
            # One warning for all nights, also if they are not computed again.
            texts = [str(one.message) for one in issued if "simulated constellation" in str(one.message)]
            assert len(texts) == 2 and all("of 4 nights)" in text for text in texts), texts
        assert len(files) == 4
        result, streaks = streakcast.dask.read(files), streakcast.dask.read_streaks(files)
        opsim["numExposures"] = np.full(len(start), 2)
        longer = streakcast.dask.read(streakcast.dask.annotate(opsim, model, client, tmp_path / "nights"))
    assert result["verdict"].tolist() == flags["verdict"].tolist()
    np.testing.assert_array_equal(result["next_clear_start_utc"], flags["next_clear_start_utc"])
    assert [list(one) for one in result["norad_ids"]] == [list(one) for one in flags["norad_ids"]]
    assert streaks["visit"].tolist() == passes["exposure_id"].tolist() and len(streaks["visit"]) > 10
    np.testing.assert_array_equal(streaks["magnitude_peak"], passes["magnitude_peak"])
    lengths = model.assess(pointing, start, exposure_s + 4.0, band=few["band"]).streak_length_deg
    np.testing.assert_array_equal(longer["streak_length_deg"], lengths)
    costs_s = model.assess(pointing, start, exposure_s + 4.0, band=few["band"]).streak_cost_s
    np.testing.assert_allclose(longer["streak_cost_s"], costs_s * exposure_s / (exposure_s + 4.0))


def test_periods_with_element_sets_of_their_own(data, visits, tmp_path):
    """They are files of the model: a changed one is read again."""
    source = data / "tle" / "active" / "active_2026-04-25.txt"
    lines = source.read_text().splitlines(keepends=True)[3000:3300]
    (tmp_path / "sets").mkdir()
    (tmp_path / "sets" / "few.tle").write_text("".join(lines))
    growth = tmp_path / "growth.toml"
    growth.write_text(
        "[[period]]\nfrom = 2026-04-01\nelements = 'sets/few.tle'\n[[period]]\nfrom = 2026-08-20\nshells = { oneweb = 1 }\n"
    )
    setup = {"mpc": "X05", "shells": str(growth), "telescope": "rubin", "mjd_scale": "utc"}
    model = streakcast.StreakModel(**setup)
    assert [model.satellites(night) for night in (61_157.2, 61_290.2)] == [100, 6372]
    both = streakcast.StreakModel(**setup, elements=str(source))
    assert both.satellites(61_157.2) == 100 and both.satellites(61_290.2) > 10_000 + 6372
    few = {name: column[:EACH] for name, column in visits.items()} | {"start": 61_157.98 + np.arange(EACH) / 2_000}
    pointing = few["ra_deg"], few["dec_deg"]
    expected = streakcast.StreakModel(**{**setup, "shells": None}, elements=str(tmp_path / "sets" / "few.tle"))
    expected = expected.assess(pointing, few["start"], few["exposure_s"], band=few["band"])
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        same(streakcast.dask.read(streakcast.dask.annotate(few, model, client, tmp_path / "nights")), expected)
    (tmp_path / "sets" / "few.tle").write_text("".join(lines[:150]))
    assert model.changed_files() == [str(tmp_path / "sets" / "few.tle")]
    assert model.reloaded().satellites(61_157.2) == 50
    (tmp_path / "sets" / "few.tle").unlink()
    with pytest.raises(streakcast.SetupError, match="few.tle"):
        streakcast.StreakModel(**setup)


def test_without_pyarrow(visits, survey_model, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    for call in (
        lambda: streakcast.dask.annotate(visits, survey_model, None, tmp_path),
        lambda: streakcast.dask.read([tmp_path / "night-1.parquet"]),
        lambda: streakcast.dask.read_streaks([tmp_path / "night-1.parquet"]),
    ):
        with pytest.raises(ImportError, match="requires pyarrow.*pip install pyarrow"):
            call()


def test_quiet_nights_invalid_visits_unknown_positions_and_units(data, visits, tmp_path):
    few = {name: column[: 5 * EACH].copy() for name, column in visits.items()}
    # The sets of April are too old for the nights of July to September; the constellation begins later.
    growth = tmp_path / "growth.toml"
    growth.write_text(
        "[[period]]\nfrom = 2026-07-19\nshells = {}\n[[period]]\nfrom = 2026-08-20\nshells = { starlink-gen1 = 1.0 }\n"
    )
    grown = streakcast.StreakModel(mpc="X05", shells=str(growth), telescope="rubin", limit_mag=6, mjd_scale="utc")
    few["rotation_deg"] = np.zeros(5 * EACH)
    broken = {"ra_deg": (3, np.nan), "dec_deg": (64, -99.0), "start": (70, np.nan), "exposure_s": (130, 0.0)}
    broken |= {"rotation_deg": (150, np.nan)}
    for name, (row, value) in broken.items():
        few[name][row] = value
    few["start"][0] = -9999.0
    invalid = [0, 3, 64, 70, 130]
    valid = np.setdiff1d(np.arange(5 * EACH), invalid)
    pointing = few["ra_deg"][valid], few["dec_deg"][valid]
    expected = grown.assess(pointing, few["start"][valid], few["exposure_s"][valid], band=few["band"][valid])
    old = streakcast.StreakModel(
        mpc="X05", elements=str(data / "tle" / "active" / "active_2026-04-25.txt"), telescope="rubin", mjd_scale="utc"
    )
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        options = {"streaks": True, "next_starts": True}
        with pytest.warns(streakcast.StreakcastWarning, match="5 of 300 visits have numbers missing or out of range, and are invalid; first row 0: time"):
            files = streakcast.dask.annotate(few, grown, client, tmp_path / "grown", **options)
        flags, streaks = streakcast.dask.read(files), streakcast.dask.read_streaks(files)
        assert np.flatnonzero(flags["verdict"] == "invalid").tolist() == invalid
        assert all("allowed" in flags["reasons"][row][0] for row in invalid), flags["reasons"][invalid]
        # The first nights have no satellites.
        assert (flags["verdict"][valid] == expected.verdict).all() and len(streaks["visit"]) > 3
        assert streaks["visit"].min() >= 3 * EACH
        # Columns of the last run: its streaks are not those of the run before.
        files = streakcast.dask.annotate(few, grown.with_options(limit_mag=5), client, tmp_path / "grown")
        with pytest.raises(ValueError, match="has no streaks of the same run"):
            streakcast.dask.read_streaks(files)
        # Positions are unknown.
        late = {name: column[4 * EACH :] + (300.0 if name == "start" else 0) if name != "band" else column[4 * EACH :] for name, column in few.items()}
        files = streakcast.dask.annotate(late, old, client, tmp_path / "old", streaks=True)
        assert set(streakcast.dask.read(files)["verdict"]) <= {"unknown", "invalid"}
        assert len(streakcast.dask.read_streaks(files)["visit"]) == 0
        # Units of a table with the columns of opsim.
        from astropy import units as u
        from astropy.table import QTable

        table = QTable({"fieldRA": few["ra_deg"][valid] * u.deg, "fieldDec": few["dec_deg"][valid] * u.deg})
        table["observationStartMJD"] = few["start"][valid]
        table["visitExposureTime"] = few["exposure_s"][valid] / 60 * u.min
        table["visitTime"], table["numExposures"] = 1.0 * u.min, np.ones(len(valid), dtype=int)
        table["band"] = few["band"][valid]
        result = streakcast.dask.read(streakcast.dask.annotate(table, grown, client, tmp_path / "units"))
    np.testing.assert_array_equal(result["streak_length_deg"], expected.streak_length_deg)
    with pytest.raises(TypeError, match="ra_deg contains '12h30m'; allowed: numbers"):
        texts = np.full(len(few["ra_deg"]), "12h30m", dtype=object)
        streakcast.dask.annotate({**few, "ra_deg": texts}, grown, None, tmp_path)
    without = {name: column for name, column in few.items() if name != "exposure_s"}
    with pytest.raises(ValueError, match="missing columns of visits exposure_s"):
        streakcast.dask.annotate({**without, "visitTime": few["start"], "numExposures": few["start"]}, grown, None, tmp_path)


@pytest.mark.parametrize("name", ["numExposures", "nexp", None])
def test_visits_of_several_snaps_last_as_in_databases(visits, survey_model, tmp_path, name):
    """The same rows through `StreakModel.annotate`."""
    model = survey_model.with_options(policy={"max_cost_s": 2.1})
    cells = [(30.0, 34.0, 1), (30.0, 300.0, 2), (30.0, 34.0, None), (30.0, 34.0, 0), (30.0, None, 2), (30.0, 29.0, 2)]
    cells += [(30.0, None, None), (30.0, 20.0, None), (30.0, -1.0, None), (30.0, -1.0, 1), (30.0, 34.0, -1), (0.0, 34.0, 0), (None, 34.0, 2)]
    open_s, visit_s, snaps = ([row[column] for row in cells] * 12 for column in range(3))
    count = len(open_s)
    opsim = {"observationId": np.arange(count), "fieldRA": visits["ra_deg"][:count], "fieldDec": visits["dec_deg"][:count]}
    opsim |= {"observationStartMJD": visits["start"][:count], "band": visits["band"][:count]}
    opsim |= {"visitExposureTime": open_s, "visitTime": visit_s} | ({name: snaps} if name else {})
    path = tmp_path / "opsim.db"
    with sqlite3.connect(path) as base:
        base.execute(f"CREATE TABLE observations ({', '.join(opsim)})")
        rows = zip(*(column.tolist() if hasattr(column, "tolist") else column for column in opsim.values()))
        base.executemany(f"INSERT INTO observations VALUES ({', '.join('?' * len(opsim))})", rows)
    model.annotate(path, tmp_path / "annotated.db")
    with sqlite3.connect(tmp_path / "annotated.db") as base:
        names = "verdict, streak_length_deg, streak_cost_s"
        expected = base.execute(f"SELECT {names} FROM streak_flags ORDER BY CAST(exposure_id AS INTEGER)").fetchall()
    # The cost of streaks in all of `visitTime` would be ten times as large, and most of these visits `avoid`.
    assert name is None or [verdict for (verdict, *_), snap in zip(expected, snaps) if snap == 2].count("streaked") > 2
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        table = {key: np.array(column, dtype=object) if key in (name, "visitExposureTime", "visitTime") else column for key, column in opsim.items()}
        found = streakcast.dask.read(streakcast.dask.annotate(table, model, client, tmp_path / "nights"))
    assert found["verdict"].tolist() == [verdict for verdict, *_ in expected]
    for index, column in ((1, "streak_length_deg"), (2, "streak_cost_s")):
        np.testing.assert_allclose(found[column], [np.nan if row[index] is None else row[index] for row in expected], atol=1e-3)


def test_all_columns_are_documented():
    names = {"visit", *streakcast.Assessment._fields} - {"crosses"}
    assert [name for name in names if f"``{name}``" not in streakcast.dask.annotate.__doc__] == []


def test_invalid_surveys_are_rejected(visits, survey_model, tmp_path):
    with pytest.raises(ValueError, match="missing columns of visits exposure_s"):
        fewer = {name: column for name, column in visits.items() if name != "exposure_s"}
        streakcast.dask.annotate(fewer, survey_model, None, tmp_path)
    with pytest.raises(ValueError, match="differ in length"):
        streakcast.dask.annotate({**visits, "ra_deg": visits["ra_deg"][:-1]}, survey_model, None, tmp_path)
    with pytest.raises(TypeError, match="scale"):
        streakcast.dask.annotate(visits, survey_model.with_options(mjd_scale=None), None, tmp_path)
    with pytest.raises(TypeError, match="client is of the type NoneType; allowed: a distributed.Client"):
        streakcast.dask.annotate(visits, survey_model, None, tmp_path)
    with pytest.raises(ValueError, match="there are no visits"):
        streakcast.dask.annotate({name: column[:0] for name, column in visits.items()}, survey_model, None, tmp_path)
    with pytest.raises(ValueError, match="there are no files"):
        streakcast.dask.read([])
    with pytest.raises(ValueError, match="opsim's fieldRA, fieldDec, observationStartMJD, visitExposureTime"):
        streakcast.dask.annotate({"fieldDec": visits["dec_deg"]}, survey_model, None, tmp_path)


def test_times_of_opsim_in_another_scale_are_noticed(visits, survey_model, tmp_path):
    names = {"ra_deg": "fieldRA", "dec_deg": "fieldDec", "start": "observationStartMJD", "exposure_s": "visitExposureTime"}
    few = {name: visits[column][:2] for column, name in names.items()}
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        for scale, expected in (("utc", 0), ("tai", 1)):
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                files = streakcast.dask.annotate(few, survey_model, client, tmp_path / scale, scale=scale)
            texts = [str(one.message) for one in caught if "observationStartMJD in UTC, but it is read as tai" in str(one.message)]
            assert len(texts) == expected
            starts = streakcast.dask.read(files)["start_mjd_tai"]
            np.testing.assert_allclose(starts - few["observationStartMJD"], (0.0 if expected else 37.0) / 86_400.0, atol=1e-9)


@pytest.mark.skipif("STREAKCAST_SLOW" not in os.environ, reason="a year takes minutes; STREAKCAST_SLOW=1 runs it")
def test_verif_a_year_on_a_cluster_equals_the_year_on_one_machine(data, survey_model, tmp_path, capsys):
    visits = year(data)
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        killed = kill_a_worker(client, tmp_path, 180)
        begin = time.perf_counter()
        files = streakcast.dask.annotate(visits, survey_model, client, tmp_path)
        over_cluster_s = time.perf_counter() - begin
    assert killed.is_set() and len(files) == 365
    begin, begin_cpu = time.perf_counter(), time.process_time()
    pointing = (visits["ra_deg"], visits["dec_deg"])
    rest = dict(rotation=visits["rotation_deg"], band=visits["band"])
    expected = survey_model.assess(pointing, visits["start"], visits["exposure_s"], **rest)
    with capsys.disabled():
        print(
            f"\n{len(visits['start'])} visits, {expected.n_streaks.sum()} streaks: {over_cluster_s:.0f} s over two workers, "
            f"{time.perf_counter() - begin:.0f} s on one machine ({time.process_time() - begin_cpu:.0f} s of processors)"
        )
    same(streakcast.dask.read(files), expected)
