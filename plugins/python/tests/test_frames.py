"""Frames in all forms give the results of their files: paths, HDU lists, HDUs, `NDData` and arrays."""

import copy
import subprocess
import sys

import numpy as np
import pytest

import streakcast

fits = pytest.importorskip("astropy.io.fits")
from astropy import units as u  # noqa: E402
from astropy.nddata import (  # noqa: E402
    CCDData,
    Cutout2D,
    InverseVariance,
    NDData,
    NDDataRef,
    StdDevUncertainty,
    UnknownUncertainty,
    VarianceUncertainty,
)
from astropy.wcs import WCS, DistortionLookupTable, Sip  # noqa: E402
from astropy.wcs.wcsapi import SlicedLowLevelWCS  # noqa: E402

from conftest import START  # noqa: E402
from test_injection import SIZE, header, pixels  # noqa: E402

#: Random streaks; the same for each form of a frame.
STREAKS = dict(random_streaks=3, magnitude=(4, 6), seeing="1arcmin", seed=8)


@pytest.fixture(scope="module")
def model():
    return streakcast.StreakModel(mpc="X05", shells="starlink-gen1", epoch=START)


@pytest.fixture(scope="module")
def expected():
    return streakcast.inject(pixels("float32"), header=header(), **STREAKS)


def header_of_image():
    """Returns a header without the keywords of world coordinates, which are in the WCS of an `NDData`."""
    cards = header()
    for keyword in WCS(cards).to_header():
        if keyword not in ("DATE-OBS", "TIMESYS"):
            cards.remove(keyword, ignore_missing=True)
    return cards


def ccd(data=None, **more):
    image = pixels("float32") if data is None else data
    return CCDData(image, **{"unit": "adu", "wcs": WCS(header()), "meta": header_of_image(), **more})


@pytest.mark.parametrize("kind", [fits.PrimaryHDU, fits.ImageHDU, fits.CompImageHDU])
@pytest.mark.parametrize("dtype", ["float32", "uint16"])
def test_an_hdu_is_injected_as_its_array(tmp_path, kind, dtype):
    given = kind(pixels(dtype), header())
    array = streakcast.inject(pixels(dtype), header=header(), **STREAKS)
    done = streakcast.inject(given, **STREAKS)
    assert type(done.frame) is kind and done.frame.header["MAGZP"] == 25.0
    for image in (done.image, done.frame.data):
        assert image.dtype == np.dtype(dtype)
        np.testing.assert_array_equal(image, array.image)
    np.testing.assert_array_equal(given.data, pixels(dtype))
    np.testing.assert_array_equal(done.mask, array.mask)
    # An HDU that was read from a file has big-endian pixels.
    given.writeto(tmp_path / "frame.fits")
    with fits.open(tmp_path / "frame.fits") as file:
        again = streakcast.inject(file[-1], **STREAKS)
    done.frame.writeto(tmp_path / "injected.fits")
    # Compression of floating-point numbers rounds them to a part of the noise, 20.
    tolerance = 10.0 if kind is fits.CompImageHDU and dtype == "float32" else 0.0
    for image in (again.image, fits.getdata(tmp_path / "injected.fits", -1)):
        is_changed = np.asarray(image, "f8") - array.image
        assert np.mean(np.abs(is_changed) > tolerance) <= (0.0 if tolerance == 0.0 else 0.01)


@pytest.mark.parametrize("dtype", ["int64", "uint32", "int8"])
def test_other_integers_are_injected_and_returned(dtype):
    given = (pixels("int16") // 8).clip(0, 100).astype(dtype)
    done = streakcast.inject(given, header=header(), **STREAKS)
    expected = streakcast.inject(given.astype("int32"), header=header(), **STREAKS)
    assert done.image.dtype == done.frame.dtype == np.dtype(dtype)
    np.testing.assert_array_equal(done.image, expected.image.clip(-128, 127) if dtype == "int8" else expected.image)
    with pytest.raises(ValueError, match="beyond those of int32"):
        streakcast.inject(given.astype("int64") + 2**40, header=header(), **STREAKS)


def test_scaled_hdus_of_a_list_are_not_changed(tmp_path):
    scaled = fits.ImageHDU(pixels("int16"), header())
    fits.HDUList([fits.PrimaryHDU(), scaled]).writeto(tmp_path / "frame.fits")
    with fits.open(tmp_path / "frame.fits", mode="update", do_not_scale_image_data=True) as file:
        file[1].header["BSCALE"], file[1].header["BZERO"] = 2.0, 30000.0
    with fits.open(tmp_path / "frame.fits") as file:
        before = file[1].header.tostring()
        done = streakcast.inject(file, **STREAKS)
        assert file[1].header.tostring() == before and file[1].header["BSCALE"] == 2.0
        assert np.median(done.frame[1].data) == pytest.approx(np.median(2.0 * pixels("int16") + 30000.0), abs=4.0)


def test_an_hdu_list_is_injected_as_its_file(tmp_path):
    hdus = fits.HDUList([fits.PrimaryHDU(), fits.ImageHDU(pixels("float32"), header(), name="SCI"), fits.ImageHDU(pixels("float32"), name="ERR")])
    hdus.writeto(tmp_path / "frame.fits")
    written = streakcast.inject(tmp_path / "frame.fits", tmp_path / "out.fits", **STREAKS)
    done = streakcast.inject(hdus, **STREAKS)
    assert isinstance(done.frame, fits.HDUList) and done.path is None and done.image is None
    assert written.frame == tmp_path / "out.fits"
    with fits.open(tmp_path / "out.fits") as file:
        assert [hdu.name for hdu in done.frame] == [hdu.name for hdu in file] == ["PRIMARY", "SCI", "ERR", "STREAKMASK", "STREAKS", "STREAK_POINTS"]
        for one, other in zip(done.frame, file):
            assert (one.data is None and other.data is None) or one.data.tobytes() == other.data.tobytes()
        assert "streakcast-" not in str(done.frame["SCI"].header)
    assert "image" not in done.truth.colnames and len(done.truth) == len(written.truth) == 3
    # The result is in memory, can be changed, and can be given again.
    done.frame["SCI"].data += 1
    assert len(streakcast.inject(done.frame, hdu=1, **STREAKS).truth) == 3


def test_ccddata_keeps_mask_meta_and_coordinates(expected):
    mask = np.zeros((SIZE, SIZE), bool)
    mask[:3] = True
    given = ccd(mask=mask)
    done = streakcast.inject(given, **STREAKS)
    assert type(done.frame) is CCDData and done.frame.unit == u.adu
    # The WCS formats its numbers again.
    np.testing.assert_allclose(done.frame.data, expected.image, rtol=0.02)
    np.testing.assert_array_equal(done.frame.mask, mask)
    assert dict(done.frame.meta) == dict(given.meta) and done.frame.wcs.wcs.compare(given.wcs.wcs)
    np.testing.assert_array_equal(given.data, pixels("float32"))
    np.testing.assert_array_equal(done.image, done.frame.data)
    assert done.mask.shape == (SIZE, SIZE) and (done.mask != 0).sum() > 1000
    # Metadata that are not cards are kept and not used.
    plain = streakcast.inject(NDData(pixels("float32"), wcs=WCS(header()), meta={**header_of_image(), "steps": [given], "a": {}}), **STREAKS)
    np.testing.assert_array_equal(plain.frame.data, done.image)
    assert type(plain.frame) is NDData and "steps" in plain.frame.meta


@pytest.mark.parametrize("kind", [StdDevUncertainty, VarianceUncertainty, InverseVariance])
def test_the_noise_of_streaks_is_added_to_the_uncertainty(kind):
    error = np.full((SIZE, SIZE), 20.0, "float32")
    given = ccd(uncertainty=StdDevUncertainty(error).represent_as(kind))
    before = np.array(given.uncertainty.array)
    done = streakcast.inject(given, **STREAKS)
    assert type(done.frame.uncertainty) is kind
    variance = done.frame.uncertainty.represent_as(VarianceUncertainty).array
    # A count is 2 electrons: its variance is 1/2.
    np.testing.assert_allclose(variance - 400.0, np.maximum(done.added, 0) / 2.0, rtol=1e-3, atol=0.1)
    is_unchanged = done.added == 0
    np.testing.assert_array_equal(done.frame.uncertainty.array[is_unchanged], before[is_unchanged])
    np.testing.assert_array_equal(given.uncertainty.array, before)
    unknown = streakcast.inject(ccd(uncertainty=UnknownUncertainty(error)), **STREAKS).frame.uncertainty
    np.testing.assert_array_equal(unknown.array, error)


def test_masked_arrays_and_quantities_are_returned_as_such(expected):
    mask = np.eye(SIZE, dtype=bool)
    masked = streakcast.inject(np.ma.MaskedArray(pixels("float32"), mask), header=header(), **STREAKS).frame
    np.testing.assert_array_equal(masked.mask, mask)
    np.testing.assert_array_equal(masked.data, expected.image)
    counts = streakcast.inject(pixels("float32") * u.adu, header=header(), **STREAKS).frame
    assert counts.unit == u.adu
    np.testing.assert_array_equal(counts.value, expected.image)
    # Light in electrons has twice the variance of light in counts of 2 electrons.
    electrons = streakcast.inject(ccd(unit="electron"), **STREAKS)
    assert electrons.frame.unit == u.electron and (electrons.image != expected.image).any()
    assert expected.frame is expected.image


def injected_by(model, exposure=30.0):
    """Returns a frame with the streaks of satellites, and its array."""
    done = model.inject(pixels("float32"), header=header(), seeing="1arcmin", exposure=exposure)
    return done.image


def forms(image):
    """Returns a frame in all forms, with the arguments that it needs."""
    return {
        "array": (image, {"header": header()}),
        "ccd": (ccd(image), {}),
        "nddata": (NDData(image, wcs=WCS(header()), meta=dict(header_of_image())), {}),
        "primary": (fits.PrimaryHDU(image, header()), {}),
        "image": (fits.ImageHDU(image, header()), {}),
        "hdus": (fits.HDUList([fits.PrimaryHDU(image, header())]), {}),
    }


def test_measurements_and_masks_are_those_of_the_file(model, tmp_path):
    image, path = injected_by(model), tmp_path / "frame.fits"
    fits.PrimaryHDU(image, header()).writeto(path)
    measured, masked = model.measure(path, seeing="1arcmin").table, model.mask(path, seeing="1arcmin")
    assert measured["detected"].any() and masked.mask.any()
    for name, (frame, options) in forms(image).items():
        table = model.measure(frame, seeing="1arcmin", **options).table
        assert set(table["image"]) == {"frame"}, name
        np.testing.assert_array_equal(table["norad_id"], measured["norad_id"], err_msg=name)
        np.testing.assert_allclose(table["magnitude"], measured["magnitude"], atol=1e-3 * u.mag, err_msg=name)
        mask = model.mask(frame, seeing="1arcmin", **options)
        assert (mask.mask != masked.mask).mean() < 1e-3 and set(mask.streaks["image"]) == {"frame"}, name
    bad = np.zeros(image.shape, bool)
    bad[:5] = True
    of_ccd = model.mask(ccd(image, mask=bad), seeing="1arcmin")
    np.testing.assert_array_equal(of_ccd.frame.mask, of_ccd.mask | bad)
    np.testing.assert_array_equal(of_ccd.frame.data, image)
    of_array = model.mask(np.ma.MaskedArray(image, bad), header=header(), seeing="1arcmin").frame
    np.testing.assert_array_equal(of_array.mask, masked.mask | bad)
    assert masked.frame is None
    several = model.measure([path, ccd(image), fits.PrimaryHDU(image, header())], seeing="1arcmin").table
    assert sorted(set(several["image"])) == sorted([str(path), "frames[1]", "frames[2]"])
    assert len(several) == 3 * len(measured)


def test_masked_pixels_are_not_measured(model):
    image = injected_by(model)
    whole = model.measure(ccd(image), seeing="1arcmin")
    is_found = np.asarray(whole.table["detected"])
    assert is_found.any()
    # A mask of more than half of the pixels is not used.
    bad = model.mask(ccd(image), width="20arcmin").mask
    assert 0 < bad.mean() < 0.5
    for more in ({"mask": bad}, {"uncertainty": StdDevUncertainty(np.where(bad, 0.0, 20.0))}):
        assert not np.asarray(model.measure(ccd(image, **more), seeing="1arcmin").table["detected"]).any()
    masked = np.ma.MaskedArray(image, bad)
    assert not np.asarray(model.measure(masked, header=header(), seeing="1arcmin").table["detected"]).any()
    some = model.measure(ccd(image, uncertainty=VarianceUncertainty(np.ones((SIZE, SIZE)))), seeing="1arcmin")
    np.testing.assert_array_equal(some.table["detected"], is_found)


def test_streaks_in_all_forms_of_a_frame_are_identified(model):
    image = injected_by(model)
    truth = model.inject(pixels("float32"), header=header(), seeing="1arcmin").truth
    row = int(np.argmax(truth["length_pix"]))
    ends = [[truth[f"{axis}{end}_pix"][row].value for axis in "xy"] for end in (1, 2)]
    for name, (frame, options) in forms(image).items():
        found = model.identify(frame=frame, pixels=ends, top=3, **options).candidates
        assert found["norad_id"][0] == truth["norad_id"][row], name


def test_invalid_frames_are_named(model):
    image = pixels("float32")
    table_wcs = WCS(header())
    table_wcs.cpdis1 = DistortionLookupTable(np.zeros((2, 2), "float32"), (1, 1), (1, 1), (1, 1))
    raw = fits.PrimaryHDU(pixels("int16"), header())
    raw.header["BZERO"] = 100.0
    for error, frame, options, message in [
        (ValueError, fits.PrimaryHDU(), {}, "frame is a PrimaryHDU without data; allowed: an HDU with an image"),
        (ValueError, fits.PrimaryHDU(np.zeros((2, 3, 4), "f4"), header()), {}, r"frame has the shape \(2, 3, 4\); allowed: a path, or an array"),
        (ValueError, fits.PrimaryHDU(np.zeros((3, 50, 60), "f4"), header()), {}, r"shape \(3, 50, 60\); allowed: .* one channel of a colour image"),
        (ValueError, ccd(), {"header": header()}, "header is given for a CCDData, which contains it; allowed: with an array"),
        (ValueError, fits.HDUList([fits.PrimaryHDU(image, header())]), {"header": header()}, "header is given for an HDUList"),
        (ValueError, ccd(wcs=None), {}, "^frame: HDU 0: no celestial coordinates"),
        (TypeError, NDData(image, wcs=SlicedLowLevelWCS(WCS(naxis=3), 0)), {}, "wcs of the frame is .*; allowed: an astropy.wcs.WCS"),
        (TypeError, Cutout2D(image, (50, 50), 20, wcs=WCS(header())), {}, "frame is a Cutout2D, which has no header; allowed: its data, with"),
        (ValueError, ccd(wcs=table_wcs), {}, "lookup tables of distortion"),
        (ValueError, raw, {}, "do_not_scale_image_data"),
        (TypeError, ccd(image.astype("complex64")), {}, "allowed: two axes of float32, float64, or integers within the range of int32"),
        (ValueError, fits.HDUList([fits.PrimaryHDU()]), {}, "frame"),
        (ValueError, fits.HDUList(), {}, "frame is an HDUList without HDUs; allowed: one with an image"),
        (ValueError, None, {}, r"frame has the shape \(\)"),
    ]:
        for verb in (streakcast.inject, model.mask, model.measure):
            more = STREAKS if verb is streakcast.inject else {"seeing": "1arcmin"}
            if frame is None and verb == model.measure:
                continue
            with pytest.raises(error, match=message):
                verb(frame, **options, **more)
    with pytest.raises(ValueError, match=r"frames\[1\] is an HDUList without HDUs"):
        model.measure([fits.PrimaryHDU(image, header()), fits.HDUList()])
    with pytest.raises(ValueError, match="output is given for an array"):
        streakcast.inject(ccd(), "x.fits", **STREAKS)
    with pytest.raises(ValueError, match="header is given without frame"):
        model.identify(place=(1, 2), position_angle=3, header=header())


MEMORY = """
import resource, sys
import numpy as np
import streakcast

size = int(sys.argv[1])
cards = "\\n".join([
    "CTYPE1  = 'RA---TAN'", "CTYPE2  = 'DEC--TAN'", "CRVAL1  = 10.0", "CRVAL2  = 10.0", "CRPIX1  = 1.0", "CRPIX2  = 1.0",
    "CDELT1  = -0.0001", "CDELT2  = 0.0001", "EXPTIME = 30.0", "DATE-OBS= '2026-08-14T23:29:05'", "MAGZP   = 25.0", "GAIN    = 2.0",
])
streaks = dict(random_streaks=1, magnitude=8, seeing="1arcsec", header=cards)
streakcast.inject(np.zeros((50, 50), "float32"), **streaks)
image = np.full((size, size), 100, "float32")
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
before = peak()
done = streakcast.inject(image, **streaks)
print((peak() - before) / image.nbytes)
assert len(done.truth) and done.mask.any() and done.added.any()
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="ru_maxrss has this unit on Linux")
def test_an_injection_needs_little_memory_beside_its_result():
    done = subprocess.run([sys.executable, "-c", MEMORY, "5000"], capture_output=True, text=True, check=True)
    # The result is one array. Rows that are read at once need another 0.06 of this small frame.
    assert float(done.stdout) < 1.1, done.stdout


def test_frames_are_not_changed(model):
    given = ccd(mask=np.zeros((SIZE, SIZE), bool), uncertainty=StdDevUncertainty(np.ones((SIZE, SIZE))))
    before = copy.deepcopy(given)
    for verb, options in ((streakcast.inject, STREAKS), (model.mask, {"seeing": "1arcmin"}), (model.measure, {"seeing": "1arcmin"})):
        verb(given, **options)
        np.testing.assert_array_equal(given.data, before.data)
        np.testing.assert_array_equal(given.uncertainty.array, before.uncertainty.array)
        assert dict(given.meta) == dict(before.meta)


def test_the_unit_of_an_uncertainty_is_used():
    image = pixels("float32")
    sigma = np.full((SIZE, SIZE), 20.0, dtype="float32")
    same = streakcast.inject(ccd(uncertainty=StdDevUncertainty(sigma)), **STREAKS).frame.uncertainty
    for unit, factor in ((u.Unit("1000 adu"), 1e-3), (u.Unit("0.001 adu"), 1e3)):
        given = ccd(image, uncertainty=StdDevUncertainty(sigma * np.float32(factor), unit=unit))
        other = streakcast.inject(given, **STREAKS).frame.uncertainty
        assert other.unit == unit
        np.testing.assert_allclose(other.array, same.array * factor, rtol=1e-5)
    assert (same.array > 20.0).any()
    with pytest.raises(ValueError, match="the uncertainty has the unit s, the data adu"):
        wrong = ccd(image)
        wrong.uncertainty = StdDevUncertainty(sigma)
        wrong.uncertainty._unit = u.s
        streakcast.inject(wrong, **STREAKS)


@pytest.mark.parametrize("kind, bad", [(StdDevUncertainty, 0.0), (VarianceUncertainty, 0.0), (InverseVariance, 0.0)])
def test_uncertainties_without_information_are_kept(kind, bad):
    array = np.full((SIZE, SIZE), bad, dtype="float32")
    done = streakcast.inject(ccd(uncertainty=kind(array)), **STREAKS).frame
    np.testing.assert_array_equal(done.uncertainty.array, array)


def test_results_share_no_memory_with_the_frame(model):
    bad = np.zeros((SIZE, SIZE), dtype=bool)
    bad[3, 4] = True
    given = ccd(mask=bad, uncertainty=StdDevUncertainty(np.full((SIZE, SIZE), 20.0)))
    masked = np.ma.MaskedArray(pixels("float32"), mask=bad, fill_value=-7.0)
    for done in (streakcast.inject(given, **STREAKS).frame, model.mask(given, seeing="1arcmin").frame):
        assert not np.shares_memory(done.mask, given.mask) and not np.shares_memory(done.data, given.data)
        assert not np.shares_memory(done.uncertainty.array, given.uncertainty.array)
    for done in (
        streakcast.inject(masked, header=header(), **STREAKS).frame,
        model.mask(masked, header=header(), seeing="1arcmin").frame,
    ):
        assert not np.shares_memory(done.mask, masked.mask) and not np.shares_memory(done.data, masked.data)
        assert done.fill_value == -7.0


def test_remarks_name_the_columns_that_are_not_used(tmp_path):
    table = tmp_path / "streaks.csv"
    table.write_text("x1_pix,y1_pix,x2_pix,y2_pix,magnitude,colour\n10,10,90,60,5,blue\n")
    done = streakcast.inject(pixels("float32"), header=header(), streaks=table, seeing="1arcmin")
    assert any("columns that are not used: colour" in remark for remark in done.remarks)


@pytest.mark.parametrize("form", ["columns", "rows", "table"])
def test_streaks_whose_names_begin_with_a_hash_are_kept(form):
    from astropy.table import QTable

    columns = dict(id=["#a", "b"], x1_pix=[10.0, 20.0], y1_pix=[10.0, 20.0], x2_pix=[90.0, 80.0], y2_pix=[60.0, 90.0], magnitude=[5.0, 6.0])
    rows = [dict(zip(columns, row)) for row in zip(*columns.values())]
    streaks = {"columns": columns, "rows": rows, "table": QTable(columns)}[form]
    done = streakcast.inject(pixels("float32"), header=header(), streaks=streaks, seeing="1arcmin")
    assert [str(name) for name in done.truth["name"]] == ["#a", "b"]


@pytest.mark.parametrize("level", [4.0, 16.0])
def test_compressed_images_that_were_read_keep_their_pixels(tmp_path, level):
    compressed = fits.CompImageHDU(pixels("float32"), header(), name="SCI", quantize_level=level)
    fits.HDUList([fits.PrimaryHDU(), compressed]).writeto(tmp_path / "frame.fits")
    with fits.open(tmp_path / "frame.fits") as file:
        # Once it is read, astropy compresses the image anew when it writes the list.
        before = np.array(file[1].data)
        done = streakcast.inject(file, **STREAKS).frame
        np.testing.assert_array_equal(file[1].data, before)
    assert type(done[1]) is fits.CompImageHDU and done[1].name == "SCI" and done[1].quantize_level == level
    is_lit = done["STREAKMASK"].data != 0
    assert is_lit.any() and not is_lit.all()
    # The mask omits only light below 10⁻⁴ of the brightest pixel.
    assert np.abs(done[1].data - before)[~is_lit].max() < 1e-3 * np.abs(done[1].data - before).max()
    # Two lists with the same values give the same frame.
    plain = fits.HDUList([fits.PrimaryHDU(), fits.ImageHDU(before, header(), name="SCI")])
    np.testing.assert_array_equal(streakcast.inject(plain, **STREAKS).frame[1].data, done[1].data)


def test_injected_files_have_no_mask_of_bad_pixels(tmp_path):
    fits.PrimaryHDU(pixels("float32"), header()).writeto(tmp_path / "frame.fits")
    streakcast.inject(tmp_path / "frame.fits", tmp_path / "injected.fits", **STREAKS)
    streaks = tmp_path / "injected.fits"
    given = CCDData.read(streaks, unit="adu")
    assert given.mask is None
    truth = streakcast.inject(pixels("float32"), header=header(), **STREAKS).truth
    rows = [{name: truth[name][0].value for name in ("x1_pix", "y1_pix", "x2_pix", "y2_pix")}]
    found = [streakcast.measure_streaks(one, rows, seeing="1arcmin").table for one in (given, streaks)]
    assert found[0]["detected"][0] and list(found[0]["flags"][0]) == list(found[1]["flags"][0])
    np.testing.assert_allclose(found[0]["magnitude"].value, found[1]["magnitude"].value, atol=1e-3)


def scamp_of_degree_1():
    cards = header()
    # astropy rejects these keywords beside LATPOLE, and closer to the equator.
    del cards["LATPOLE"], cards["LONPOLE"]
    cards["CRVAL2"] = 40.0
    cards.update({f"PV{axis}_{term}": float(term == 1) for axis in (1, 2) for term in (0, 1, 2)})
    return WCS(cards)


def sip_with_another_reference():
    wcs, terms = WCS(header()), np.zeros((3, 3))
    terms[2, 0] = 1e-3
    wcs.sip = Sip(terms, terms, None, None, wcs.wcs.crpix + 40.0)
    return wcs


@pytest.mark.parametrize("wcs", [scamp_of_degree_1, sip_with_another_reference])
def test_world_coordinates_that_are_read_otherwise_are_an_error(wcs):
    message = r"frame: pixel .* by pixel_to_world of the WCS object, but at .* deg by its keywords .*; allowed: a path"
    with pytest.raises(ValueError, match=message):
        streakcast.inject(ccd(wcs=wcs()), **STREAKS)
    with pytest.raises(ValueError, match=message):
        streakcast.inject(pixels("float32"), header=wcs(), start=START, exposure=30, zero_point=25, gain=2, **STREAKS)


def test_slices_and_dictionaries_are_read():
    image, cut = pixels("float32"), np.s_[5:, 10:300]
    meta = dict(header_of_image())
    streak = [dict(x1_pix=5, y1_pix=8, x2_pix=35, y2_pix=80, magnitude=5)]
    # A slice of a slice.
    sliced = NDDataRef(image, wcs=WCS(header()), meta=meta)[5:, 4:][:, 6:296]
    done = streakcast.inject(sliced, streaks=streak, seeing="1arcmin")
    assert type(done.frame) is NDDataRef and done.image.shape == image[cut].shape
    own = sliced.wcs.pixel_to_world(*(np.array([done.truth[f"{axis}1_pix"].value for axis in "xy"]) - 1.0))
    np.testing.assert_allclose(own.ra.deg, done.truth["ra1_deg"].value, atol=1e-6)
    of_dict = streakcast.inject(image, header=dict(header()), **STREAKS)
    np.testing.assert_array_equal(of_dict.image, streakcast.inject(image, header=header(), **STREAKS).image)


def test_one_uncertainty_of_all_pixels_is_read():
    same = streakcast.inject(ccd(uncertainty=StdDevUncertainty(np.full((SIZE, SIZE), 20.0))), **STREAKS).frame
    one = streakcast.inject(ccd(uncertainty=StdDevUncertainty(20.0)), **STREAKS).frame
    np.testing.assert_allclose(one.uncertainty.array, same.uncertainty.array, rtol=1e-6)
    assert one.uncertainty.array.shape == (SIZE, SIZE)


def test_lost_comments_of_the_exposure_are_stated():
    def given(**keywords):
        cards = header()
        for keyword, value in keywords.items():
            cards.remove({"XPOSURE": "EXPTIME", "DATE_BEG": "DATE-OBS"}[keyword])
            cards[keyword.replace("_", "-")] = value
        meta = header_of_image()
        meta.remove("EXPTIME" if "XPOSURE" in keywords else "DATE-OBS")
        return ccd(wcs=WCS(cards), meta=meta)

    for frame, words in (
        (given(XPOSURE=30.0), "frame: the length of the exposure is that of XPOSURE in the WCS object"),
        (given(DATE_BEG=START.rstrip("Z")), "frame: the start of the exposure is that of DATE-BEG"),
    ):
        for done in (streakcast.inject(frame, **STREAKS), streakcast.measure_streaks(frame, [dict(x1_pix=5, y1_pix=8, x2_pix=35, y2_pix=80)])):
            assert any(remark.startswith(words) and "does not keep the comments" in remark for remark in done.remarks)
    assert not any("comments" in remark for remark in streakcast.inject(ccd(), **STREAKS).remarks)
    with pytest.raises(ValueError, match=r"XPOSURE is 0.000347 s in the WCS object, .* allowed: 0.001 s or longer"):
        streakcast.inject(given(XPOSURE=0.000347), **STREAKS)


def test_choices_between_values_of_headers_are_warnings():
    cards = header()
    cards["TIMEOFFS"], cards["NEXP"] = 5.0, 30
    streak = [dict(x1_pix=5, y1_pix=8, x2_pix=35, y2_pix=80)]
    hdus = fits.HDUList([fits.PrimaryHDU(pixels("float32"), cards), fits.ImageHDU(pixels("float32"), name="VAR")])
    for call in (lambda: streakcast.inject(hdus, **STREAKS), lambda: streakcast.measure_streaks(hdus, streak)):
        with pytest.warns(streakcast.StreakcastWarning) as caught:
            done = call()
        messages = [str(one.message) for one in caught]
        for words in ("TIMEOFFS", "NEXP is 30"):
            assert any(words in message for message in messages) and any(words in remark for remark in done.remarks)
        # The roles of images are remarks.
        assert any("companion planes" in remark for remark in done.remarks) and not any("companion" in message for message in messages)
