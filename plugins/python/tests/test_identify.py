"""Identification of streaks: results equal those of the command line program; real streaks of known satellites."""

import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import SkyCoord
from astropy.time import Time

from conftest import START, TARGET
from test_forecast import assert_equal
import streakcast


@pytest.fixture(scope="module")
def sky():
    return streakcast.StreakModel(mpc="X05", shells="starlink-gen1", fov="3.5deg")


@pytest.fixture(scope="module")
def crossing(sky):
    return sky.passes(TARGET, START, 30.0, output="dict")


def assert_same(result, answer):
    assert len(result.candidates) == len(answer["candidates"]) > 0
    for table, section in ((result.candidates, "candidates"), (result.streak, "streak")):
        for row, expected in zip(table, answer[section]):
            for name, value in expected.items():
                assert_equal(row[name], value, name)
    options = answer["provenance"]["options"]
    assert result.n_candidates == options["candidates"]
    # The command line program prints six decimals.
    assert round(result.unknown_probability, 6) == pytest.approx(float(options["unknown_probability"]), abs=1e-12)


def test_valid_and_verif_regions_of_the_plaskett_telescope(data, command_line):
    """Boley et al. (2021): box N belongs to row N (from 0) of their target list, with mid-times of 30 s exposures."""
    folder = data / "photometry" / "boley2021_plaskett"
    elements = folder / "starlink.15JUL2021"
    model = streakcast.StreakModel(mpc="658", elements=elements)
    rows = [line.split(".txt: ") for line in (folder / "plan.ran").read_text().splitlines()]
    boxes = sorted((folder / "regFiles").glob("*.reg"))
    assert len(boxes) == 13 and len({box.stem.split("-")[1] for box in boxes}) == 11
    for box in boxes:
        name, rest = rows[int(box.stem.split("-")[1])]
        start = Time(f"2021-07-16T{rest.split()[1]}", scale="utc") - 15 * u.s
        result = model.identify(region=box, start=start, exposure=30 * u.s)
        first = result.candidates[0]
        assert first["name"] == name and first["probability"] > 0.99
        assert abs(first["along_track_offset_s"]) < 1 * u.s
        start.precision = 9
        answer = command_line(
            "identify", "--region", str(box), "--start", f"{start.isot}Z", "--exposure", "30s", "--elements", str(elements), "--mpc", "658"
        )
        assert_same(result, answer)


def test_verif_every_form_of_a_streak(sky, crossing, command_line):
    arguments = ["identify", "--shells", "starlink-gen1", "--mpc", "X05"]
    k = int(np.nanargmin(crossing["magnitude_peak"]))
    column = {name: values[k] for name, values in crossing.items()}
    ends = [(column[f"{end}_ra_deg"], column[f"{end}_dec_deg"]) for end in ("enter", "exit")]
    times = [column[f"{end}_utc"] for end in ("enter", "exit")]
    text = [f"{ra!r},{dec!r}".replace("np.float64(", "").replace(")", "") for ra, dec in ends]
    shutter = ["--start", START, "--exposure", "30s"]
    middle = (column["mid_ra_deg"], column["mid_dec_deg"])
    position = [f"--ra={float(middle[0])!r}", f"--dec={float(middle[1])!r}", f"--position-angle={float(column['position_angle_deg'])!r}"]
    clock = [f"{np.datetime_as_string(time)}Z" for time in times]
    ways = [
        (dict(ends=ends, times=times, scale="utc"), [f"--end={text[0]}", f"--end={text[1]}", "--times", *clock]),
        (dict(ends=ends, start=START, exposure=30.0), [f"--end={text[0]}", f"--end={text[1]}", *shutter]),
        (dict(place=middle, position_angle=column["position_angle_deg"], start=START, exposure=30.0), [*position, *shutter]),
        (
            dict(
                place=middle, position_angle=column["position_angle_deg"] * u.deg, length=90 * u.arcmin, start=START, exposure=30.0,
                place_sigma=8.0, time_sigma=0.25 * u.s, angle_sigma=0.5, include_dark=True, top=2,
            ),
            [*position, *shutter, "--length", "1.5deg", "--place-sigma", "8arcsec", "--time-sigma", "0.25s", "--angle-sigma", "0.5deg",
             "--include-dark", "--top", "2"],
        ),
    ]  # fmt: skip
    for keywords, flags in ways:
        found = sky.identify(**keywords)
        assert found.candidates["norad_id"][0] == column["norad_id"], keywords
        assert_same(found, command_line(*arguments, *flags))
    sky_coord = sky.identify(SkyCoord(ends, unit="deg").galactic, Time(times, scale="utc"))
    assert sky_coord.candidates["norad_id"][0] == column["norad_id"]
    plain = sky.identify(ends, times, scale="utc", output="dict")
    assert plain.candidates["passage_utc"].dtype == np.dtype("datetime64[ns]")


def test_verif_a_frame_provides_position_and_time(data, command_line):
    fits = pytest.importorskip("astropy.io.fits")
    frame = data / "frames" / "trailblazer" / "cutout_c4d_200306_000415_ori.fits.fz"
    elements = data / "tle" / "supgp" / "starlink_supgp_2020-02-23.tle"
    with fits.open(frame) as file:
        hdu = file.index_of("S28")
    model = streakcast.StreakModel(mpc="W84", elements=elements)
    pixels = ((1.0, 68.5), (68.02, 1.0))
    found = model.identify(frame=frame, hdu=hdu, pixels=pixels, place_sigma=0.13 * u.arcsec)
    assert found.candidates["name"][0] == "STARLINK-1102"
    from_zero = model.identify(frame=frame, hdu=hdu, pixels=np.array(pixels) - 1, origin=0, place_sigma=0.13 * u.arcsec)
    assert from_zero.candidates["norad_id"][0] == found.candidates["norad_id"][0]
    np.testing.assert_allclose(
        from_zero.candidates["cross_track_offset_arcsec"].value, found.candidates["cross_track_offset_arcsec"].value, atol=1e-6
    )
    answer = command_line(
        "identify", "--elements", str(elements), "--mpc", "W84", "--image", str(frame), "--hdu", str(hdu), "--from-pix", "1,68.5",
        "--to-pix", "68.02,1", "--place-sigma", "0.13arcsec",
    )  # fmt: skip
    assert_same(found, answer)
    with pytest.raises(streakcast.StreakcastError, match="pixel 5000,1 is outside of the frame; allowed: X from 0.5 to"):
        model.identify(frame=frame, hdu=hdu, pixels=((1, 1), (5000, 1)))
    with pytest.raises(streakcast.StreakcastError, match="images; specify one with hdu"):
        model.identify(frame=frame, pixels=pixels)


def test_invalid_streaks_are_reported(sky, tmp_path):
    ends = ((198.0, 7.0), (199.0, 7.5))
    shutter = dict(start=START, exposure=30.0)
    region = tmp_path / "a.reg"
    region.write_text("fk5\ncircle(1,2,3\")\n")
    cases = [
        (dict(), "missing streak; allowed, one of: ends"),
        (dict(ends=ends, region=region), "ends and region; allowed, one of"),
        (dict(ends=ends), "missing start of the exposure"),
        (dict(ends=ends, start=START), "missing exposure time; specify exposure"),
        (dict(ends=ends, times=[START]), r"times have the shape \(1,\); allowed: two values"),
        (dict(ends=ends, times=[START, START]), "the second of times is 0 s after the first"),
        (dict(ends=ends, times=[START, START], **shutter), "times exclude start, exposure and whole_streak"),
        (dict(ends=(ends[0], ends[0]), **shutter), "both ends of the streak are at the same position"),
        (dict(ends=(ends[0],), **shutter), "allowed: two positions"),
        (dict(ends=((10, 80), (11, 80)), **shutter), "the streak is below the horizon of Rubin Observatory"),
        (dict(ends=ends, place_sigma=0.0, **shutter), "place_sigma is 0.0 arcsec; allowed: above 0 arcsec"),
        (dict(ends=ends, length=1.0, **shutter), "length is accepted with place only, not with ends"),
        (dict(place=ends[0], **shutter), "missing position_angle of the streak at place"),
        (dict(place=ends[0], position_angle=400, **shutter), "position angle is 400"),
        (dict(place=ends[0], position_angle=4, whole_streak=True, **shutter), "a streak of known length"),
        (dict(place=ends[0], position_angle=np.nan, **shutter), "position_angle is nan"),
        (dict(pixels=((1, 2), (3, 4)), **shutter), "missing frame of the pixels"),
        (dict(pixels=((1, 2, 3), (3, 4, 5)), frame="x.fits"), "allowed: two pairs"),
        (dict(pixels=((1, 2), (3, 4)), frame="x.fits", origin=2), "origin is 2; allowed: 0, 1"),
        (dict(streaks=dict(x1_pix=[1]), frame="x.fits", origin=0), "origin is 0; allowed with streaks: omitted"),
        (dict(ends=ends, hdu=0, **shutter), "hdu is given without frame; allowed: with frame or streaks"),
        (dict(streaks=dict(x1_pix=[1]), exposure=-5.0), "^exposure is -5 s; allowed: above 0 s"),
        (dict(region=region, **shutter), "a.reg: line 2: unsupported shape 'circle'"),
        (dict(region="missing.reg", **shutter), "missing.reg"),
        (dict(ends=ends, top=0, **shutter), "top is 0; allowed: 1 or more"),
    ]
    for options, message in cases:
        with pytest.raises(ValueError, match=message):
            sky.identify(**options)
    with pytest.raises(TypeError, match="scale"):
        sky.identify(ends=ends, start=61266.9, exposure=30.0)
    with pytest.raises(TypeError, match="allowed: a SkyCoord of two"):
        sky.identify(ends="here", **shutter)


def test_no_candidates_is_a_valid_result(sky):
    # Far in the south, where no satellite of inclination 53 degrees passes.
    found = sky.identify(((10.0, -86.5), (12.0, -86.6)), start=START, exposure=1.0)
    assert len(found.candidates) == found.n_candidates == 0 and found.unknown_probability == pytest.approx(1.0)
