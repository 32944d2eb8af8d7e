"""Errors contain the name of the argument, the index and the accepted values. No input causes a panic."""

import gzip
import warnings

import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import SkyCoord
from astropy.time import Time
from astropy.utils.masked import Masked

import streakcast
from conftest import ROOT, START, TARGET

GOOD = {"mpc": "X05", "shells": "starlink-gen1", "fov": "3.5deg"}


@pytest.mark.parametrize(
    "ra, dec, exposure, rotation, message",
    [
        ([10.0, np.nan], 0.0, 30.0, 0.0, r"ra\[1\] is NaN deg; allowed: -180 to 360 deg"),
        ([10.0, 361.0], 0.0, 30.0, 0.0, r"ra\[1\] is 361 deg"),
        (10.0, [0.0, 0.0, -90.1], 30.0, 0.0, r"dec\[2\] is -90.1 deg; allowed: -90 to 90 deg"),
        (10.0, np.inf, 30.0, 0.0, r"dec\[0\] is inf deg"),
        (10.0, 0.0, [30.0, -1.0], 0.0, r"exposure\[1\] is -1 s; allowed: above 0 s, at most 86400 s"),
        (10.0, 0.0, 1e300, 0.0, r"exposure\[0\]"),
        (10.0, 0.0, 30.0, np.nan, r"rotation\[0\] is NaN deg"),
        ([1.0, 2.0], [1.0, 2.0, 3.0], 30.0, 0.0, r"shapes cannot be broadcast together: ra \(2,\), dec \(3,\)"),
        (np.ma.MaskedArray([1.0, 2.0], mask=[False, True]), 0.0, 30.0, 0.0, r"ra\[1\] is masked"),
        (10.0, 0.0, 30.0 * u.deg, 0.0, "exposure has the unit 'deg', which cannot be converted to s; allowed: a number of s"),
    ],
)
def test_bad_numbers(model, ra, dec, exposure, rotation, message):
    for method in (model.assess, model.flag, model.passes):
        with pytest.raises(ValueError, match=message):
            method((ra, dec), START, exposure, rotation=rotation)


@pytest.mark.parametrize("target", [None, 10.0, "10 20", (1.0,), (1.0, 2.0, 3.0), ("a", "b"), (None, 1.0), {"ra": 1}])
def test_invalid_targets(model, target):
    with pytest.raises(TypeError, match="allowed"):
        model.assess(target, START, 30.0)


@pytest.mark.parametrize(
    "target",
    [
        [(150.0, -20.0), (60.0, -70.0)],
        [[150.0, 60.0], [-20.0, -70.0]],
        [np.array([150.0, 60.0]), np.array([-20.0, -70.0])],
        [(150.0, -20.0), (60.0, -70.0), (70.0, -60.0)],
        [150.0 * u.deg, [-20.0, -70.0] * u.deg],
    ],
)
def test_a_list_of_positions_is_not_read_as_two_axes(model, target):
    for method in (model.assess, model.flag, model.passes):
        with pytest.raises(TypeError, match="target is a list of sequences; .* an array of right ascensions and an array of decl"):
            method(target, START, 30.0)


def test_a_list_of_two_numbers_is_a_target(model):
    expected = model.assess(TARGET, START, 30.0)
    for target in (list(TARGET), [one * u.deg for one in TARGET], np.array(TARGET).tolist()):
        np.testing.assert_equal(model.assess(target, START, 30.0), expected)
    np.testing.assert_equal(model.assess(([TARGET[0]], [TARGET[1]]), START, 30.0).n_streaks, [expected.n_streaks])


def test_masked_targets(model):
    for masked in (
        SkyCoord(Masked([198.9, 150.0] * u.deg, mask=[False, True]), [7.7, -20.0] * u.deg),
        SkyCoord([198.9, 150.0] * u.deg, Masked([7.7, -20.0] * u.deg, mask=[False, True])).galactic,
    ):
        with pytest.raises(ValueError, match=r"target\[1\] is masked; allowed"):
            model.assess(masked, START, 30.0)


@pytest.mark.parametrize(
    "start, message",
    [
        ("2026-13-14T23:29:05Z", "month 13 is out of range"),
        ("yesterday Z", "invalid time"),
        ("1900-01-01T00:00:00Z", "allowed: the years 1957 to 2099"),
        ("2100-01-01T00:00:01Z", "allowed: the years 1957 to 2099"),
        (Time(1e7, format="jd", scale="tai"), "allowed: the years 1957 to 2099"),
        (["2026-08-14T23:29:05Z", "2026-08-14T23:29:61Z"], r"\[1\].*second 61 is out of range"),
    ],
)
def test_bad_times(model, start, message):
    with pytest.raises(ValueError, match=message):
        model.assess(TARGET, start, 30.0)


@pytest.mark.parametrize("mjd", [np.nan, np.inf, -1e300, 1e300, 2461266.5, 0.0])
def test_bad_mjd(model, mjd):
    with pytest.raises(ValueError, match=r"mjd\[0\]|time\[0\]"):
        model.assess(TARGET, mjd, 30.0, scale="utc")


def test_masked_times(model):
    times = Time([START[:-1], START[:-1]], scale="utc").copy()
    times[1] = np.ma.masked
    texts = np.ma.MaskedArray([START, START], mask=[False, True])
    for masked in (times, list(times), texts):
        with pytest.raises(ValueError, match=r"start\[1\] is masked"):
            model.assess(TARGET, masked, 30.0)
    with pytest.raises(ValueError, match="start is masked; allowed"):
        model.assess(TARGET, times[1], 30.0)
    for mask in ([False, True], [True, True]):
        with pytest.raises(ValueError, match=rf"start\[{mask.index(True)}\] is masked"):
            model.assess(TARGET, np.ma.MaskedArray([61266.97, 61266.98], mask=mask), 30.0, scale="utc")


@pytest.mark.parametrize(
    "more, message",
    [
        ({"mpc": "ZZZ"}, "ZZZ"),
        ({"mpc": None}, "missing site"),
        ({"mpc": None, "site": "Rubbin"}, "Rubin"),
        ({"mpc": None, "site": {"latitude_deg": 91, "longitude_deg": 0}}, "91"),
        ({"mpc": None, "site": {"latitude": 9}}, "unknown key 'latitude'; allowed: "),
        ({"shells": None}, "missing satellites"),
        ({"shells": "starlink-gen9"}, "starlink-gen9"),
        ({"elements": "/nowhere/gp.json"}, "/nowhere/gp.json"),
        ({"elements": 7}, "allowed: a path"),
        ({"fov": 3.5}, "fov is '?3.5'?"),
        ({"fov": "3.5"}, "unit"),
        ({"fov": "0deg"}, "above 0 deg"),
        ({"telescope": "hubble"}, "hubble"),
        ({"limit_mag": 99}, "limit_mag is 99 mag; allowed: -30 to 40 mag"),
        ({"limit_surface_brightness": 99, "telescope": "rubin"}, "limit_surface_brightness is 99"),
        # Paths are not changed.
        ({"telescope": "/nowhere/limit-mag.toml"}, "/nowhere/limit-mag.toml"),
        ({"eop": "bright-share.txt"}, "bright-share.txt"),
        ({"limit_mag": "7"}, "limit_mag is '7'; allowed: a number, or numbers by band"),
        ({"limit_mag": "telescope"}, "limit_mag is 'telescope'; allowed: a number"),
        ({"limit_mag": True}, "limit_mag is True; allowed: a number"),
        ({"limit_mag": np.nan}, "limit_mag is nan; allowed: finite numbers"),
        ({"limit_mag": {"g": np.nan}}, r"limit_mag\['g'\] is nan"),
        ({"limit_mag": np.nan * u.mag}, "limit_mag is nan"),
        ({"policy": {"margin_s": np.inf}}, r"policy\['margin_s'\] is inf"),
        ({"mpc": None, "lat": np.nan, "lon": 0.0}, "lat is nan"),
        ({"mpc": None, "site": {"latitude_deg": np.nan, "longitude_deg": 0}}, r"site\['latitude_deg'\] is nan"),
        ({"extinction": np.inf}, "extinction is inf"),
        ({"extinction": "0.2"}, "extinction is '0.2'; allowed: a number"),
        ({"fov": (1.5, np.nan)}, r"fov\[1\] is nan"),
        ({"mpc": 568}, "mpc is 568; allowed: a string"),
        ({"mpc": None, "site": (-30, -70, 2600)}, "site is .-30, -70, 2600.; allowed: a name, an EarthLocation"),
        ({"sun_distance": 1}, "sun_distance is 1; allowed: True, False"),
        ({"observer_norad": 1.5}, "observer_norad is 1.5; allowed: a whole number"),
        ({"mjd_scale": 1}, "mjd_scale is 1; allowed: a string"),
        ({"policy": {"max_cost_s": -2.0}}, "above 0, at most 86400 s"),
        ({"policy": {"max_cost_s": "1s"}}, "invalid value \"1s\"; allowed: a number"),
        ({"policy": {"max_cost_s": 0.1}}, "missing telescope"),
        ({"bright_share": 0.3}, "missing telescope for bright_share"),
        ({"telescope": "rubin", "bright_share": -0.3}, "bright_share is -0.3; allowed: 0 to 100"),
        ({"policy": "/nowhere/policy.toml"}, "/nowhere/policy.toml"),
        ({"models": {"files": ["/nowhere/model.json"]}}, "/nowhere/model.json"),
        ({"models": {"generations": {"oneweb": "nothing"}}}, "nothing"),
        ({"model": "nothing"}, "nothing"),
        ({"model": {"oneweb": "nothing"}}, "nothing"),
        ({"model": {"twoweb": "oneweb"}}, "twoweb"),
        ({"model": 3}, "a name, a JSON file"),
        ({"band": "q"}, "q"),
        ({"mjd_scale": "local"}, "allowed: utc, tai, tt"),
        ({"observer_norad": 1}, "exclude each other|no elements"),
        ({"min_probability": 0}, "above 0"),
    ],
)
def test_bad_setups(more, message):
    with pytest.raises(streakcast.SetupError, match=message) as caught:
        built = streakcast.StreakModel(**{**GOOD, **more})
        built.assess(TARGET, START, 30.0)
    # Flags of the command line are replaced by argument names.
    assert "--" not in str(caught.value)


def test_invalid_exposures_leave_the_others(model):
    ra, dec = np.array([188.5, np.nan, 188.5, 188.5, 188.5]), np.array([-30.5, -30.5, 95.0, -30.5, -30.5])
    start, exposure = np.array([61_266.98, 61_266.98, 61_266.98, np.nan, 61_266.99]), 30.0
    expected = model.assess((ra[[0, 4]], dec[[0, 4]]), start[[0, 4]], exposure, scale="utc")
    for method in (model.assess, model.flag):
        with pytest.raises(ValueError, match="NaN"):
            method((ra, dec), start, exposure, scale="utc")
        found = method((ra, dec), start, exposure, scale="utc", keep_invalid=True)
        verdicts = found["verdict"] if method == model.flag else found.verdict
        assert np.asarray(verdicts)[1:4].tolist() == ["invalid"] * 3
        assert np.asarray(verdicts)[[0, 4]].tolist() == expected.verdict.tolist()


def test_invalid_numbers_are_counted_once(model):
    """The warning has the first reason. Pointings below the horizon have no invalid numbers."""
    dec, start = np.array([-30.5, 95.0, 89.0]), np.full(3, 61_266.98)
    new = model.with_options()
    expected = "1 of 3 exposures has a number missing or out of range, and is invalid; first row 1: dec is 95 deg; allowed: -90 to 90 deg"
    with pytest.warns(streakcast.StreakcastWarning, match=expected):
        found = new.assess((188.5, dec), start, 30.0, scale="utc", keep_invalid=True)
    assert found.verdict[1:].tolist() == ["invalid"] * 2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        new.assess((188.5, dec), start, 30.0, scale="utc", keep_invalid=True)
        model.with_options().assess((188.5, dec[2]), start, 30.0, scale="utc", keep_invalid=True)


@pytest.mark.parametrize("start", [np.nan, None, np.ma.masked, 1e9])
def test_missing_scalars_are_invalid(model, start):
    valid = model.assess((188.5, -30.5), 61_266.98, 30.0, scale="utc")
    assert model.assess((188.5, -30.5), 61_266.98, 30.0, scale="utc", keep_invalid=True) == pytest.approx(valid, nan_ok=True)
    assert model.assess((188.5, -30.5), start, 30.0, scale="utc", keep_invalid=True).verdict == "invalid"


def test_missing_cells_are_invalid(model):
    ra, dec, start = np.full(3, 188.5), np.full(3, -30.5), np.full(3, 61_266.98)
    mask = [False, True, False]
    expected = model.assess((ra, dec), start, 30.0, scale="utc").verdict.tolist()
    expected[1] = "invalid"
    for arguments in (
        ((np.ma.array(ra, mask=mask), dec), start, 30.0),
        ((ra, [-30.5, None, -30.5]), start, 30.0),
        (SkyCoord(Masked(ra * u.deg, mask=mask), Masked(dec * u.deg, mask=mask)), start, 30.0),
        ((ra, dec), np.ma.array(start, mask=mask), 30.0),
        ((ra, dec), [61_266.98, None, 61_266.98], 30.0),
        ((ra, dec), np.ma.array(start.astype(object), mask=mask), 30.0),
        ((ra, dec), Masked(start * u.d, mask=mask), 30.0),
        ((ra, dec), start, np.ma.array([30, 30, 30], mask=mask)),
    ):
        assert model.assess(*arguments, scale="utc", keep_invalid=True).verdict.tolist() == expected, arguments
        with pytest.raises((TypeError, ValueError)):
            model.assess(*arguments, scale="utc")
    with pytest.raises(TypeError, match="dec contains '12d'; allowed: numbers, or None"):
        model.assess((ra, [-30.5, None, "12d"]), start, 30.0, scale="utc", keep_invalid=True)
    for single in (np.float32(start), np.ma.array(np.float32(start), mask=mask)):
        with pytest.raises(TypeError, match="start is float32"):
            model.assess((ra, dec), single, 30.0, scale="utc", keep_invalid=True)


def test_settings_in_quoted_values_are_not_changed():
    with pytest.raises(ValueError, match="'limit-mag'"):
        streakcast.StreakModel(**GOOD, model="limit-mag")


def test_numpy_numbers_are_accepted():
    setup = {**GOOD, "mpc": None, "lat": np.float32(-30.5), "lon": np.float64(-70), "height": np.int64(2600)}
    model = streakcast.StreakModel(**setup, limit_mag={"g": np.float32(7.5)}, sun_distance=np.bool_(True), band=np.str_("g"))
    assert model.site is not None and model.site[1:] == (-30.5, -70.0, 2600.0)


def test_the_limits_of_a_telescope_are_accepted_in_a_policy():
    streakcast.StreakModel(**GOOD, telescope="rubin", policy={"max_cost_s": 2.0}, bright_share=0.3)


def test_unknown_arguments():
    with pytest.raises(TypeError, match="no argument 'fov_deg'; allowed: .*fov"):
        streakcast.StreakModel(**GOOD, fov_deg=3.5)
    with pytest.raises(ValueError, match="allowed: error, warn"):
        streakcast.StreakModel(**GOOD, on_changed_file="ignore")
    with pytest.raises(TypeError, match="scale"):
        streakcast.StreakModel(**GOOD, epoch=61266.0)


def test_a_missing_field_is_reported_only_when_needed():
    model = streakcast.StreakModel(mpc="X05", shells="starlink-gen1")
    with pytest.raises(streakcast.SetupError, match="missing field of view; specify fov"):
        model.assess(TARGET, START, 30.0)
    assert model.field_radius_deg is None
    assert len(model.forecast(start=START, end="2026-08-14T23:30:05Z", max_sun_altitude=None).passes) > 0


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\x00\xff\xfe" * 1000,
        b"ISS\n1 25544U\n2 25544\n",
        gzip.compress(b"nothing")[:-4],
        b'[{"OBJECT_NAME": "A"',
        b"1 " * 100_000,
        "1 25544U 98067A   26189.73419088  .00005258  00000+0  10370-3 0  9990\n".encode(),
    ],
)
def test_broken_element_files(tmp_path, content):
    path = tmp_path / "broken.tle"
    path.write_bytes(content)
    with pytest.raises(streakcast.SetupError, match="broken.tle"):
        streakcast.StreakModel(mpc="X05", fov="1deg", elements=path)
    with pytest.raises(streakcast.SetupError, match=str(tmp_path)):
        streakcast.StreakModel(mpc="X05", fov="1deg", elements=tmp_path)


def test_hostile_numbers_never_panic(model):
    generator = np.random.default_rng(7)
    extremes = np.array([0.0, -0.0, 1e-300, 1e300, -1e300, np.inf, -np.inf, np.nan, 90.0, -90.0, 360.0, 5e-324, 86_400.0])
    accepted = 0
    for _ in range(400):
        ra, dec, mjd, exposure, rotation = generator.choice(np.append(extremes, [61266.97, 30.0]), 5)
        try:
            model.assess((ra, dec), mjd, exposure, rotation=rotation, scale="tai")
            accepted += 1
        except ValueError:
            pass
    for pole in (90.0, -90.0):
        model.assess(([0.0, 360.0, -180.0], pole), 61266.97, 30.0, scale="utc")
    with pytest.raises(ValueError, match=r"exposure\[0\] is 0 s; allowed: above 0 s, at most 86400 s"):
        model.flag(TARGET, START, 0.0)


def test_bad_maps():
    with pytest.raises(streakcast.SetupError, match="unknown model 'v3'; allowed: "):
        streakcast.body_map("v3", sun_latitude=-10)
    with pytest.raises(ValueError, match="allowed"):
        streakcast.sky_map("v2mini", sun_altitude=-100)
    with pytest.raises(ValueError, match="exclude each other"):
        streakcast.sky_map("v2mini", sun_altitude=-10, step=2, nside=8)
    with pytest.raises(ValueError, match=r"altitude\[1\] is -1 deg"):
        streakcast.sky_magnitudes("v2mini", 0.0, [10.0, -1.0], sun_altitude=-10)
    with pytest.raises(ValueError, match=r"height\[0\]"):
        streakcast.standard_magnitudes("v2mini", -10, 0, -60, height=np.nan)
    for nside in (-1, 0):
        with pytest.raises(ValueError, match=f"nside is {nside}; allowed: 1 or more"):
            streakcast.sky_map("v2mini", sun_altitude=-10, nside=nside)
        with pytest.raises(ValueError, match=f"nside is {nside}; allowed: 1 or more"):
            streakcast.body_map("v2mini", sun_latitude=-10, nside=nside)


@pytest.mark.parametrize(
    "function, arguments, wrong",
    [
        ("sky_map", dict(sun_altitude=-10), dict(learned="learned.json")),
        ("sky_map", dict(sun_altitude=-10), dict(fov="1deg")),
        ("sky_map", dict(sun_altitude=-10), dict(limit_mag=7)),
        ("sky_map", dict(sun_altitude=-10), dict(elevation=100)),
        ("sky_magnitudes", dict(azimuth=0, altitude=60, sun_altitude=-10), dict(learned="learned.json")),
        ("body_map", dict(sun_latitude=-10), dict(site="Rubin Observatory")),
        ("standard_magnitudes", dict(sun_latitude=-10, observer_longitude=0, observer_latitude=-60), dict(extinction=0.5)),
    ],
)
def test_arguments_without_effect_on_light_are_rejected(function, arguments, wrong):
    (name,) = wrong
    with pytest.raises(TypeError, match=f"^{function} has no argument '{name}'; allowed: .*band, mag_system"):
        getattr(streakcast, function)("v2mini", **arguments, **wrong)
    options = streakcast.typing.SkyLightOptions if function.startswith("sky") else streakcast.typing.LightOptions
    getattr(streakcast, function)("v2mini", **arguments, **dict.fromkeys(options.__annotations__))


def test_bad_windows(model):
    with pytest.raises(ValueError, match=r"end\[0\] is before the start"):
        model.windows(TARGET, START, "2026-08-14T23:00:00Z", 30.0)
    with pytest.raises(ValueError, match="allowed: any, avoid"):
        model.windows(TARGET, START, "2026-08-15T00:00:00Z", 30.0, blocking="all")
    with pytest.raises(ValueError, match=r"end\[0\] is 174655 s after the start; allowed: at most one day"):
        model.windows(TARGET, START, "2026-08-17T00:00:00Z", 30.0)
    with pytest.raises(ValueError, match=r"end\[1\] is 86400.5 s after the start"):
        model.windows(TARGET, START, Time(START) + [86_400.0, 86_400.5] * u.s, 30.0)
    with pytest.raises(ValueError, match="bands for 1 exposures|1 exposures"):
        model.assess(TARGET, START, 30.0, band=["g", "r"])
    empty = model.windows(SkyCoord([], [], unit="deg"), START, "2026-08-15T00:00:00Z", 30.0)
    assert len(empty.target) == 0
    # There is no window for an exposure that is longer than the time span.
    assert len(model.windows(TARGET, START, "2026-08-14T23:30:00Z", 300.0).target) == 0


def test_a_negative_number_of_samples(model):
    with pytest.raises(ValueError, match="samples is -1; allowed: 0 or more"):
        model.passes(TARGET, START, 30.0, samples=-1)
    with pytest.raises(TypeError, match="samples is 1.5; allowed: integers, 0 or more"):
        model.passes(TARGET, START, 30.0, samples=1.5)


def test_a_configuration_file_is_equivalent_to_arguments():
    path = ROOT / "examples" / "streakcast.toml"
    model = streakcast.StreakModel(config=path)
    assert model.site is not None and model.assess(TARGET, START, 30.0).verdict in ("clear", "streaked", "avoid")
    over = streakcast.StreakModel(config=path, fov="1deg")
    assert over.field_radius_deg == pytest.approx(0.5)


def test_an_argument_replaces_the_keys_that_answer_the_same_question(tmp_path):
    path = tmp_path / "obs.toml"
    path.write_text("shells = 'starlink-gen1'\nfov = '1deg'\nlimb_height_km = 50\nobserver_norad = 20580\n")
    # A telescope has a field of view, and a site replaces a telescope in orbit with the height of its limb.
    model = streakcast.StreakModel(config=path, telescope="rubin", mpc="X05")
    assert model.field_radius_deg == pytest.approx(1.75, rel=0.1) and model.site is not None
    with pytest.raises(streakcast.SetupError, match="obs.toml: line 4: missing telescope in orbit"):
        path.write_text("shells = 'starlink-gen1'\nmpc = 'X05'\nfov = '1deg'\nlimb_height_km = 50\n")
        streakcast.StreakModel(config=path).assess(TARGET, START, 30.0)


def test_limits_of_a_telescope_in_orbit_are_those_of_its_pointings():
    orbit = {"shells": "oneweb", "observer_elements": ROOT / "tests" / "data" / "elements" / "sample.2le", "fov": "3deg"}
    start = "2026-03-21T06:00:00Z"
    # The Sun is near RA 0, Dec 0 at the equinox; one of two opposite fields is not behind the Earth.
    for limits, reason in [
        ({"min_sun_angle": 179.0}, "deg from the Sun; allowed: 179 deg or more"),
        ({"max_zenith_angle": 0.01 * u.deg}, "deg from the zenith of the telescope; allowed: 0.01 deg or less"),
        ({"min_limb_angle": 179.0}, "deg from the Earth's limb; allowed: 179 deg or more"),
    ]:
        model = streakcast.StreakModel(**orbit, **limits)
        found = model.flag(SkyCoord([90, 270], [0, 0], unit="deg"), start, 10.0, output="dict")
        assert list(found["verdict"]) == ["invalid"] * 2
        reasons = [" ".join(one) for one in found["reasons"]]
        assert any(reason in one for one in reasons), reasons
    with pytest.raises(streakcast.SetupError, match="min.sun.angle is a limit of a telescope in orbit"):
        streakcast.StreakModel(shells="oneweb", mpc="X05", fov="3deg", min_sun_angle=30.0).assess(TARGET, START, 30.0)


def test_tables_of_verbs_are_for_the_command_line(tmp_path):
    path = tmp_path / "obs.toml"
    path.write_text("shells = 'starlink-gen1'\nmpc = 'X05'\nfov = '1deg'\n[forecast]\nmax_mag = 5\n")
    assert streakcast.StreakModel(config=path).field_radius_deg == pytest.approx(0.5)
    path.write_text("shells = 'starlink-gen1'\nmpc = 'X05'\nfov = '1deg'\n[forcast]\nmax_mag = 5\n")
    with pytest.raises(streakcast.SetupError, match="unknown key 'forcast'; did you mean forecast"):
        streakcast.StreakModel(config=path).assess(TARGET, START, 30.0)


@pytest.mark.parametrize(
    "arguments",
    [dict(lat=np.ma.masked, lon=-70.0), dict(lat=-30.0, lon=-70.0, height=np.ma.masked), dict(mpc="X05", extinction=np.ma.masked),
     dict(mpc="X05", limit_mag=np.ma.masked), dict(mpc="X05", policy={"limit_mag": np.ma.masked})],
)  # fmt: skip
def test_masked_settings_are_errors(arguments):
    with pytest.raises(ValueError, match="is masked"):
        streakcast.StreakModel(shells="starlink-gen1", fov="3.5deg", **arguments)


def test_bands_as_bytes_have_their_limits():
    model = streakcast.StreakModel(mpc="X05", shells="starlink-gen1", fov="3.5deg", limit_mag={"z": 3, "g": 8, "default": -5})
    verdicts = [model.assess(TARGET, START, 30.0, band=band).verdict for band in ("g", b"g", np.array([b"g"]), np.array(["g"]))]
    assert verdicts[0] == "avoid" and {str(np.ravel(verdict)[0]) for verdict in verdicts} == {"avoid"}
    with pytest.raises(TypeError, match="band is of the type int64"):
        model.assess(TARGET, START, 30.0, band=3)


def test_options_of_one_question_replace_each_other():
    model = streakcast.StreakModel(mpc="X05", shells="starlink-gen1", fov="1deg", limit_mag=7)
    rubin = model.with_options(telescope="rubin")
    assert rubin.field_area_deg2 == streakcast.StreakModel(mpc="X05", shells="starlink-gen1", telescope="rubin").field_area_deg2
    assert rubin.with_options(fov="1deg").field_area_deg2 == pytest.approx(0.785, abs=1e-3)
    field = model.with_options(field={"circle_deg": 2.0})
    assert field.field_area_deg2 == pytest.approx(3.14, abs=0.01)
    wide = streakcast.StreakModel(mpc="X05", shells="starlink-gen1", fov="3.5deg", limit_mag=7)
    assert wide.assess(TARGET, START, 30.0).verdict == "avoid"
    assert wide.with_options(policy={"limit_mag": 3}).assess(TARGET, START, 30.0).verdict == "streaked"


def test_errors_are_short_and_name_the_nearest_argument():
    with pytest.raises(TypeError, match="did you mean limit_mag?"):
        streakcast.StreakModel(mpc="X05", shells="starlink-gen1", limt_mag=7)
    model = streakcast.StreakModel(mpc="X05", shells="starlink-gen1", fov="1deg")
    with pytest.raises(TypeError, match="did you mean fov?"):
        model.with_options(fovv="1deg")
    long = "z" * 5000
    for arguments in ({long: 1}, {"policy": {long: 1}}, {"limit_mag": long}, {"band": [long]}):
        with pytest.raises((TypeError, streakcast.SetupError)) as caught:
            streakcast.StreakModel(mpc="X05", shells="starlink-gen1", fov="1deg", **arguments)
        assert len(str(caught.value)) <= 1000
