"""Summary of an annotated survey, compared with sums over single visits."""

import sqlite3

import healpy
import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import AltAz, EarthLocation, get_sun
from astropy.table import QTable
from astropy.time import Time
from astropy.utils.masked import Masked
from streakcast import StreakcastWarning
from streakcast_rubin import survey_maps, survey_summary

#: One of the visits below is by daylight.
pytestmark = pytest.mark.filterwarnings("ignore:visits that are not in the summary")

UNITS = {"fieldRA": u.deg, "fieldDec": u.deg, "sunAlt": u.deg, "visitExposureTime": u.s}
#: Visits: start (MJD), RA, dec, exposure, altitude of the Sun, band, verdict, number of streaks, lost pixels, cost.
VISITS = [
    (61_400.1, 10.0, -30.0, 30.0, -20.0, "r", "clear", 0, 0.0, 0.0),
    (61_400.2, 10.0, -30.0, 30.0, -20.0, "r", "avoid", 1, 0.004, 3.0),
    (61_400.3, 10.0, -30.0, 15.0, -20.0, "r", "streaked", 2, 0.002, 1.5),
    (61_400.4, 10.0, -30.0, 30.0, -20.0, "r", "unknown", None, None, None),
    (61_400.5, 80.0, -60.0, 30.0, -13.0, "z", "clear", 0, 0.0, 0.0),
    (61_780.1, 10.0, -30.0, 30.0, -20.0, "r", "streaked", 1, 0.001, 0.3),
    (61_780.2, 10.0, -30.0, 30.0, 5.0, "r", "clear", 0, 0.0, 0.0),
    (61_780.3, 80.0, -60.0, 30.0, -13.0, "z", "invalid", None, None, None),
]
#: Streaks: visit, probability of crossing, probability of being bright if it crosses.
STREAKS = [(1, 1.0, 0.9), (2, 1.0, 0.5), (2, 0.2, 1.0), (5, 1.0, 0.0)]


@pytest.fixture
def annotated(tmp_path):
    path = tmp_path / "annotated.db"
    with sqlite3.connect(path) as base:
        base.execute(
            "CREATE TABLE observations (observationId INTEGER, observationStartMJD REAL, fieldRA REAL, fieldDec REAL, "
            "visitExposureTime REAL, sunAlt REAL, band TEXT)"
        )
        base.execute(
            "CREATE TABLE streak_flags (exposure_id INTEGER, verdict TEXT, n_streaks INTEGER, "
            "expected_lost_pixel_fraction REAL, streak_cost_s REAL)"
        )
        for number, visit in enumerate(VISITS):
            base.execute("INSERT INTO observations VALUES (?, ?, ?, ?, ?, ?, ?)", (number, *visit[:6]))
            base.execute("INSERT INTO streak_flags VALUES (?, ?, ?, ?, ?)", (number, *visit[6:]))
        base.execute("CREATE TABLE streaks (exposure_id INTEGER, probability REAL, p_bright REAL)")
        base.executemany("INSERT INTO streaks VALUES (?, ?, ?)", STREAKS)
    return path


def test_bins_have_the_means_and_sums_of_their_visits(annotated):
    rows = survey_summary(annotated)
    assert rows["year"].tolist() == [1, 1, 2, 2] and rows["band"].tolist() == ["r", "z", "r", "z"]
    # The visit with the Sun above all borders is in no bin.
    assert rows["visits"].tolist() == [4, 1, 1, 1] and rows["unknown_visits"].tolist() == [1, 0, 0, 1]
    assert rows["sun_min_deg"].tolist() == [-90.0, -15.0, -90.0, -15.0]
    np.testing.assert_allclose(rows["streaked_fraction"], [2 / 3, 0.0, 1.0, np.nan])
    np.testing.assert_allclose(rows["bright_fraction"], [(0.9 + 1 - 0.5 * 0.8) / 3, 0.0, 0.0, np.nan])
    np.testing.assert_allclose(rows["avoid_fraction"], [1 / 3, 0.0, 0.0, np.nan])
    np.testing.assert_allclose(rows["streak_cost_s"], [1.5, 0.0, 0.3, np.nan])
    np.testing.assert_allclose(rows["streak_cost_fraction"], [4.5 / 75, 0.0, 0.01, np.nan])
    np.testing.assert_allclose(rows["lost_pixel_fraction"], [0.002, 0.0, 0.001, np.nan])
    np.testing.assert_allclose(rows["coadd_loss_mag"], -1.25 * np.log10([1 - 0.06, 1.0, 0.99, np.nan]))


def test_tables_of_dask_give_the_same(annotated):
    names = ("observationStartMJD", "fieldRA", "fieldDec", "visitExposureTime", "sunAlt", "band")
    visits = {name: np.array([visit[column] for visit in VISITS]) for column, name in enumerate(names)}
    # The nights of Dask are in the order of their times.
    order = [4, 0, 1, 2, 3, 7, 5, 6]
    flags = {"visit": np.array(order), "verdict": np.array([VISITS[one][6] for one in order])}
    for column, name in enumerate(("n_streaks", "lost_fraction", "streak_cost_s"), 7):
        values = [VISITS[one][column] for one in order]
        flags[name] = np.ma.MaskedArray([value or 0.0 for value in values], mask=[value is None for value in values])
    streaks = {name: np.array(column) for name, column in zip(("visit", "probability", "p_bright"), zip(*STREAKS))}
    for found, expected in [
        (survey_summary((visits, flags, streaks)), survey_summary(annotated)),
        (survey_maps((visits, flags, streaks), nside=8), survey_maps(annotated, nside=8)),
    ]:
        for name, column in expected.items():
            np.testing.assert_array_equal(found[name], column, err_msg=name)
    table = QTable({name: column * UNITS[name] if name in UNITS else column for name, column in visits.items()})
    table["visitExposureTime"] = table["visitExposureTime"].to("min")
    of_table = survey_summary((table, flags, streaks))
    # Masked cells are unknown.
    masked = QTable(table, masked=True, copy=True)
    for name, row in (("visitExposureTime", 1), ("band", 2), ("sunAlt", 0), ("fieldRA", 5)):
        masked[name] = Masked(masked[name], mask=np.arange(len(VISITS)) == row)
    of_masked = survey_summary((masked, flags, streaks))
    assert dict(zip(of_masked["band"], of_masked["unknown_visits"]))["unknown"] == 0 and set(of_masked["band"]) == {"r", "z", "unknown"}
    assert of_masked["visits"].tolist() == [2, 1, 1, 1, 1] and of_masked["unknown_visits"].tolist() == [2, 0, 0, 0, 1]
    assert survey_maps((masked, flags, streaks), nside=32)["visits"].max() == 3
    with pytest.raises(ValueError, match="allowed: the path of a database, or two or three tables"):
        survey_summary({"visit": [0]})
    with pytest.raises(ValueError, match="does not contain each row of the visits once"):
        survey_summary((visits, {**flags, "visit": np.zeros(len(order), dtype=int)}))
    for name, column in survey_summary(annotated).items():
        np.testing.assert_allclose(of_table[name], column, err_msg=name) if name != "band" else None
    assert np.isnan(survey_summary((visits, flags))["bright_fraction"]).all()
    # With next starts, the tables of Dask have the names of `flag`.
    of_flag = {("expected_lost_pixel_fraction" if name == "lost_fraction" else name): column for name, column in flags.items()}
    of_flag["start_mjd_tai"] = visits["observationStartMJD"][order] + 37.0 / 86_400.0
    assert survey_summary((visits, of_flag))["lost_pixel_fraction"][0] == survey_summary((visits, flags))["lost_pixel_fraction"][0]
    fewer, reverse = ({name: column[part] for name, column in visits.items()} for part in (slice(3), slice(None, None, -1)))
    for summary in (survey_summary, survey_maps):
        with pytest.raises(ValueError, match="the flags are those of 8 visits, but there are 3; allowed"):
            summary((fewer, flags))
        with pytest.raises(ValueError, match="visit 4 is not the one of its flags: their starts differ"):
            summary((reverse, of_flag))


def test_exchanges_are_summed_by_row(annotated, tmp_path):
    second = 1.0 / 86_400.0
    columns = {
        "mjd": np.array([61_400.2 + 2 * second, 61_400.3 - 3 * second, 61_400.2, 61_780.1, 61_600.0]),
        "band": np.array(["r", "r", "z", "r", "r"]),
        "saved_s": np.array([2.0, 1.0, 8.0, 0.5, 9.0]),
        "detour_s": np.array([1.5, -0.5, 9.0, 0.1, 9.0]),
    }
    with pytest.warns(StreakcastWarning, match="2 of 5 exchanges are of no visit of the survey"):
        rows = survey_summary(annotated, exchanges=columns)
    assert rows["exchanged_visits"].tolist() == [2, 0, 1, 0]
    np.testing.assert_allclose(rows["saved_s"], [3.0, 0.0, 0.5, 0.0])
    np.testing.assert_allclose(rows["detour_s"], [1.0, 0.0, 0.1, 0.0])
    assert "saved_s" not in survey_summary(annotated)
    with pytest.raises(ValueError, match="lack the column saved_s; allowed"):
        survey_summary(annotated, exchanges={name: columns[name] for name in ("mjd", "band", "detour_s")})
    with pytest.raises(ValueError, match="none.ecsv is not a table of exchanges"):
        survey_summary(annotated, exchanges=tmp_path / "none.ecsv")


def test_an_exchange_is_that_of_its_target(annotated):
    """Visits start 40 s apart: the nearest one may be another one."""
    with sqlite3.connect(annotated) as base:
        base.execute("ALTER TABLE observations ADD COLUMN target_id INTEGER")
        base.execute("UPDATE observations SET target_id = 100 - observationId")
        base.execute("UPDATE observations SET observationStartMJD = 61780.1 + 40.0 / 86400.0, sunAlt = -13.0 WHERE observationId = 6")
    late = {"mjd": np.full(2, 61_780.1 + 35.0 / 86_400.0), "band": ["r", "r"], "saved_s": [2.0, 7.0], "detour_s": [1.0, 7.0]}
    with pytest.warns(StreakcastWarning, match="1 of 2 exchanges are of no visit of the survey: no visit of the band with the target_id"):
        rows = survey_summary(annotated, exchanges={**late, "target_id": [95, 33]})
    assert rows["saved_s"][(rows["year"] == 2) & (rows["band"] == "r")].tolist() == [2.0, 0.0]
    # Without identifiers, the next visit is the nearest one, within 10 s.
    assert survey_summary(annotated, exchanges=late)["saved_s"].tolist() == [0.0, 0.0, 0.0, 9.0, 0.0]


def test_repeated_rows_count_once(annotated):
    before = survey_summary(annotated)
    with sqlite3.connect(annotated) as base:
        base.execute("INSERT INTO observations SELECT * FROM observations WHERE observationId < 2")
    after = survey_summary(annotated)
    assert (before["visits"] == after["visits"]).all()


def test_annotations_without_a_telescope_are_rejected(annotated):
    with sqlite3.connect(annotated) as base:
        base.execute("UPDATE streak_flags SET streak_cost_s = NULL")
    with pytest.raises(ValueError, match="has no streak_cost_s; allowed: an annotation with a telescope"):
        survey_summary(annotated)


def test_maps_count_the_visits_whose_field_has_the_pixel(annotated):
    maps = survey_maps(annotated, nside=32)
    inside = healpy.query_disc(32, healpy.ang2vec(10.0, -30.0, lonlat=True), np.radians(1.75))
    assert set(np.flatnonzero(maps["visits"] == 5)) == set(inside)
    np.testing.assert_allclose(maps["streaked_fraction"][inside], 0.6)
    np.testing.assert_allclose(maps["bright_fraction"][inside], 1.5 / 5)
    np.testing.assert_allclose(maps["streak_cost_fraction"][inside], 4.8 / 135)
    assert np.isnan(maps["streak_cost_s"][maps["visits"] == 0]).all()
    assert maps["visits"].max() == 5 and len(maps["visits"]) == 12 * 32**2


def test_visits_without_a_start_and_empty_databases(annotated):
    before = survey_summary(annotated)
    with sqlite3.connect(annotated) as base:
        base.execute("INSERT INTO observations VALUES (90, NULL, 10.0, -30.0, 30.0, -20.0, 'r')")
        base.execute("INSERT INTO streak_flags VALUES (90, 'invalid', NULL, NULL, NULL)")
    after = survey_summary(annotated)
    assert all((before[name] == after[name]).all() for name in ("year", "band", "visits"))
    with sqlite3.connect(annotated) as base:
        base.execute("UPDATE observations SET observationStartMJD = NULL")
    with pytest.warns(StreakcastWarning, match=r"not in the summary: 9 without a start \(of 9\)"):
        without = survey_summary(annotated)
    assert list(without) == list(before) and not any(len(column) for column in without.values())
    with sqlite3.connect(annotated) as base:
        base.execute("DELETE FROM observations")
    assert not len(survey_summary(annotated)["year"]) and survey_maps(annotated)["visits"].sum() == 0
    with pytest.raises(ValueError, match="lack the column mjd"):
        survey_summary(annotated, exchanges={})


def test_visits_that_are_left_out_are_counted(annotated):
    with pytest.warns(StreakcastWarning, match=r"summary: 1 with the Sun outside the bins, or at an unknown altitude \(of 8\)"):
        survey_summary(annotated)
    with sqlite3.connect(annotated) as base:
        base.execute("UPDATE observations SET sunAlt = NULL, band = NULL WHERE observationId = 0")
        base.execute("UPDATE observations SET fieldRA = NULL WHERE observationId = 4")
    with pytest.warns(StreakcastWarning, match="summary: 2 with the Sun outside"):
        assert survey_summary(annotated)["visits"].sum() == 6
    with pytest.warns(StreakcastWarning, match=r"not in the maps: 1 without coordinates \(of 8\)"):
        assert survey_maps(annotated, nside=8, field_radius_deg=10.0)["visits"].max() == 5
    for radius_deg in (0.0, -1.0, np.nan, 200.0):
        with pytest.raises(ValueError, match="field_radius_deg is"):
            survey_maps(annotated, field_radius_deg=radius_deg)


def test_the_altitude_of_the_sun_is_computed_if_the_survey_has_none(annotated):
    """Altitudes by astropy for the site of rubin_scheduler; a missing band is one of its own."""
    starts = Time([visit[0] for visit in VISITS], format="mjd", scale="utc")
    site = EarthLocation.from_geodetic(-70.7494 * u.deg, -30.2444 * u.deg, 2650 * u.m)
    altitudes_deg = get_sun(starts).transform_to(AltAz(obstime=starts, location=site)).alt.deg
    with sqlite3.connect(annotated) as base:
        base.execute("UPDATE observations SET sunAlt = sunAlt * 0.01745")
    with pytest.raises(ValueError, match="sunAlt is .*; allowed: degrees"):
        survey_summary(annotated)
    assert survey_maps(annotated, nside=8)["visits"].sum() > 0
    with sqlite3.connect(annotated) as base:
        base.execute("UPDATE observations SET sunAlt = 0")
    edges = (-90.0, 90.0)
    assert survey_summary(annotated, sun_edges_deg=edges)["visits"].sum() == len(VISITS)
    with sqlite3.connect(annotated) as base:
        base.execute("UPDATE observations SET observationStartMJD = 1e9 WHERE observationId = 7")
    with pytest.warns(StreakcastWarning, match="summary: 1 without a start"):
        assert survey_summary(annotated, sun_edges_deg=edges)["year"].max() == 2
    with sqlite3.connect(annotated) as base:
        base.execute("UPDATE observations SET observationStartMJD = ? WHERE observationId = 7", (VISITS[7][0],))
    with sqlite3.connect(annotated) as base:
        base.execute("ALTER TABLE observations DROP COLUMN sunAlt")
        base.execute("UPDATE observations SET band = NULL")
    for low_deg, high_deg in ((-90.0, 0.0), (0.0, 30.0), (30.0, 90.0)):
        inside = (altitudes_deg >= low_deg) & (altitudes_deg < high_deg)
        rows = survey_summary(annotated, sun_edges_deg=(low_deg, high_deg))
        assert rows["visits"].sum() == inside.sum() and set(rows["band"]) <= {"unknown"}


def test_without_streaks_the_share_of_bright_ones_is_unknown(annotated):
    with sqlite3.connect(annotated) as base:
        base.execute("ALTER TABLE streaks DROP COLUMN p_bright")
    assert np.isnan(survey_summary(annotated)["bright_fraction"]).all()
    assert np.isnan(survey_maps(annotated)["bright_fraction"]).all()


def test_repeated_numbers_are_rejected(annotated):
    with sqlite3.connect(annotated) as base:
        base.execute("INSERT INTO streak_flags SELECT * FROM streak_flags WHERE exposure_id = 2")
    for summary in (survey_summary, survey_maps):
        with pytest.raises(ValueError, match="observationId 2 has several different visits; allowed: unique numbers"):
            summary(annotated)


def test_a_survey_lost_to_streaks_has_no_depth(annotated):
    with sqlite3.connect(annotated) as base:
        base.execute("UPDATE streak_flags SET streak_cost_s = 40.0 WHERE n_streaks IS NOT NULL")
    maps = survey_maps(annotated)
    assert (maps["coadd_loss_mag"][maps["visits"] > 0] == np.inf).all()
    assert (survey_summary(annotated)["coadd_loss_mag"][:3] == np.inf).all()


def test_databases_without_annotation_are_rejected(annotated, tmp_path):
    with pytest.raises(ValueError, match="is not a file"):
        survey_summary(tmp_path / "none.db")
    with sqlite3.connect(annotated) as base:
        base.execute("ALTER TABLE observations DROP COLUMN visitExposureTime")
    with pytest.raises(ValueError, match="missing column visitExposureTime"):
        survey_summary(annotated)
    with sqlite3.connect(annotated) as base:
        base.execute("DROP TABLE streak_flags")
    with pytest.raises(ValueError, match="no table streak_flags; allowed: a database that streakcast annotate wrote"):
        survey_maps(annotated)
    with pytest.raises(ValueError, match="at least two ascending altitudes"):
        survey_summary(annotated, sun_edges_deg=(0.0, -12.0))
