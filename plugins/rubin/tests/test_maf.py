"""Stacker and metric for MAF, with rubin_sim; skipped if that is not installed."""

import re
import warnings
from pathlib import Path

import night
import numpy as np
import pytest
from conftest import EVENING
from streakcast_rubin import annotate, survey_summary

maf = pytest.importorskip("rubin_sim.maf")
streaks = pytest.importorskip("streakcast_rubin.maf")

YEARS = Path(__file__).resolve().parents[3] / "docs" / "how-to" / "years.md"


@pytest.fixture(scope="module")
def database(folder, models):
    night.run(EVENING, "pairs", folder, hours=0.7, filename=str(folder / "maf.db"))
    annotate(folder / "maf.db", folder / "baseline-streaks.db", models[40768].with_options(bright_share=0.3))
    return folder / "baseline-streaks.db"


def value_of(metric, slicer, database, folder):
    bundle = maf.MetricBundle(metric, slicer, "streak_cost_s IS NOT NULL")
    maf.MetricBundleGroup({"one": bundle}, str(database), out_dir=str(folder), db_table="observations_streaks").run_all()
    return bundle.metric_values


def test_the_loss_is_that_of_the_summary(database, tmp_path):
    rows = survey_summary(database)
    lost = np.average(rows["streak_cost_fraction"], weights=rows["visits"])
    assert lost > 0.005
    found = value_of(streaks.StreakCoaddLossMetric(), maf.UniSlicer(), database, tmp_path)
    # All visits have the same exposure time.
    assert found[0] == pytest.approx(-1.25 * np.log10(1.0 - lost), rel=1e-6)


def test_metrics_read_the_columns_of_the_stacker(database, tmp_path):
    """Each metric has its own query of the database, so that MAF must know the columns of the stacker."""
    sky = maf.HealpixSlicer(nside=16, use_camera=False, verbose=False)
    fraction = value_of(maf.MeanMetric(col="streak_cost_fraction"), sky, database, tmp_path)
    cost_s = value_of(maf.MeanMetric(col="streak_cost_s"), sky, database, tmp_path)
    exposure_s = value_of(maf.MeanMetric(col="visitExposureTime"), sky, database, tmp_path)
    np.testing.assert_allclose(fraction.compressed(), (cost_s / exposure_s).compressed())
    depth, with_streaks = (value_of(maf.Coaddm5Metric(m5_col=name), sky, database, tmp_path) for name in ("fiveSigmaDepth", "fiveSigmaDepth_streaks"))
    loss = (depth - with_streaks).compressed()
    assert (loss > -1e-9).all() and 0.0 < loss.max() < 1.0


def test_unknown_and_lost_visits():
    visits = np.array(
        [(3.0, 30.0, 24.0), (np.nan, 30.0, 24.0), (30.0, 30.0, 24.0)],
        dtype=[("streak_cost_s", float), ("visitExposureTime", float), ("fiveSigmaDepth", float)],
    )
    added = streaks.StreakStacker().run(visits)
    np.testing.assert_allclose(added["streak_cost_fraction"], [0.1, np.nan, 1.0])
    np.testing.assert_allclose(added["fiveSigmaDepth_streaks"], [24.0 + 1.25 * np.log10(0.9), np.nan, -np.inf])
    metric = streaks.StreakCoaddLossMetric()
    assert metric.run(visits[:2]) == pytest.approx(-1.25 * np.log10(0.9))
    # A visit without an exposure time does not count, and one of 0 s is no warning.
    visits["visitExposureTime"][2] = np.nan
    assert metric.run(visits) == pytest.approx(-1.25 * np.log10(0.9))
    visits["visitExposureTime"][2] = 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert streaks.StreakStacker().run(visits)["fiveSigmaDepth_streaks"][2] == -np.inf
    visits["visitExposureTime"][2] = 30.0
    assert metric.run(visits[1:2]) == metric.run(visits[2:]) == metric.badval


def test_the_example_of_the_documentation_runs(database, tmp_path, monkeypatch):
    (code,) = re.findall(r"```python\n(import rubin_sim.*?)```", YEARS.read_text(), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "baseline-streaks.db").symlink_to(database)
    names = {}
    exec(compile(code, "years.md", "exec"), names)
    assert all(np.isfinite(bundle.metric_values.compressed()).all() for bundle in names["bundles"].values())
    assert 0.0 < names["bundles"]["share"].metric_values[0] < 1.0
