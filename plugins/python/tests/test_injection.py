"""Injection into files and arrays: results equal those of the command line program; errors for invalid arguments."""

import json
import os
import subprocess

import numpy as np
import pytest

import streakcast

fits = pytest.importorskip("astropy.io.fits")
from astropy import units as u  # noqa: E402
from astropy.time import Time  # noqa: E402
from astropy.wcs import WCS  # noqa: E402

from conftest import START, TARGET  # noqa: E402
from test_threads import ENOUGH, steps_while  # noqa: E402

SIZE = 600
#: A frame with a width of 3.5° is crossed by satellites at this time.
SCALE_DEG = 3.5 / SIZE


def header(**more):
    wcs = WCS(naxis=2)
    wcs.wcs.ctype = ["RA---TAN", "DEC--TAN"]
    wcs.wcs.crval = TARGET
    wcs.wcs.crpix = [(SIZE + 1) / 2] * 2
    wcs.wcs.cdelt = [-SCALE_DEG, SCALE_DEG]
    cards = wcs.to_header()
    cards["DATE-OBS"], cards["TIMESYS"], cards["EXPTIME"] = START.rstrip("Z"), "UTC", 30.0
    cards["MAGZP"], cards["GAIN"] = 25.0, 2.0
    cards.update(more)
    return cards


def pixels(dtype):
    return np.random.default_rng(5).normal(500.0, 20.0, (SIZE, SIZE)).astype(dtype)


@pytest.fixture(scope="module")
def injector():
    """Returns a model with the options of the command line: V magnitudes, seeing of a telescope, no field."""
    return streakcast.StreakModel(mpc="X05", shells="starlink-gen1", telescope="rubin", epoch=START)


@pytest.fixture(scope="module")
def command(tmp_path_factory):
    """Returns a function that runs the command line program for the same frame."""
    folder = tmp_path_factory.mktemp("command")

    def run(frame, *arguments):
        source, target = folder / "frame.fits", folder / "injected.fits"
        fits.PrimaryHDU(frame, header()).writeto(source, overwrite=True)
        binary = os.environ.get("STREAKCAST_BIN") or pytest.fail("set STREAKCAST_BIN, or run plugins/test.sh")
        done = subprocess.run(
            [binary, "inject", "--image", source, "--output", target, "--quiet", *arguments],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return source, target

    return run


@pytest.mark.parametrize("dtype", ["float32", "float64", "uint16", "int16", "int32"])
def test_verif_arrays_and_files_equal_the_command_line_to_the_last_bit(injector, command, tmp_path, dtype):
    frame = pixels(dtype)
    source, target = command(frame, "--mpc", "X05", "--shells", "starlink-gen1", "--telescope", "rubin", "--seeing", "1arcmin", "--seed", "7")
    done = injector.inject(frame, header=header(), seeing="1arcmin", seed=7)
    with fits.open(target) as written:
        expected = written[0].data
        assert done.image.dtype == np.dtype(dtype) and done.image.shape == frame.shape
        np.testing.assert_array_equal(done.image, expected)
        np.testing.assert_array_equal(done.mask, written["STREAKMASK"].data)
        assert done.mask_planes == {"STREAK": written["STREAKMASK"].header["MP_STREAK"], "INJECTED": written["STREAKMASK"].header["MP_INJECTED"]}
        assert len(done.truth) == len(written["STREAKS"].data) > 0
        assert len(done.points) == len(written["STREAK_POINTS"].data)
        np.testing.assert_array_equal(done.truth["norad_id"], written["STREAKS"].data["norad_id"])
    # In single precision, the added light has seven digits.
    np.testing.assert_allclose(done.added, done.image.astype("f8") - frame, rtol=1e-6)
    assert (frame == pixels(dtype)).all(), "the array was changed"
    # Pixels in the wings that are fainter than the noise of the frame are not in the mask.
    injected = ((done.mask >> done.mask_planes["INJECTED"]) & 1).astype(bool)
    assert done.added[injected].sum(dtype=float) > 0.8 * done.added.sum(dtype=float) > 1000

    path = tmp_path / "array.fits"
    written = injector.inject(source, path, seeing="1arcmin", seed=7)
    assert written.path == path and written.image is None
    assert path.read_bytes() == target.read_bytes()


def test_verif_random_streaks_equal_the_command_line(command):
    frame = pixels("float32")
    options = ["--random-streaks", "3", "--magnitude", "5,7", "--seeing", "60arcsec", "--seed", "11", "--no-noise"]
    _, target = command(frame, *options)
    done = streakcast.inject(
        frame, header=header(), random_streaks=3, magnitude=(5, 7), seeing=60 * u.arcsec, seed=11, noise=False
    )
    np.testing.assert_array_equal(done.image, fits.getdata(target))
    other = streakcast.inject(
        frame, header=header(), random_streaks=3, magnitude=(5, 7), seeing="60arcsec", seed=12, noise=False
    )
    assert (other.image != done.image).any()


def test_a_wcs_and_arguments_instead_of_a_header(injector):
    frame = pixels("float32")
    expected = injector.inject(frame, header=header(), seeing="1arcmin", seed=3)
    arguments = dict(start=Time(START), exposure=30 * u.s, zero_point=25.0, gain=2.0, seeing="1arcmin", seed=3)
    done = injector.inject(frame, header=WCS(header()), **arguments)
    # The WCS formats its numbers again: positions may differ in the last digit, and fluxes by a few electrons of noise.
    assert len(done.truth) == len(expected.truth)
    assert abs(done.added.sum() / expected.added.sum() - 1) < 1e-3
    text = header().tostring(sep="\n")
    np.testing.assert_array_equal(injector.inject(frame, header=text, seeing="1arcmin", seed=3).image, expected.image)
    assert set(injector.inject(frame, header=text, seeing="1arcmin", table="dict").truth) == set(expected.truth.colnames)


def test_the_flux_of_a_streak_matches_its_magnitude():
    # A star of magnitude m gives 10^(-0.4 (m - ZP)) counts in the exposure. The streak has the fraction of its time in
    # the frame.
    done = streakcast.inject(
        np.zeros((SIZE, SIZE)), header=header(), random_streaks=1, magnitude=5.0, streak_rate_deg_s=0.5,
        seeing="1arcmin", psf="gaussian", noise=False, seed=4, table="dict",
    )  # fmt: skip
    (length_pix,) = done.truth["length_pix"]
    inside_s = length_pix * SCALE_DEG / 0.5
    assert inside_s > 1.0
    expected = 10 ** (-0.4 * (5.0 - 25.0)) * inside_s / 30.0
    # 1 % for the variable scale of the tangent plane, and for light of the ends outside the frame.
    assert done.added.sum() == pytest.approx(expected, rel=0.01)


def test_no_random_streaks_leave_the_frame_unchanged():
    frame = pixels("float32")
    done = streakcast.inject(frame, header=header(), random_streaks=np.int64(0), magnitude=5, seeing="1arcmin")
    np.testing.assert_array_equal(done.image, frame)
    assert len(done.truth) == 0 and done.summary == "no streak crosses the frame; the output is a copy"


def test_random_streaks_need_only_the_pixel_scale():
    streaks = dict(random_streaks=1, magnitude=5, seeing="1arcmin", noise=False)
    shutter = dict(start=START, exposure=30.0, zero_point=25.0)
    assert len(streakcast.inject(pixels("float32"), pixel_scale="20arcsec", **streaks, **shutter).truth) == 1


def test_warnings_do_not_show_the_temporary_file():
    cards = header()
    del cards["GAIN"]
    with pytest.warns(streakcast.StreakcastWarning, match="^frame: the gain of HDU 0 is unknown"):
        streakcast.inject(pixels("float32"), header=cards, random_streaks=1, magnitude=5, seeing="1arcmin")


def test_bright_points_are_printed_in_80_characters():
    done = streakcast.inject(
        pixels("float32"), header=header(), random_streaks=1, magnitude=2, seeing="1arcmin", noise=False
    )
    shown = done.points.pformat(max_width=80)[0].split()
    assert shown == ["streak", "utc", "x_pix", "y_pix", "...", "ra_deg", "dec_deg", "magnitude"]


def test_invalid_arguments_are_reported(injector, tmp_path):
    frame = pixels("float32")
    cases = [
        (dict(header=header()), "missing streaks"),
        (dict(header=header(), random_streaks=1), "magnitude"),
        (dict(random_streaks=1, magnitude=5, seeing="1arcsec", start=START, exposure=30, zero_point=25), "missing header of the array; specify header=... .or pixel_scale"),
        (dict(header=header(), random_streaks=-1, magnitude=5), "random_streaks is -1; allowed: 0 or more"),
        (dict(header=header(), random_streaks=1, magnitude=5, truth_points=1), "truth_points is 1; allowed: 2 or more"),
        (dict(header=header(), random_streaks=1, magnitude=5, seed=-1), "seed is -1; allowed: 0 or more"),
        (dict(header=header(), random_streaks=1, magnitude=5, hdu=-1), "hdu is -1; allowed: 0 or more"),
        (dict(header=header(), random_streaks=1, magnitude=(5, np.nan)), r"magnitude\[1\] is nan; allowed: finite numbers"),
        (dict(header=header(), random_streaks=1, magnitude=5, glints=[(np.inf, 1, 1)]), r"glints\[0\]\[0\] is inf"),
        (dict(header=header(), random_streaks=1, magnitude=5, zero_point=np.nan), "zero_point is nan"),
        # The name of the temporary file is not shown.
        (dict(header=header(CTYPE1=""), random_streaks=1, magnitude=5, seeing="1arcsec"), r"^frame: HDU 0: no celestial coordinates: CTYPE1 is \"\" and CTYPE2 is \"DEC--TAN\"; allowed: one RA---xxx"),
        (dict(header=header(), random_streaks=1, magnitude=5), "seeing"),
        (dict(header=header(), random_streaks=1, magnitude=(5, 6, 7), seeing="1arcsec"), "1 to 2"),
        (dict(header=header(), random_streaks=1, magnitude=5, seeing="1arcsec", psf="airy"), "gaussian, moffat"),
        (dict(header=header(), random_streaks=1, magnitude=5, seeing="1arcsec", mask_bits="mine"), "lsst"),
        (dict(header=header(), random_streaks=1, magnitude=5, seeing="1arcsec", gain=-1.0), "gain is -1"),
        (dict(header=header(), random_streaks=1, magnitude=5, seeing="1arcsec", exposure=0.0), "exposure is 0.0 s"),
        (dict(header=header(), random_streaks=1, magnitude=5, seeing="1arcsec", output=tmp_path / "x.fits"), "output is given for an array"),
    ]
    for options, message in cases:
        with pytest.raises(ValueError, match=message):
            streakcast.inject(frame, **options)
    with pytest.raises(ValueError, match="missing header of the array; specify header=...$"):
        injector.inject(frame, start=START, exposure=30.0, zero_point=25.0, seeing="1arcmin")
    with pytest.raises(TypeError, match="random_streaks is 1.5; allowed: integers"):
        streakcast.inject(frame, header=header(), random_streaks=1.5, magnitude=5, seeing="1arcsec")
    with pytest.raises(streakcast.StreakcastError):
        streakcast.inject(tmp_path / "none.fits", tmp_path / "out.fits", random_streaks=1, magnitude=5, seeing="1arcsec")
    assert not (tmp_path / "out.fits").exists()
    with pytest.raises(TypeError, match="float32"):
        streakcast.inject(frame.astype(complex), header=header(), random_streaks=1, magnitude=5, seeing="1arcsec")
    with pytest.raises(TypeError, match="unit"):
        streakcast.inject(frame, header=header(), random_streaks=1, magnitude=5, seeing=1.2)
    with pytest.raises(TypeError, match="scale"):
        injector.inject(frame, header=header(), start=61266.978)


def test_other_threads_run_during_an_injection(injector):
    frame = pixels("float32")
    assert steps_while(lambda: injector.inject(frame, header=header(), seeing="1arcmin", seed=1)) > ENOUGH


def test_verif_labels_and_tables_in_memory():
    rows = [dict(id="a", x1_pix=20.0, y1_pix=30.0, x2_pix=70.0, y2_pix=60.0, magnitude=6.0)]
    options = dict(header=header(), seeing="60arcsec", noise=False, labels=["coco", "yolo"])
    done = streakcast.inject(pixels("float32"), streaks=rows, **options)
    assert list(done.truth["name"]) == ["a"]
    coco = json.loads(done.labels["injected.coco.json"])
    corners = np.array([float(cell) for cell in done.labels["injected.txt"].split()[1:]]).reshape(4, 2) * SIZE
    left, low, width, height = coco["annotations"][0]["bbox"]
    # Row 0 of the array is at y = 0. Nearly all of the added light is in the box.
    inside = done.added[int(low) : int(low + height) + 1, int(left) : int(left + width) + 1]
    assert inside.sum() > 0.9 * done.added.sum()
    np.testing.assert_allclose(corners.mean(axis=0), [44.5, 44.5], atol=0.1)
