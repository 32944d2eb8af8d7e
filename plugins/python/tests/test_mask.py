"""Masks of frames and arrays, compared with the command line."""

import os
import subprocess

import numpy as np
import pytest
from astropy.io import fits

import streakcast

#: Frame with the streaks of a simulated constellation, 30 arcsec a pixel.
SKY = """columns = 400
rows = 300
pixel_scale_arcsec = 30.0
zero_point_1s_mag = 18.0
sky_mag_arcsec2 = 21.0
detector = { gain_e_adu = 2.0, read_noise_e = 5, bias_adu = 300 }
"""
SATELLITES = ["--shells", "starlink-gen1", "--mpc", "X05"]


@pytest.fixture(scope="module")
def binary():
    return os.environ.get("STREAKCAST_BIN") or pytest.fail("set STREAKCAST_BIN, or run plugins/test.sh")


@pytest.fixture(scope="module")
def frame(tmp_path_factory, binary):
    """Path of a frame with streaks."""
    folder = tmp_path_factory.mktemp("mask")
    description, path = folder / "sky.toml", folder / "sky.fits"
    description.write_text(SKY)
    shot = ["--start", "2026-08-14T23:29:05Z", "--exposure", "30s", "--ra", "198.9", "--dec", "7.7"]
    command = ["inject", "--synthetic", description, "-o", path, "--seeing", "90arcsec", "--pixels-only"]
    subprocess.run([binary, *command, *shot, *SATELLITES, "--quiet"], check=True)
    return path


@pytest.fixture(scope="module")
def model():
    return streakcast.StreakModel(mpc="X05", shells="starlink-gen1")


def test_masks_of_files_and_arrays_are_those_of_the_command_line(frame, model, binary, tmp_path):
    output = tmp_path / "mask.fits"
    subprocess.run([binary, "mask", frame, "-o", output, "--seeing", "90arcsec", *SATELLITES, "--quiet"], check=True)
    expected = fits.getdata(output) > 0
    masked = model.mask(frame, seeing="90arcsec")
    assert masked.mask.dtype == bool and masked.mask.any() and not masked.mask.all()
    np.testing.assert_array_equal(masked.mask, expected)
    assert len(masked.streaks) >= 1 and masked.streaks["width_arcsec"].unit == "arcsec"
    assert all(region.startswith("POLYGON ICRS ") for region in masked.streaks["s_region"])
    assert "masked" in masked.summary and len(masked.left_out) == 0
    data, header = fits.getdata(frame, header=True)
    of_array = model.mask(data, header=header, seeing="90arcsec", table="dict")
    np.testing.assert_array_equal(of_array.mask, expected)
    assert list(of_array.streaks["image"]) == ["frame"] * len(masked.streaks)


def test_options_change_the_mask(frame, model):
    usual = model.mask(frame, seeing="90arcsec").mask.sum()
    assert model.mask(frame, seeing="90arcsec", coverage=0.5).mask.sum() < usual
    assert model.mask(frame, seeing="90arcsec", threshold=5).mask.sum() < usual
    assert model.mask(frame, width="20arcmin").mask.sum() > usual
    faint = model.mask(frame, seeing="90arcsec", threshold=100)
    assert not faint.mask.any() and "too faint" in faint.left_out["reason"][0]


@pytest.mark.parametrize("form", ["qtable", "dict"])
def test_measured_streaks_are_masked_where_they_are(frame, model, binary, tmp_path, form):
    data, header = fits.getdata(frame, header=True)
    measured = model.measure(frame, seeing="90arcsec", table=form)
    assert np.any(measured.table["detected"])
    path, output = tmp_path / "measured.ecsv", tmp_path / "mask.fits"
    model.measure(frame, seeing="90arcsec").table.write(path)
    command = [binary, "mask", frame, "-o", output, "--seeing", "90arcsec", "--measured", path, *SATELLITES, "--quiet"]
    subprocess.run(command, check=True)
    expected = fits.getdata(output) > 0
    predicted = model.mask(frame, seeing="90arcsec").mask
    assert (expected != predicted).any()
    for table in (path, [path], measured, measured.table):
        masked = model.mask(frame, seeing="90arcsec", measured=table)
        np.testing.assert_array_equal(masked.mask, expected)
        assert "measured)" in masked.summary
    # A frame in memory, and the measurement of the same frame; the model has no measured streaks afterwards.
    of_array = model.measure(data, header=header, seeing="90arcsec", table=form)
    masked = model.mask(data, header=header, seeing="90arcsec", measured=of_array)
    np.testing.assert_array_equal(masked.mask, expected)
    np.testing.assert_array_equal(model.mask(frame, seeing="90arcsec").mask, predicted)


def test_measured_streaks_of_other_frames_are_named(frame, model, tmp_path):
    table = model.measure(frame, seeing="90arcsec", table="dict").table
    table["image"] = np.array(["other.fits"] * len(table["image"]))
    with pytest.warns(streakcast.StreakcastWarning, match="measured streak") as warned:
        model.mask(frame, seeing="90arcsec", measured=table)
    assert not any("streakcast-" in str(one.message) for one in warned)
    with pytest.raises(streakcast.StreakcastError, match="^measured: ") as failed:
        model.mask(frame, seeing="90arcsec", measured={"image": ["sky.fits"]})
    assert "streakcast-" not in str(failed.value)


def test_invalid_arguments_are_named(frame, model):
    data = np.zeros((20, 30), "float32")
    for options, message in (
        ({"seeing": "90arcsec", "coverage": 2}, "coverage is 2; allowed: 0.5 to 0.999"),
        ({"seeing": "90arcsec", "zero_point": 20, "zero_point_1s": 20}, "exclude each other"),
        ({"width": "3arcmin", "seeing": "90arcsec"}, "seeing has no effect with width"),
        ({"width": "3arcmin", "threshold": 5}, "threshold has no effect with width"),
        ({"width": "3arcmin", "psf": "gaussian"}, "psf has no effect with width"),
        ({"width": "3arcmin", "zero_point_1s": 18}, "zero_point_1s has no effect with width"),
        ({"seeing": "90arcsec", "min_probability": 0}, "min.probability is 0; allowed: above 0"),
        ({}, "missing seeing"),
        ({"frame": data, "width": "1arcmin"}, "missing header of the array"),
        ({"frame": data[0], "width": "1arcmin"}, "allowed: a path, or an array"),
    ):
        with pytest.raises((ValueError, streakcast.StreakcastError), match=message):
            model.mask(**{"frame": frame, **options})
    with pytest.raises(TypeError, match="width is float"):
        model.mask(frame, width=10.0)
