"""Results compared with the JSON output of the command line program."""

import csv
import json
import math
import os
import subprocess
from decimal import Decimal

import numpy as np
import pytest

from conftest import ROOT, START, TARGET
import streakcast

ARGUMENTS = ["--shells", "starlink-gen1", "--mpc", "X05", "--telescope", "rubin", "--fov", "3.5deg"]
#: Columns that are compared as text. Numbers of the command line are rounded to the decimals of their column.
TEXT_COLUMNS = {"name", "international_designator", "illumination", "band", "mag_system", "mag_source", "verdict"}


def same(result, printed):
    """Returns True if two values agree to half of the last digit printed by the command line program."""
    if printed is None:
        return result is None or (isinstance(result, float) and math.isnan(result)) or result is np.ma.masked
    if isinstance(printed, Decimal):
        return abs(float(result) - float(printed)) <= 0.5 * 10.0 ** printed.as_tuple().exponent * (1 + 1e-9)
    return result == printed


def test_verif_passes(model, command_line):
    answer = command_line(
        "passes", *ARGUMENTS, "--start", START, "--exposure", "30s", "--ra", str(TARGET[0]), f"--dec={TARGET[1]}", "--limit-mag", "7"
    )
    result = model.passes(TARGET, START, 30.0)
    printed = answer["passes"]
    assert len(printed) > 0
    assert len(result) == len(printed)
    for row, expected in zip(result, printed):
        for name, value in expected.items():
            if name in ("exposure_id", "chords", "lit_chords"):
                continue
            cell = row[name]
            if name.endswith("_utc"):
                assert cell.isot + "Z" == value
                continue
            cell = cell.value if hasattr(cell, "unit") else cell
            if name in TEXT_COLUMNS:
                assert (str(cell) or None) == (value or None), name
            else:
                assert same(cell, value), (name, cell, value)
        for name in ("chords", "lit_chords"):
            assert len(row[name]) == len(expected[name])
            assert same(row[name][0]["enter_s"], expected[name][0]["enter_s"])


def test_verif_flags(model, command_line):
    schedule = ROOT / "examples" / "night.csv"
    answer = command_line("flag", *ARGUMENTS, "--schedule", str(schedule), "--limit-mag", "7")
    lines = [line for line in schedule.read_text().splitlines() if not line.startswith("#")]
    cells = list(csv.DictReader(lines))
    starts, bands = [row["start_utc"] for row in cells], [row["band"] for row in cells]
    ra, dec, exposure = (np.array([float(row[name]) for row in cells]) for name in ("ra_deg", "dec_deg", "duration_s"))
    day = streakcast.StreakModel(mpc="X05", shells="starlink-gen1", telescope="rubin", fov="3.5deg", limit_mag=7, epoch=starts[0])
    result = day.flag((ra, dec), starts, exposure, band=bands)
    printed = answer["flags"] if "flags" in answer else answer["exposures"]
    assert len(result) == len(printed) == len(cells)
    fast = day.assess((ra, dec), starts, exposure, band=bands)
    assert {row["verdict"] for row in printed} >= {"clear", "avoid"}
    for index, (row, expected) in enumerate(zip(result, printed)):
        assert row["verdict"] == expected["verdict"] == fast.verdict[index]
        assert row["n_streaks"] == expected["n_streaks"] == fast.n_streaks[index]
        assert list(row["reasons"]) == list(expected["reasons"])
        assert list(row["norad_ids"]) == list(expected["norad_ids"])
        for ours_name, name in [
            ("brightest_mag", "brightest_mag"),
            ("lost_fraction", "expected_lost_pixel_fraction"),
            ("streak_cost_s", "streak_cost_s"),
            ("p_any", "p_any"),
            ("streak_length_deg", "streak_length_deg"),
        ]:
            cell = row[name].value if hasattr(row[name], "unit") else row[name]
            assert same(cell, expected[name]), (name, cell)
            assert same(float(getattr(fast, ours_name)[index]), expected[name]), name
        assert same(row["delay_s"].value, expected["delay_s"])
        if expected["next_clear_start_utc"] is not None:
            start = row["next_clear_start_utc"].copy()
            start.precision = 3
            assert start.isot + "Z" == expected["next_clear_start_utc"]


def test_verif_maps(command_line):
    answer = command_line("map", "sky", "--model", "v2mini", "--sun-altitude-deg=-20", "--height-km", "550", "--mpc", "X05", "--step-deg", "5")
    rows = answer["directions"]
    result = streakcast.sky_map("v2mini", sun_altitude=-20, height=550, mpc="X05", step=5)
    assert len(result) == len(rows) > 1000
    for row, expected in zip(result, rows):
        for name, value in expected.items():
            assert same(row[name].value, value), name
    answer = command_line("map", "body", "--model", "v2mini", "--sun-latitude-deg=-15", "--height-km", "550", "--step-deg", "5")
    rows = answer["directions"]
    result = streakcast.body_map("v2mini", sun_latitude=-15, height=550, step=5)
    assert len(result) == len(rows)
    for row, expected in zip(result, rows):
        for name, value in expected.items():
            assert same(row[name].value, value), name
    # Single directions give the values of the grid.
    magnitude = streakcast.standard_magnitudes("v2mini", -15, result["observer_longitude_deg"], result["observer_latitude_deg"])
    np.testing.assert_allclose(magnitude, result["standard_magnitude"].value, atol=1e-9)


def test_verif_real_catalogue(data, command_line):
    elements = data / "tle" / "active" / "active_2026-04-25.txt"
    arguments = ["--elements", str(elements), "--mpc", "X05", "--telescope", "rubin"]
    # Half an hour after sunset, at an altitude of 20 deg in the west, there are many Starlink crossings.
    start, ra, dec = "2026-04-25T23:10:00Z", 90.0, -20.0
    answer = command_line("passes", *arguments, "--start", start, "--exposure", "300s", "--ra", str(ra), f"--dec={dec}")
    model = streakcast.StreakModel(mpc="X05", elements=elements, telescope="rubin")
    result = model.passes((ra, dec), start, 300.0)
    assert len(result) == len(answer["passes"]) > 0
    for row, expected in zip(result, answer["passes"]):
        assert row["norad_id"] == expected["norad_id"]
        assert same(row["magnitude_peak"].value, expected["magnitude_peak"])
        assert row["mid_utc"].isot + "Z" == expected["mid_utc"]
    digest = model.provenance(start)["elements"][0]["sha256"]
    assert digest == answer["provenance"]["elements"][0]["sha256"]
    assert model.satellites(start) == pytest.approx(answer["provenance"]["satellites"])


def test_verif_samples_of_a_posterior_are_read_by_astropy(tmp_path):
    """The file of `fit run --chains`, read as in docs/how-to/fit.md."""
    from astropy.table import Table

    binary = os.environ.get("STREAKCAST_BIN") or pytest.fail("set STREAKCAST_BIN, or run plugins/test.sh")

    def run(*arguments):
        done = subprocess.run([binary, *arguments, "--quiet"], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode in (0, 1), done.stderr

    run("forecast", "--shells", "starlink-gen1", "--mpc", "X05", "--night", "2026-08-14", "--min-culmination", "60", "-o", "passes.csv", "--light-curves", "curves.ecsv")
    curves = Table.read(tmp_path / "curves.ecsv")
    points = curves[(curves["illumination"] == "sunlit") & (curves["altitude_deg"] > 20)][::16]
    scatter = 0.4 * np.sin(np.arange(len(points)) ** 2)
    photometry = Table({"time": points["utc"], "norad": points["norad_id"], "ra": points["ra_deg"], "dec": points["dec_deg"], "mag": points["magnitude"] + scatter, "range": points["range_km"]})
    photometry.write(tmp_path / "photometry.csv")
    columns = {"time": "time", "time_scale": "utc", "magnitude": "mag", "norad": "norad", "right_ascension": "ra", "declination": "dec", "distance": "range"}
    (tmp_path / "columns.toml").write_text("".join(f'{name} = "{column}"\n' for name, column in columns.items()))
    fit = ["fit", "run", "--photometry", "photometry.csv", "--columns", "columns.toml", "--mpc", "X05", "--model", "starlink-v1.5", "--raw-points", "--hold", "c1=0", "--hold", "n_sail=5"]
    run(*fit, "--folds", "0", "-o", "mine.json", "--mcmc", "40", "--burn-in", "10", "--chains", "mine.ecsv")
    chain = Table.read(tmp_path / "mine.ecsv")
    assert chain.colnames == ["step", "walker", "c2", "c3", "c4", "c5", "n_base", "log_prob"]
    walkers = chain["walker"].max() + 1
    assert (chain["step"].reshape(-1, walkers) == np.arange(40)[:, None]).all() and (chain["walker"].reshape(-1, walkers) == np.arange(walkers)).all()
    assert chain.meta["chain"]["about"]["parameters"] == chain.colnames[2:-1] and chain.meta["chain"]["steps"] == 40
    # The best walker is near the fitted value.
    fitted = json.loads((tmp_path / "mine.json").read_text())["coefficients"]["c5"]
    assert abs(chain["c5"][np.argmax(chain["log_prob"])] / fitted - 1) < 0.3
