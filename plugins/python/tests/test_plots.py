"""Plots of results, as PNG and SVG, in notebooks and files."""

import re

import numpy as np
import pytest
from streakcast import StreakcastError, StreakcastWarning, StreakModel, plots

TARGET = (198.9, 7.7)
START = "2026-08-14T23:29:05Z"
MASKED = np.ma.MaskedArray([1.0, 2.0], mask=[False, True])


@pytest.fixture(scope="module")
def model():
    return StreakModel(site="Rubin Observatory", shells="starlink-gen1", fov="3.5deg", limit_mag=7)


def rendered_svg(picture):
    assert picture._repr_png_().startswith(b"\x89PNG") and picture._repr_png_() == picture.png()
    svg = picture._repr_svg_()
    assert svg.startswith("<svg") and "@font-face" in svg
    return svg


@pytest.mark.parametrize("output", ["qtable", "dict"])
def test_a_field_shows_its_passes(model, output):
    passes = model.passes(TARGET, START, 30.0, output=output)
    svg = rendered_svg(plots.field(passes, TARGET, fov_deg=3.5, title="A field"))
    assert "A field" in svg and f"{len(passes['name'])} streak" in svg
    assert any(str(name)[:16] in svg for name in passes["name"])


def test_a_field_has_the_given_diameter(model):
    passes = model.passes(TARGET, START, 30.0, output="dict")
    none = {name: column[:0] for name, column in passes.items()}
    # A plot is 10 % wider than the field: 33 arcmin to each side of declination 7.7 degrees.
    arcminutes, degrees = (rendered_svg(plots.field(none, TARGET, fov_deg=fov)) for fov in (1.0, 7.0))
    assert "\n+7°40′\n" in arcminutes and "\n+8°00′\n" in arcminutes and "\n+9°00′\n" not in arcminutes
    assert "\n+6°\n" in degrees and "no streak crosses this field" in degrees
    for fov in (0.0, -1.0, 181.0):
        with pytest.raises(StreakcastError):
            plots.field(passes, TARGET, fov_deg=fov)


def test_both_forms_of_tables_give_the_same_chart(model):
    one, other = (plots.field(model.passes(TARGET, START, 30.0, output=form), TARGET) for form in ("qtable", "dict"))
    assert one.svg() == other.svg()


def test_a_night_shows_the_number_of_struck_exposures(model):
    seconds = np.arange(20) * 60
    start = np.datetime64("2026-08-14T23:20:00") + seconds.astype("timedelta64[s]")
    flags = model.flag(TARGET, start, 30.0, scale="utc")
    svg = rendered_svg(plots.night(flags, start, 30.0, limit_mag=7.0, utc_offset=-4, scale="utc"))
    struck = int(np.sum(np.asarray(flags["n_streaks"]) > 0))
    assert struck > 0 and f"20 exposures, {struck} with streaks" in svg
    assert "UTC, 2026-08-14" in svg and "local time (UTC−4), 2026-08-14" in svg


def night_of(verdicts):
    numbers = np.arange(len(verdicts), dtype=float)
    table = {"verdict": np.array(verdicts), "n_streaks": numbers, "brightest_mag": numbers + 4}
    return table, [f"2026-08-14T23:{minute:02}:00Z" for minute in range(20, 20 + len(verdicts))]


def test_invalid_exposures_are_not_drawn():
    table, start = night_of(["clear", "invalid", "streaked"])
    with pytest.warns(StreakcastWarning, match="^1 of 3 exposures are invalid and not drawn$") as found:
        svg = plots.night(table, start, 30.0).svg()
    assert len(found) == 1 and found[0].filename == __file__ and "2 exposures, 1 with streaks" in svg
    valid = {name: column[[0, 2]] for name, column in table.items()}
    assert plots.night(valid, [start[0], start[2]], [30.0, 30.0]).svg() == svg
    # A table without verdicts is drawn completely.
    del table["verdict"]
    assert "3 exposures, 2 with streaks" in plots.night(table, start, 30.0).svg()
    with pytest.raises(ValueError, match="all 2 exposures are invalid; allowed"):
        plots.night(*night_of(["invalid", "invalid"]), 30.0)


def test_invalid_exposures_of_a_model_are_not_drawn(model):
    flags = model.flag((198.9, [7.7, 89.0]), START, 30.0)
    with pytest.warns(StreakcastWarning, match="1 of 2 exposures are invalid"):
        assert "1 exposure, 1 with streaks" in plots.night(flags, START, 30.0).svg()


def test_invalid_nights_are_reported():
    table, start = night_of(["clear", "streaked"])
    for wrong, given in (
        ((table, start[:1] * 3, 30.0), "n_streaks 2, brightest_mag 2, start 3, exposure 1"),
        ((table, start, [30.0] * 3), "n_streaks 2, brightest_mag 2, start 2, exposure 3"),
        (({**table, "brightest_mag": np.zeros(1)}, start, 30.0), "n_streaks 2, brightest_mag 1, start 2, exposure 1"),
    ):
        with pytest.raises(StreakcastError, match=f"columns differ in length: {given}; allowed: "):
            plots.night(*wrong)
    with pytest.raises(StreakcastError, match="at most 2 d"):
        plots.night(table, [start[0], "2026-08-17T23:20:00Z"], 30.0)
    for hours in (np.nan, np.inf, 15.0):
        with pytest.raises(ValueError, match=f"utc_offset is {hours} h; allowed: -14 to 14 h"):
            plots.night(table, start, 30.0, utc_offset=hours)


def test_a_field_is_one_exposure(model):
    passes = model.passes((198.9, [7.7, 7.8]), START, 30.0)
    message = r"passes are of 2 exposures; allowed: rows of one exposure, for example passes\[passes\['exposure_id'\] == 0\]"
    with pytest.raises(ValueError, match=message):
        plots.field(passes, TARGET)
    plots.field(passes[passes["exposure_id"] == 1], (198.9, 7.8))
    one = passes[passes["exposure_id"] == 0]
    with pytest.raises(ValueError, match="target has 2 positions; allowed: one position"):
        plots.field(one, (198.9, [7.7, 7.8]))
    assert plots.field(one, ([198.9], [7.7])).svg() == plots.field(one, TARGET).svg()


def test_a_light_curve_of_samples(model, tmp_path):
    passes = model.passes(TARGET, START, 30.0, samples=50, output="dict")
    picture = plots.light_curve(passes["samples"][0], title="A curve", limit_mag=7.0)
    assert "magnitude, ±1σ" in rendered_svg(picture)
    for name, begin in [("curve.png", b"\x89PNG"), ("curve.svg", b"<svg")]:
        picture.save(tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(begin)
    with pytest.raises(ValueError, match=".png or .svg"):
        picture.save(tmp_path / "curve.gif")
    with pytest.raises(ValueError, match="PDF is not supported"):
        picture.save(tmp_path / "curve.pdf")
    with pytest.raises(OSError, match="cannot write"):
        picture.save(tmp_path / "curve.png" / "curve.png")
    picture.save(tmp_path / "new" / "curve.png")
    assert {path.name for path in tmp_path.iterdir()} == {"curve.png", "curve.svg", "new"}


@pytest.mark.parametrize("output", ["qtable", "dict"])
def test_a_forecast_over_the_sky_and_in_time(model, output):
    passes = model.forecast("2026-08-14", max_mag=5.1, atmosphere=False, sort="time", min_culmination=86, samples=41, output=output).passes
    svg = rendered_svg(plots.sky_chart(passes, title="A night"))
    assert "A night" in svg and "rise UTC" in svg and all(f"\n{side}\n" in svg for side in "NESW")
    assert "The 22 brightest" not in svg and len(passes["name"]) == 14
    one = passes[:1] if output == "qtable" else {name: cells[:1] for name, cells in passes.items()}
    # A single pass is labelled in whole minutes.
    assert re.search(r"\n22:4\d\n", rendered_svg(plots.sky_chart(one))) and not re.search(r"\n22:4\d\n", svg)
    curve = rendered_svg(plots.light_curve(passes["samples"][0], title="A pass"))
    # A pass from rise to set has no field.
    assert "in the field" not in curve and "magnitude, ±1σ" in curve
    many = model.forecast("2026-08-14", max_mag=5, atmosphere=False, min_culmination=75, samples=3, output=output).passes
    assert f"brightest of {len(many['name'])} passes" in rendered_svg(plots.sky_chart(many))
    none = model.forecast("2026-08-14", max_mag=-8, samples=3, output=output).passes
    # A night without passes gives an empty plot.
    assert "no pass" in rendered_svg(plots.sky_chart(none))
    with pytest.raises(ValueError, match="samples=100"):
        plots.sky_chart(model.forecast("2026-08-14", max_mag=-8, output=output).passes)


def test_rates_and_the_sun():
    svg = rendered_svg(plots.sky_rate(np.arange(4), [0.0, 1.0, 2.0, 0.5], nside=4, sun_azimuth_deg=250.0))
    assert "not computed" in svg
    svg = rendered_svg(plots.sun_altitude(-np.arange(40.0), np.ones(40), n_bright=np.zeros(40), limit_mag=7))
    assert "40 exposures, 1.00 trails per exposure on average" in svg and "brighter than 7 mag" in svg


def test_invalid_charts_are_reported():
    with pytest.raises(StreakcastError, match="a cell is 99"):
        plots.sky_rate([99], [1.0], nside=1, sun_azimuth_deg=0.0)
    with pytest.raises(StreakcastError, match="numbers of trails: 2 values"):
        plots.sun_altitude([-5.0], [1.0, 2.0])
    for masked in (dict(n_trails=MASKED), dict(n_trails=[1.0, 2.0], n_bright=MASKED, limit_mag=7)):
        with pytest.raises(ValueError, match=r"(n_trails|n_bright)\[1\] is masked; allowed"):
            plots.sun_altitude([-5.0, -6.0], **masked)
    with pytest.raises(ValueError, match="nside is -1; allowed: 1 or more"):
        plots.sky_rate([0], [1.0], nside=-1, sun_azimuth_deg=0.0)
    with pytest.raises(ValueError, match=r"cells\[1\] is -3; allowed: 0 or more"):
        plots.sky_rate([0, -3], [1.0, 1.0], nside=1, sun_azimuth_deg=0.0)
    with pytest.raises(ValueError, match=r"cells\[1\] is masked"):
        plots.sky_rate(MASKED.astype(int), [1.0, 1.0], nside=1, sun_azimuth_deg=0.0)
    with pytest.raises(TypeError, match="cells are float64; allowed: integers"):
        plots.sky_rate([0.0, 1.0], [1.0, 1.0], nside=1, sun_azimuth_deg=0.0)
    with pytest.raises(ValueError, match="require each other"):
        plots.sun_altitude([-5.0], [1.0], n_bright=[1.0])
    with pytest.raises(StreakcastError, match="no points along the track"):
        plots.light_curve([])
