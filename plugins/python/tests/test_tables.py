"""Tables of results: units, descriptions, and formats of printed columns."""

import json
import pickle
import re

import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import SkyCoord
from astropy.table import QTable, join
from astropy.time import Time

import streakcast
from conftest import START, TARGET
from test_quantities import frame_header

SKY = dict(mpc="X05", shells="starlink-gen1", telescope="rubin", limit_mag=7)


@pytest.fixture(scope="module")
def tables():
    """Returns tables of all kinds by name."""
    model = streakcast.StreakModel(**SKY)
    forecast = model.forecast("2026-08-14", max_mag=5.1, min_culmination=86, samples=3)
    identified = model.identify(place=TARGET, position_angle=8.7, start=START, exposure=30.0)
    injected = model.inject(
        np.zeros((100, 100), "float32"), header=frame_header(), start=START, exposure=30.0, zero_point=25.0, seeing="10arcmin"
    )
    return {
        "passes": model.passes(TARGET, START, 30.0, samples=3),
        "flags": model.flag((198.9, [7.7, 7.8]), START, 30.0),
        "forecast": forecast.passes,
        "nights": forecast.nights,
        "ephemeris": model.ephemeris(START, norad=[900003951, 900001561]),
        "candidates": identified.candidates,
        "streak": identified.streak,
        "truth": injected.truth,
        "points": injected.points,
        "trails": injected.trails,
        "sky_map": streakcast.sky_map("v2mini", sun_altitude=-20, step=5),
        "body_map": streakcast.body_map("v2mini", sun_latitude=-10, step=5),
    }


#: First and last printed columns of tables with many columns.
MAIN = {
    "passes": (["exposure_id", "name", "enter_utc"], ["magnitude_peak", "probability"]),
    "flags": (["exposure_id", "verdict", "n_streaks"], ["brightest_mag", "p_any", "acceptable_delay_s"]),
    "forecast": (["name", "begin_utc"], ["highest_altitude_deg", "peak_magnitude"]),
    "nights": (["dark_from_utc", "dark_until_utc"], ["dark_h", "why_empty"]),
    "ephemeris": (["name", "utc", "ra_deg"], ["dec_deg", "magnitude"]),
    "candidates": (["name", "probability"], ["along_track_offset_s", "magnitude"]),
    "streak": (["start_utc", "ra_deg", "dec_deg"], ["position_angle_deg", "length_deg"]),
    "truth": (["name", "x1_pix", "y1_pix", "x2_pix"], ["y2_pix", "length_pix", "magnitude"]),
}
NAMES = [
    "passes", "flags", "forecast", "nights", "ephemeris", "candidates", "streak", "truth", "points", "trails", "sky_map", "body_map",
]  # fmt: skip


def printed(table, name):
    """Returns the printed cells of a column."""
    lines = table[[name]].pformat(max_lines=-1, max_width=-1, show_unit=False)
    assert lines[0].strip() == name and len(lines) == len(table) + 2
    return [line.strip() for line in lines[2:]]


@pytest.mark.parametrize("name", NAMES)
def test_columns_have_units_and_descriptions(tables, name):
    table = tables[name]
    assert isinstance(table, QTable) and len(table) > 0
    for column in table.colnames:
        assert table[column].info.description, column
        for ending, unit in (("_deg", u.deg), ("_s", u.s), ("_km", u.km), ("_mag", u.mag), ("_arcsec", u.arcsec), ("_pix", u.pix), ("_days", u.d)):
            if column.endswith(ending) and not column.endswith(("_deg_s", "_km_s", "counts_s")):
                assert table[column].unit == unit, column


@pytest.mark.parametrize("name", NAMES)
def test_printed_cells_are_short(tables, name):
    """No printed cell has more than 40 characters, and numbers have at most 8 decimals."""
    table = tables[name]
    for column in table.colnames:
        for text in printed(table, column):
            assert len(text) <= 40, (column, text)
            if not isinstance(table[column], Time) and table[column].dtype.kind == "f":
                assert len(text.partition(".")[2]) <= (8 if column == "julian_date_utc" else 6), (column, text)


@pytest.mark.parametrize("name", [name for name in NAMES if not name.endswith("map")])
def test_the_main_columns_are_printed_in_80_characters(tables, name):
    """With names as long as those of real Starlinks. Astropy replaces other columns with dots."""
    table = tables[name].copy()
    if "name" in table.colnames:
        table["name"] = [str(one)[:13] for one in table["name"]]
    lines = table.pformat(max_lines=-1, max_width=80)
    assert len(lines) == len(table) + 3 and all(len(line) <= 80 for line in lines)
    if name in MAIN:
        first, last = MAIN[name]
        shown = lines[0].split()
        assert "..." in shown and shown[: len(first)] == first and shown[-len(last) :] == last
    else:
        assert lines[0].split() == table.colnames
    # Selected columns are printed as well.
    assert table[table.colnames[3:5]].pformat(max_width=-1)[0].split() == table.colnames[3:5]


def test_times_and_numbers_are_rounded_in_print_only(tables):
    table = tables["passes"]
    assert all(re.fullmatch(r"2026-08-14T\d\d:\d\d:\d\d\.\d{3}", text) for text in printed(table, "enter_utc"))
    assert all(re.fullmatch(r"-?\d+\.\d\d", text) for text in printed(table, "magnitude_peak") if text != "nan")
    assert all(re.fullmatch(r"\d+\.\d{4}", text) for text in printed(table, "enter_ra_deg"))
    # The values have all digits.
    assert table["enter_utc"][0].isot[:23] == printed(table, "enter_utc")[0] and len(table["enter_utc"][0].isot) == 26
    assert abs(table["magnitude_peak"][0].value - float(printed(table, "magnitude_peak")[0])) <= 0.005
    assert any(abs(value - round(value, 4)) > 1e-6 for value in table["enter_ra_deg"].value)


def test_a_missing_time_is_printed(tables):
    """An exposure without a clear start within the limit has no time."""
    model = streakcast.StreakModel(**SKY, max_delay="1s")
    flags = model.flag(TARGET, START, 30.0)
    assert printed(flags, "next_clear_start_utc") == [""] and printed(flags, "delay_s") == ["nan"]


def test_a_written_table_keeps_values_and_formats(tables, tmp_path):
    for name in ("passes", "forecast"):
        path = tmp_path / f"{name}.ecsv"
        tables[name].write(path)
        read = QTable.read(path)
        for column in read.colnames:
            if isinstance(tables[name][column], Time):
                assert (read[column].isot == tables[name][column].isot).all()
        assert str(read) and read.colnames == tables[name].colnames
        magnitude = "magnitude_peak" if name == "passes" else "peak_magnitude"
        assert printed(read, magnitude) == printed(tables[name], magnitude)


#: Tables with lists, times, missing times, or missing whole numbers.
WRITTEN = ["passes", "flags", "forecast", "nights", "ephemeris", "candidates", "truth", "body_map"]
#: Formats that are written to files, and options of their readers.
FORMATS = {"ascii.csv": {}, "ascii.ecsv": {}, "fits": {"astropy_native": True}, "votable": {}}


def assert_same_cells(read, written):
    """Checks a column that was read from a file. Lists may be JSON text, and times ISO 8601 text."""
    assert len(read) == len(written)
    if isinstance(written, Time):
        for cell, time, is_masked in zip(read, written, written.mask):
            if is_masked:
                assert np.all(getattr(cell, "mask", str(cell) == ""))
            elif isinstance(cell, Time):
                assert cell.scale == "utc" and abs((cell - time).sec) < 1e-6
            else:
                assert str(cell) == time.isot
    elif written.dtype == object:
        assert [cell if isinstance(cell, list) else json.loads(cell) for cell in read] == list(written)
    elif written.dtype.kind == "f":
        numbers = np.ma.filled(np.ma.asarray(getattr(read, "value", read)).astype(float), np.nan)
        np.testing.assert_array_equal(numbers, getattr(written, "value", written))
    else:
        for cell, expected in zip(read, written):
            missing = expected is np.ma.masked or str(expected) == ""
            assert str(cell) == str(expected) or (missing and cell is np.ma.masked)


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("name", WRITTEN)
def test_files_have_the_values_with_all_digits(tables, tmp_path, name, form):
    path, table = tmp_path / "table", tables[name]
    formats = [table[column].info.format for column in table.colnames]
    if form == "fits" and name == "body_map":
        # The metadata have names of more than 8 characters.
        with pytest.warns(match="greater than 8 characters"):
            table.write(path, format=form)
    else:
        table.write(path, format=form)
    read = QTable.read(path, format=form, **FORMATS[form])
    assert read.colnames == table.colnames
    for column in table.colnames:
        assert_same_cells(read[column], table[column])
    # The table itself is not changed.
    assert [table[column].info.format for column in table.colnames] == formats


def test_a_csv_file_has_microseconds_and_whole_lists(tables, tmp_path):
    flags = tables["flags"]
    for path in (tmp_path / "flags.csv", str(tmp_path / "again.csv")):
        flags.write(path)
        read = QTable.read(path)
        assert list(read["next_clear_start_utc"]) == list(flags["next_clear_start_utc"].isot)
        assert [json.loads(cell) for cell in read["reasons"]] == list(flags["reasons"])
        assert max(len(reason) for reason in flags["reasons"][0]) > 40
    with pytest.raises(OSError, match="overwrite"):
        flags.write(path)


def test_missing_times_are_written(tmp_path):
    model = streakcast.StreakModel(**SKY)
    flags = model.flag((198.9, [7.7, 89.0]), START, 30.0)
    assert list(flags["next_clear_start_utc"].mask) == [False, True]
    for form in ("ascii.csv", "votable"):
        flags.write(tmp_path / form, format=form)
        texts = QTable.read(tmp_path / form, format=form)["next_clear_start_utc"]
        assert str(texts[0]) == flags["next_clear_start_utc"][0].isot and (texts[1] is np.ma.masked or texts[1] == "")
    for form in ("ascii.ecsv", "fits"):
        flags.write(tmp_path / form, format=form)
        times = QTable.read(tmp_path / form, format=form, **FORMATS[form])["next_clear_start_utc"]
        assert list(times.mask) == [False, True] and abs((times - flags["next_clear_start_utc"])[0].sec) < 1e-6


def test_parts_and_copies_are_written_with_all_digits(tables, tmp_path):
    passes = tables["passes"]
    by_name = passes.copy()
    by_name.sort("name")
    parts = {
        "rows": (passes[:1], passes[:1]),
        "columns": (passes["name", "range_km"], passes["name", "range_km"]),
        "sorted": (by_name, passes[np.argsort(passes["name"], kind="stable")]),
        "pickle": (pickle.loads(pickle.dumps(passes)), passes),
        "join": (join(passes["norad_id", "name"], passes["norad_id", "range_km"], keys="norad_id"), None),
        "empty": (passes[:0], passes[:0]),
    }
    for name, (part, expected) in parts.items():
        part.write(tmp_path / f"{name}.csv")
        read = QTable.read(tmp_path / f"{name}.csv", format="ascii.csv")
        assert read.colnames == part.colnames
        for column in part.colnames:
            assert_same_cells(read[column], (part if expected is None else expected)[column])
    row = passes[0]
    assert row["name"] == passes["name"][0] and row["samples"] == passes["samples"][0]


def test_a_table_with_further_columns_is_written(tables, tmp_path):
    passes = tables["passes"].copy()
    passes["place"] = SkyCoord(passes["mid_ra_deg"], passes["mid_dec_deg"])
    passes["remark"] = np.array([{"any": 1}] * len(passes), dtype=object)
    passes.write(tmp_path / "passes.csv")
    read = QTable.read(tmp_path / "passes.csv")
    assert read.colnames == passes.colnames
    assert list(read["remark"]) == ["{'any': 1}"] * len(passes)


def test_a_table_with_missing_times_can_be_pickled():
    model = streakcast.StreakModel(**SKY)
    flags = model.flag((198.9, [7.7, 89.0]), START, 30.0)
    again = pickle.loads(pickle.dumps(flags))
    assert type(again) is type(flags) and str(again) == str(flags) and again.meta == flags.meta
    times, expected = again["next_clear_start_utc"], flags["next_clear_start_utc"]
    assert list(times.mask) == [False, True] and times[0] == expected[0]
    assert (times.info.format, times.info.description) == (expected.info.format, expected.info.description)


def test_plain_tables_have_arrays():
    model = streakcast.StreakModel(**SKY)
    for table in (model.passes(TARGET, START, 30.0, samples=3, output="dict"), model.flag(TARGET, START, 30.0, output="dict")):
        assert all(isinstance(column, np.ndarray) for column in table.values())
        assert len({len(column) for column in table.values()}) == 1
