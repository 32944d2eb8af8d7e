"""Quantities of astropy are accepted wherever a number has a unit, and a wrong unit is reported with the argument."""

import numpy as np
import pytest
from astropy import units as u
from astropy.io import fits
from astropy.table import MaskedColumn, QTable, Table
from astropy.utils.masked import Masked
from astropy.wcs import WCS

import streakcast
from conftest import START, TARGET
from streakcast import plots
from streakcast.hosts import Hook

END = "2026-08-14T23:39:05Z"
SIZE = 100


@pytest.fixture(scope="module")
def sky():
    return streakcast.StreakModel(mpc="X05", shells="starlink-gen1", telescope="rubin", limit_mag=7, epoch=START)


def frame_header():
    wcs = WCS(naxis=2)
    wcs.wcs.ctype = ["RA---TAN", "DEC--TAN"]
    wcs.wcs.crval, wcs.wcs.crpix, wcs.wcs.cdelt = TARGET, [SIZE / 2] * 2, [-3.5 / SIZE, 3.5 / SIZE]
    return wcs.to_header()


def injected(sky, **changes):
    options = dict(
        start=START, exposure=30.0, random_streaks=2, magnitude=5.0, zero_point=25.0, gain=2.0, seeing="10arcmin", seed=1,
    )  # fmt: skip
    options = {name: value for name, value in {**options, **changes}.items() if value is not None}
    return streakcast.inject(np.zeros((SIZE, SIZE), "float32"), header=frame_header(), table="dict", **options).image


def crossed_frame(sky, **changes):
    options = dict(start=START, exposure=30.0, zero_point=25.0, gain=2.0, seeing="10arcmin", seed=1, table="dict")
    return sky.inject(np.zeros((SIZE, SIZE), "float32"), header=frame_header(), **{**options, **changes}).image


def learned(sky, **changes):
    given = dict(norad_id=[1, 2], time=[START] * 2, observed=[7.0, 7.2], predicted=[6.0, 6.1], kind="oneweb", sigma=0.2)
    return streakcast.learn(**{**given, **changes})


def setup(sky, **changes):
    """Returns the configuration document of a model."""
    site = {} if {"site", "lat", "lon", "height"} & set(changes) else {"mpc": "X05"}
    given = {"shells": "starlink-gen1", "fov": "3.5deg", **site, **changes}
    if {"lat", "lon", "height"} & set(changes):
        given = {"lat": -30.2, "lon": -70.7, "height": 2000.0, **given}
    return streakcast.StreakModel(**given).assess(TARGET, START, 30.0)


def ends(sky, **changes):
    given = dict(place=TARGET, position_angle=45.0, start=START, exposure=30.0, length=2.0, output="dict")
    return sky.identify(**{**given, **changes})


def night(sky, **changes):
    table = {"n_streaks": np.array([1, 0]), "brightest_mag": np.array([6.0, np.nan])}
    start = ["2026-08-14T23:29:05Z", "2026-08-14T23:39:05Z"]
    return plots.night(table, start, **{"exposure": 30.0, **changes}).svg()


def rows_of(table):
    """Returns a table that is not empty."""
    assert all(len(column) for column in table.values())
    return table


def forecast(sky, **changes):
    found = sky.forecast("2026-08-14", output="dict", **{"max_mag": 5.0, "atmosphere": False, "min_culmination": 86.0, **changes})
    return rows_of(found.passes), found.nights


def hook_site(sky, place):
    hook = Hook(sky, "test")
    hook.check_site(place)
    return hook.counts["site"]


CASES = {
    # name: function, argument, number, quantity, unit
    "assess ra": (lambda sky, it: sky.assess((it, 7.7), START, 30.0), "ra", 198.9, 11934.0 * u.arcmin),
    "assess dec": (lambda sky, it: sky.assess((198.9, it), START, 30.0), "dec", 7.7, 462.0 * u.arcmin),
    "assess exposure": (lambda sky, it: sky.assess(TARGET, START, it), "exposure", 30.0, 0.5 * u.min),
    "assess exposures": (lambda sky, it: sky.assess(TARGET, START, it), "exposure", [30.0, 60.0], [30.0 * u.s, 1.0 * u.min]),
    "assess rotation": (lambda sky, it: sky.assess(TARGET, START, 30.0, rotation=it), "rotation", 30.0, 1800.0 * u.arcmin),
    "flag exposure": (lambda sky, it: sky.flag(TARGET, START, it, output="dict"), "exposure", 30.0, 0.5 * u.min),
    "next_start exposure": (lambda sky, it: sky.next_start(TARGET, START, it, output="dict"), "exposure", 30.0, 0.5 * u.min),
    "passes limit_mag": (lambda sky, it: rows_of(sky.passes(TARGET, START, 30.0, limit_mag=it, output="dict")), "limit_mag", 6.5, 6.5 * u.mag),
    "passes limit_mag AB": (lambda sky, it: sky.passes(TARGET, START, 30.0, limit_mag=it, output="dict"), "limit_mag", 6.5, 6.5 * u.ABmag),
    "check_pointings visit_time": (
        lambda sky, it: sky.check_pointings([198.9], [7.7], [61266.978], it, scale="utc"), "exposure", 30.0, 0.5 * u.min,
    ),
    "windows exposure": (lambda sky, it: sky.windows(TARGET, START, END, it, output="dict"), "exposure", 30.0, 0.5 * u.min),
    "windows min_altitude": (
        lambda sky, it: sky.windows(TARGET, START, END, 30.0, min_altitude=it, output="dict"), "min_altitude", 30.0, 1800 * u.arcmin,
    ),
    "windows max_sun_altitude": (
        lambda sky, it: sky.windows(TARGET, START, END, 30.0, max_sun_altitude=it, output="dict"), "max_sun_altitude", -12.0, -720 * u.arcmin,
    ),
    "overhead seconds": (lambda sky, it: sky.overhead(START, it), "seconds", [0.0, 60.0], [0.0, 1.0] * u.min),
    "overhead min_altitude": (lambda sky, it: sky.overhead(START, min_altitude=it), "min_altitude", 60.0, 3600.0 * u.arcmin),
    "overhead limit_mag": (lambda sky, it: sky.overhead(START, limit_mag=it), "limit_mag", [5.0, 6.0], [5.0, 6.0] * u.mag),
    "forecast max_mag": (lambda sky, it: forecast(sky, max_mag=it), "max_mag", 5.0, 5.0 * u.ABmag),
    "forecast min_altitude": (lambda sky, it: forecast(sky, min_altitude=it), "min_altitude", 30.0, 1800 * u.arcmin),
    "forecast min_culmination": (lambda sky, it: forecast(sky, min_culmination=it), "min_culmination", 85.0, 5100 * u.arcmin),
    "forecast max_sun_altitude": (lambda sky, it: forecast(sky, max_sun_altitude=it), "max_sun_altitude", -12.0, -720 * u.arcmin),
    "ephemeris min_altitude": (
        lambda sky, it: rows_of(sky.ephemeris(START, norad=[900003951, 900001561], min_altitude=it, output="dict")),
        "min_altitude", 20.0, 1200 * u.arcmin,
    ),
    "identify position_angle": (lambda sky, it: ends(sky, position_angle=it), "position_angle", 45.0, 2700 * u.arcmin),
    "identify length": (lambda sky, it: ends(sky, length=it), "length", 2.0, 120 * u.arcmin),
    "identify exposure": (lambda sky, it: ends(sky, exposure=it), "exposure", 30.0, 0.5 * u.min),
    "identify place_sigma": (lambda sky, it: ends(sky, place_sigma=it), "place_sigma", 30.0, 0.5 * u.arcmin),
    "identify time_sigma": (lambda sky, it: ends(sky, time_sigma=it), "time_sigma", 1.0, 1000 * u.ms),
    "identify angle_sigma": (lambda sky, it: ends(sky, angle_sigma=it), "angle_sigma", 2.0, 120 * u.arcmin),
    "identify ends": (
        lambda sky, it: sky.identify(it, start=START, exposure=30.0, output="dict"), "ends", [[198.0, 7.0], [199.5, 8.0]],
        [[198.0, 7.0], [199.5, 8.0]] * u.deg,
    ),
    "inject exposure": (lambda sky, it: injected(sky, exposure=it), "exposure", 30.0, 0.5 * u.min),
    "inject streak_density": (
        lambda sky, it: injected(sky, random_streaks=None, streak_density=it), "streak_density", 0.5, (0.5 / u.deg**2).to(1 / u.sr),
    ),
    "inject magnitude": (lambda sky, it: injected(sky, magnitude=it), "magnitude", 5.0, 5.0 * u.mag),
    "inject magnitude AB": (lambda sky, it: injected(sky, magnitude=it), "magnitude", 5.0, 5.0 * u.ABmag),
    "inject magnitudes": (lambda sky, it: injected(sky, magnitude=it), "magnitude", (4.0, 6.0), (4.0, 6.0) * u.mag),
    "inject magnitudes of a pair": (lambda sky, it: injected(sky, magnitude=it), "magnitude", (4.0, 6.0), (4.0 * u.ABmag, 6.0 * u.mag)),
    "inject streak_rate_deg_s": (lambda sky, it: injected(sky, streak_rate_deg_s=it), "streak_rate_deg_s", 0.5, 30.0 * u.arcmin / u.s),
    "inject streak rates": (
        lambda sky, it: injected(sky, streak_rate_deg_s=it), "streak_rate_deg_s", (0.25, 0.5), [15.0, 30.0] * u.deg / u.min,
    ),
    "inject zero_point": (lambda sky, it: injected(sky, zero_point=it), "zero_point", 25.0, 25.0 * u.ABmag),
    "inject zero_point_1s": (lambda sky, it: injected(sky, zero_point=None, zero_point_1s=it), "zero_point_1s", 25.0, 25.0 * u.mag),
    "inject gain": (lambda sky, it: injected(sky, gain=it), "gain", 2.0, 2.0 * u.electron / u.adu),
    "inject gain in counts": (lambda sky, it: injected(sky, gain=it), "gain", 2.0, 2.0 * u.electron / u.ct),
    "inject seeing": (lambda sky, it: injected(sky, seeing=it), "seeing", "10arcmin", 600.0 * u.arcsec),
    "inject track_rate": (lambda sky, it: crossed_frame(sky, track_rate=it), "track_rate", (60.0, -120.0), [1.0, -2.0] * u.arcmin / u.s),
    "inject tumbling": (
        lambda sky, it: crossed_frame(sky, tumbling=it), "tumbling", (0.5, 1.0, 0.25), (500 * u.ms, 1.0 * u.mag, 90 * u.deg),
    ),
    "inject glints": (lambda sky, it: crossed_frame(sky, glints=it), "glints", [(3.0, 0.0, 0.5)], [(3.0 * u.ABmag, 0.0 * u.s, 500 * u.ms)]),
    "learn observed": (lambda sky, it: learned(sky, observed=it), "observed", [7.0, 7.2], [7.0, 7.2] * u.mag),
    "learn predicted": (lambda sky, it: learned(sky, predicted=it), "predicted", [6.0, 6.1], [6.0, 6.1] * u.ABmag),
    "learn sigma": (lambda sky, it: learned(sky, sigma=it), "sigma", 0.2, 0.2 * u.mag),
    "model lat": (lambda sky, it: setup(sky, lat=it), "lat", -30.0, -1800 * u.arcmin),
    "model lon": (lambda sky, it: setup(sky, lon=it), "lon", -70.0, -4200 * u.arcmin),
    "model height": (lambda sky, it: setup(sky, height=it), "height", 2500.0, 2.5 * u.km),
    "model site": (
        lambda sky, it: setup(sky, site={"latitude_deg": it, "longitude_deg": -70.0}), "latitude_deg", -30.0, -1800 * u.arcmin,
    ),
    "model fov": (lambda sky, it: setup(sky, fov=it), "fov", "3.5deg", 210 * u.arcmin),
    "model width and height": (lambda sky, it: setup(sky, fov=it), "fov", "3.0x2.0deg", [180, 120] * u.arcmin),
    "model limit_mag": (lambda sky, it: setup(sky, limit_mag=it), "limit_mag", 6.5, 6.5 * u.mag),
    "model limit_mag by band": (lambda sky, it: setup(sky, limit_mag={"g": 6, "default": it}), "limit_mag", 6.5, 6.5 * u.ABmag),
    "model extinction": (lambda sky, it: setup(sky, extinction=it), "extinction", 0.2, 0.2 * u.mag),
    "model max_delay": (lambda sky, it: setup(sky, max_delay=it), "max_delay", "600s", 10 * u.min),
    "model policy": (lambda sky, it: setup(sky, policy={"limit_mag": 7, "margin_s": it}), "margin_s", 6.0, 0.1 * u.min),
    "with_options fov": (lambda sky, it: sky.with_options(fov=it).field_radius_deg, "fov", "1.0deg", 60 * u.arcmin),
    "standard_magnitudes sun_latitude": (
        lambda sky, it: streakcast.standard_magnitudes("v2mini", it, 0, -60), "sun_latitude", -10.0, -600 * u.arcmin,
    ),
    "standard_magnitudes height": (
        lambda sky, it: streakcast.standard_magnitudes("v2mini", -10, 0, -60, height=it), "height", 500.0, 5e5 * u.m,
    ),
    "sky_magnitudes altitude": (
        lambda sky, it: streakcast.sky_magnitudes("v2mini", 0.0, it, sun_altitude=-20), "altitude", [30.0, 60.0], [1800, 3600] * u.arcmin,
    ),
    "sky_magnitudes sun_altitude": (
        lambda sky, it: streakcast.sky_magnitudes("v2mini", 0.0, 60.0, sun_altitude=it), "sun_altitude", -20.0, -1200 * u.arcmin,
    ),
    "sky_map step": (lambda sky, it: streakcast.sky_map("v2mini", sun_altitude=-20, step=it, output="dict"), "step", 5.0, 300 * u.arcmin),
    "sky_map height_m": (
        lambda sky, it: streakcast.sky_map("v2mini", sun_altitude=-20, step=5, lat=-30.0, lon=-70.0, height_m=it, output="dict"),
        "height", 2500.0, 2.5 * u.km,
    ),
    "body_map sun_latitude": (
        lambda sky, it: streakcast.body_map("v2mini", sun_latitude=it, step=5, output="dict"), "sun_latitude", -10.0, -600 * u.arcmin,
    ),
    "night exposure": (lambda sky, it: night(sky, exposure=it), "exposure", 30.0, 0.5 * u.min),
    "night limit_mag": (lambda sky, it: night(sky, limit_mag=it), "limit_mag", 7.0, 7.0 * u.ABmag),
    "night utc_offset": (lambda sky, it: night(sky, utc_offset=it), "utc_offset", -4.0, -240 * u.min),
    "field fov_deg": (
        lambda sky, it: plots.field(sky.passes(TARGET, START, 30.0), TARGET, fov_deg=it).svg(), "fov_deg", 3.5, 210 * u.arcmin,
    ),
    "sky_rate sun_azimuth_deg": (
        lambda sky, it: plots.sky_rate([0, 1], [0.0, 1.0], nside=4, sun_azimuth_deg=it).svg(), "sun_azimuth_deg", 240.0, 14400 * u.arcmin,
    ),
    "sun_altitude bin_deg": (lambda sky, it: plots.sun_altitude([-5.0, -9.0], [1, 2], bin_deg=it).svg(), "bin_deg", 3.0, 180 * u.arcmin),
    "sun_altitude sun_altitude_deg": (lambda sky, it: plots.sun_altitude(it, [1, 2]).svg(), "sun_altitude_deg", [-5.0, -9.0], [-300, -540] * u.arcmin),
    "Hook watch_s": (lambda sky, it: Hook(sky, "test", watch_s=it)._state.watch_s, "watch_s", 60.0, 1 * u.min),
}
#: Arguments that need a unit: a number without one is rejected.
TEXTS = {"seeing", "fov", "max_delay"}


@pytest.mark.parametrize("name", CASES)
def test_a_quantity_gives_the_same_result_as_a_number(sky, name):
    function, _, number, quantity = CASES[name]
    np.testing.assert_equal(function(sky, quantity), function(sky, number))


@pytest.mark.parametrize("name", CASES)
def test_a_wrong_unit_is_reported_with_the_argument(sky, name):
    function, argument, number, _ = CASES[name]
    numbers = 1.0 if argument in TEXTS else number
    wrong = [tuple(one * u.kg for one in numbers[0])] if argument == "glints" else numbers * u.kg
    with pytest.raises((TypeError, ValueError), match=rf"^{argument}\S* has the unit 'kg'.*; allowed: ") as caught:
        function(sky, wrong)
    assert "\n" not in str(caught.value)


def test_magnitudes_of_other_systems_and_fluxes_are_rejected(sky):
    for wrong in (6.5 * u.STmag, 1.0 * u.Jy):
        with pytest.raises(ValueError, match="limit_mag has the unit .*; allowed: a number of mag or a Quantity"):
            sky.passes(TARGET, START, 30.0, limit_mag=wrong)
    with pytest.raises(ValueError, match="allowed: one number, or the shape"):
        sky.passes((198.9, [7.7, 7.8]), START, 30.0, limit_mag=[6.0, 7.0, 8.0])


def test_columns_of_tables_are_read_with_their_units(sky):
    """A column of a `Table` has a unit, but is not a `Quantity`."""
    expected = sky.assess(([198.9, 198.9], 7.7), START, [30.0, 60.0])
    plain = Table({"ra": [198.9, 198.9] * u.deg, "exposure": [0.5, 1.0] * u.min})
    for table in (plain, QTable(plain)):
        np.testing.assert_equal(sky.assess((table["ra"], 7.7), START, table["exposure"]), expected)
    with pytest.raises(ValueError, match="exposure has the unit 'deg'"):
        sky.assess((198.9, 7.7), START, plain["ra"])
    for masked in (MaskedColumn([30.0, 60.0], mask=[False, True], unit="s"), Masked([30.0, 60.0] * u.s, mask=[False, True])):
        with pytest.raises(ValueError, match=r"exposure\[1\] is masked"):
            sky.assess(TARGET, START, masked)


def test_the_site_of_a_host_has_units(sky):
    site = sky.site
    numbers = (site.latitude_deg, site.longitude_deg, site.height_m)
    quantities = ((numbers[0] * u.deg).to(u.rad), numbers[1] * u.deg, numbers[2] / 1000 * u.km)
    assert hook_site(sky, numbers) == hook_site(sky, quantities) == hook_site(sky, sky.location) == 0
    assert hook_site(sky, (numbers[0] * u.m, *numbers[1:])) == 1


def test_pixels_of_a_frame_have_the_unit_pix(sky, tmp_path):
    path = tmp_path / "frame.fits"
    header = frame_header()
    header["DATE-OBS"], header["TIMESYS"], header["EXPTIME"] = START.rstrip("Z"), "UTC", 30.0
    fits.PrimaryHDU(np.zeros((SIZE, SIZE), "float32"), header).writeto(path)
    corners = ((10.0, 10.0), (90.0, 80.0))
    plain, given = (sky.identify(pixels=one, frame=path, output="dict") for one in (corners, corners * u.pix))
    np.testing.assert_equal(given, plain)
    with pytest.raises(ValueError, match="pixels has the unit 'deg'"):
        sky.identify(pixels=corners * u.deg, frame=path)
    # Cells of a row of a table of streaks.
    row = QTable({name: [value] * u.pix for name, value in zip(("x1", "y1", "x2", "y2"), np.ravel(corners))})[0]
    cells = ((row["x1"], row["y1"]), (row["x2"], row["y2"]))
    np.testing.assert_equal(sky.identify(pixels=cells, frame=path, output="dict"), plain)
    with pytest.raises(ValueError, match=r"pixels\[1\]\[0\] has the unit 'deg'"):
        sky.identify(pixels=(cells[0], (90.0 * u.deg, row["y2"])), frame=path)
