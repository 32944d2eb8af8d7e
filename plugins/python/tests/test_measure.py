"""Measured streaks of frames, compared with the truth and with the command line, and learned from."""

import csv
import os
import subprocess
import warnings

import numpy as np
import pytest

import streakcast

#: Largest error of a flux in sigmas, and the largest bias.
SIGMAS, FLUX_BIAS = 4.0, 0.02
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
def frame(tmp_path_factory):
    """Path of the frame, and the rows of its truth table."""
    folder = tmp_path_factory.mktemp("measure")
    description, path, truth = folder / "sky.toml", folder / "sky.fits", folder / "truth.csv"
    description.write_text(SKY)
    shot = ["--start", "2026-08-14T23:29:05Z", "--exposure", "30s", "--ra", "198.9", "--dec", "7.7"]
    command = ["inject", "--synthetic", description, "-o", path, "--seeing", "90arcsec", "--truth", truth]
    binary = os.environ.get("STREAKCAST_BIN") or pytest.fail("set STREAKCAST_BIN, or run plugins/test.sh")
    subprocess.run([binary, *command, *shot, *SATELLITES, "--quiet"], check=True)
    lines = [line for line in truth.read_text().splitlines() if not line.startswith("#")]
    return path, list(csv.DictReader(lines))


@pytest.fixture(scope="module")
def model():
    return streakcast.StreakModel(mpc="X05", shells="starlink-gen1")


def test_verif_magnitudes_are_those_of_the_frame_and_of_the_command_line(frame, model, command_line):
    path, truth = frame
    measured = model.measure(path, seeing="90arcsec", table="dict")
    table = measured.table
    counts = {int(row["norad_id"]): float(row["counts"]) for row in truth}
    found = np.flatnonzero(table["detected"])
    assert len(found) >= 1
    for row in found:
        true = counts[int(table["norad_id"][row])] / table["duration_s"][row]
        error = abs(table["rate"][row] - true)
        assert error < SIGMAS * table["rate_sigma"][row] + FLUX_BIAS * true
    rows = command_line("measure", path, "--seeing", "90arcsec", *SATELLITES)["measurements"]
    assert [row["norad_id"] for row in rows] == list(table["norad_id"])
    for name in ("magnitude", "rate", "ra_deg", "limit_magnitude", "predicted_magnitude"):
        values = [np.nan if row[name] is None else float(row[name]) for row in rows]
        np.testing.assert_allclose(table[name], values, rtol=1e-4, atol=1e-3, err_msg=name)


def test_measured_streaks_can_be_learned_from(frame, model, tmp_path):
    measured = model.measure([frame[0]], seeing="90arcsec")
    table, usable = measured.table, measured.learn_arguments
    assert table["magnitude"].unit == "mag"
    is_found = np.asarray(table["detected"])
    np.testing.assert_array_equal(usable["norad_id"], np.asarray(table["norad_id"])[is_found])
    np.testing.assert_array_equal(usable["observed"], table["magnitude"].value[is_found])
    np.testing.assert_array_equal(usable["sigma"], table["magnitude_sigma"].value[is_found])
    assert all(text.startswith("2026-08-14T23:29:") and text.endswith("Z") for text in usable["time"])
    learned = streakcast.learn(**usable, kind="starlink-v1.5", output=tmp_path / "learned.json")
    assert learned["kinds"][0]["magnitude"]["passes"] == len(usable["observed"]) >= 1
    streakcast.StreakModel(mpc="X05", shells="starlink-gen1", learned=tmp_path / "learned.json")


@pytest.mark.parametrize("length", [13, 35])
def test_the_magnitudes_are_printed_in_80_characters(frame, model, length):
    table = model.measure(frame[0], seeing="90arcsec").table
    table["name"] = [str(name)[:length] for name in table["name"]]
    shown = table.pformat(max_width=80)[0].split()
    assert shown[:2] == ["name", "detected"] and shown[-2:] == ["magnitude", "magnitude_sigma"]
    assert length > 13 or "limit_magnitude" in shown


def test_stars_give_the_zero_point(frame, model, tmp_path):
    # The frame without stars has none to measure.
    stars = tmp_path / "stars.csv"
    stars.write_text("ra_deg,dec_deg,mag\n198.9,7.7,8.0\n198.5,7.5,8.0\n199.2,7.9,8.0\n")
    with pytest.warns(streakcast.StreakcastWarning, match="no zero point, magnitudes are instrumental; stars used: 0"):
        measured = model.measure(frame[0], seeing="90arcsec", stars=stars)
    assert not np.any(measured.table["calibrated"])
    assert len(measured.learn_arguments["observed"]) == 0


def test_invalid_arguments_are_named(frame, model, tmp_path):
    for options, text in [
        ({"frames": tmp_path / "missing.fits"}, "missing.fits"),
        ({"seeing": "0arcsec"}, "seeing"),
        ({"gain": 0.0}, "gain is 0"),
        ({"gain": np.nan}, "gain is nan"),
        ({"saturation": -1.0}, "saturation is -1"),
        ({"hdu": 7}, "7"),
        ({"hdu": [0, -1]}, "hdu is -1; allowed: 0 or more"),
        ({"stars": "missing.csv"}, "missing.csv"),
        ({"zero_point": 25.0, "zero_point_1s": 21.0}, "zero_point_1s"),
        ({"frames": []}, "missing frames"),
    ]:
        with pytest.raises(ValueError, match=text):
            model.measure(**{"frames": frame[0], **options})
    with pytest.raises(TypeError, match="seeing is float"):
        model.measure(frame[0], seeing=1.2)
    with pytest.raises(TypeError, match="without a time scale"):
        model.measure(frame[0], start=60_000.0)


@pytest.mark.parametrize("ending", ["csv", "ecsv"])
def test_tables_of_python_are_read_by_mask(frame, model, tmp_path, ending):
    path = tmp_path / f"measured.{ending}"
    model.measure(frame[0], seeing="90arcsec").table.write(path)
    out = tmp_path / "mask.fits"
    command = ["mask", frame[0], "--measured", path, "-o", out, "--seeing", "90arcsec", *SATELLITES, "--quiet"]
    subprocess.run([os.environ["STREAKCAST_BIN"], *command], check=True)
    assert out.exists()
    streakcast.StreakModel(mpc="X05", shells="starlink-gen1", measured=path)


def test_pixels_without_information_are_not_measured(frame, model):
    fits = pytest.importorskip("astropy.io.fits")
    from astropy.nddata import CCDData, InverseVariance, StdDevUncertainty
    from astropy.wcs import WCS

    with fits.open(frame[0]) as hdus:
        hdu = next(one for one in hdus if one.data is not None)
        header, data = hdu.header.copy(), np.array(hdu.data, dtype="float32")

    def remarks(**more):
        ccd = CCDData(data, unit="adu", wcs=WCS(header), meta=header, **more)
        return " ".join(model.measure(ccd, seeing="90arcsec").remarks)

    half = np.zeros(data.shape, dtype=bool)
    half[: int(0.6 * len(half))] = True
    assert f"(MASK): {half.sum()} bad pixels" in remarks(mask=half)
    some = half & (np.arange(len(half))[:, None] < 20)
    assert f"(VARIANCE): {some.sum()} bad pixels" in remarks(uncertainty=InverseVariance(np.where(some, 0.0, 1.0)))
    assert f"(VARIANCE): {some.sum()} bad pixels" in remarks(uncertainty=StdDevUncertainty(np.where(some, np.inf, 1.0)))


def test_uncertainties_of_written_files_are_those_of_the_object(frame, tmp_path):
    """Planes whose noise exceeds the scatter of the sky raise the errors, so that their kind matters."""
    fits = pytest.importorskip("astropy.io.fits")
    from astropy.nddata import CCDData, InverseVariance, StdDevUncertainty, VarianceUncertainty
    from astropy.wcs import WCS

    path, truth = frame
    with fits.open(path) as hdus:
        hdu = next(one for one in hdus if one.data is not None)
        header, data = hdu.header.copy(), np.array(hdu.data, dtype="float32")
    rows, written = streak_rows(truth)[:1], tmp_path / "written.fits"
    sky = data[:40, :40]
    sigma = 1.1 * float(1.4826 * np.median(np.abs(sky - np.median(sky))))
    errors = {}
    for kind, value in ((None, 0.0), (StdDevUncertainty, sigma), (VarianceUncertainty, sigma**2), (InverseVariance, sigma**-2)):
        uncertainty = None if kind is None else kind(np.full(data.shape, value, dtype="float32"))
        given = CCDData(data, unit="adu", wcs=WCS(header), header=header.copy(), uncertainty=uncertainty)
        given.write(written, overwrite=True)
        assert kind is None or fits.getheader(written, "UNCERT")["UTYPE"] == kind.__name__
        done = [streakcast.measure_streaks(one, rows, seeing="90arcsec") for one in (given, written)]
        of_object, of_file = (float(one.table["magnitude_sigma"][0].value) for one in done)
        assert of_file == pytest.approx(of_object, rel=1e-3), kind
        assert kind is None or any("its noise is a lower limit of the errors" in remark for remark in done[1].remarks), done[1].remarks
        errors[kind] = of_file
    assert np.ptp([errors[kind] for kind in errors if kind is not None]) < 1e-3 * errors[None]


def streak_rows(truth):
    names = ("x1_pix", "y1_pix", "x2_pix", "y2_pix")
    return [{"id": row["name"], **{name: float(row[name]) for name in names}} for row in truth if row["x1_pix"]]


def test_streaks_of_tables_in_memory_equal_those_of_files(frame, model, tmp_path):
    path, truth = frame
    rows = streak_rows(truth)
    table = tmp_path / "streaks.csv"
    table.write_text("\n".join(",".join(map(str, line)) for line in [rows[0], *(row.values() for row in rows)]) + "\n")
    expected = streakcast.measure_streaks(path, table, table="dict").table
    assert list(expected["streak"]) == [row["id"] for row in rows]
    assert np.ma.getmaskarray(expected["norad_id"]).all() and not any(expected["name"])
    columns = {name: [row[name] for row in rows] for name in rows[0]}
    QTable = pytest.importorskip("astropy.table").QTable
    for streaks in (rows, columns, QTable(columns), [str(table)]):
        found = streakcast.measure_streaks(path, streaks, table="dict").table
        np.testing.assert_array_equal(found["flux"], expected["flux"])
    counts = np.array([float(row["counts"]) for row in truth if row["x1_pix"]])
    found = expected["detected"]
    error = np.abs(expected["flux"] - counts)[found]
    assert found.any() and (error < SIGMAS * expected["flux_sigma"][found] + FLUX_BIAS * counts[found]).all()
    # With the satellites of a model, streaks are named.
    named = model.measure(path, streaks=rows, table="dict")
    numbers = [int(row["norad_id"]) for row in truth if row["x1_pix"]]
    assert list(named.table["norad_id"]) == numbers and len(named.learn_arguments["norad_id"]) >= 1


def test_streaks_outside_of_the_frame_have_rows(frame):
    QTable, u = pytest.importorskip("astropy.table").QTable, pytest.importorskip("astropy.units")
    outside = [{"id": "away", "x1_pix": -90, "y1_pix": -90, "x2_pix": -10, "y2_pix": -50}, {"id": "none", "x1_pix": None}]
    columns = ("x1_pix", "y1_pix", "x2_pix", "y2_pix")
    rows = [{"id": row["id"], **{name: row.get(name) for name in columns}} for row in outside]
    measured = streakcast.measure_streaks(frame[0], rows)
    assert [list(flags) for flags in measured.table["flags"]] == [["outside"], ["no_ends"]]
    assert np.isnan(measured.table["flux"]).all() and len(measured.learn_arguments["norad_id"]) == 0
    # A frame without streaks.
    assert len(streakcast.measure_streaks(frame[0], []).table["flux"]) == 0
    for streaks, words in (
        ([1, 2], "allowed: a path, an astropy Table"),
        ({"x": [1], "y": [1, 2]}, "of one length"),
        ([{"x1_pix": 1}], "streaks"),
        ({}, "^streaks have no columns; allowed"),
        (QTable(), "^streaks have no columns; allowed"),
        ({"x1_pix": 1.0}, "^column x1_pix of streaks is float; allowed: a list or an array"),
        ({"id": "one"}, "^column id of streaks is str; allowed"),
        ({"x1_pix": 1.0 * u.pix}, "^column x1_pix of streaks is Quantity; allowed"),
    ):
        with pytest.raises((TypeError, ValueError, streakcast.StreakcastError), match=words):
            streakcast.measure_streaks(frame[0], streaks)
    with pytest.raises(ValueError, match="place_sigma is given without streaks"):
        streakcast.StreakModel(mpc="X05", shells="starlink-gen1").measure(frame[0], place_sigma="1arcsec")


def messages(call):
    """Returns the result of a call, and its warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = call()
    return result, [str(one.message) for one in caught if issubclass(one.category, streakcast.StreakcastWarning)]


def test_streaks_of_tables_are_identified_as_on_the_command_line(frame, model, command_line, tmp_path, monkeypatch):
    path, truth = frame
    rows = streak_rows(truth)
    numbers = [int(row["norad_id"]) for row in truth if row["x1_pix"]]
    table = tmp_path / "streaks.csv"
    table.write_text("\n".join(",".join(map(str, line)) for line in [rows[0], *(row.values() for row in rows)]) + "\n")
    answer = command_line("identify", "--streaks", table, "--image", path, "--top", "2", *SATELLITES)
    found = model.identify(streaks=table, frame=path, top=2, output="dict")
    for result, section in ((found.candidates, "candidates"), (found.streak, "streaks")):
        assert list(result["streak"]) == [row["streak"] for row in answer[section]] and set(result["image"]) == {str(path)}
    assert list(found.candidates["norad_id"]) == [row["norad_id"] for row in answer["candidates"]]
    assert list(found.n_candidates) == [row["candidates"] for row in answer["streaks"]] == list(found.streak["candidates"])
    np.testing.assert_allclose(found.unknown_probability, [float(row["unknown_probability"]) for row in answer["streaks"]], atol=1e-6)
    _, first = np.unique(found.candidates["streak"], return_index=True)
    assert list(found.candidates["norad_id"][np.sort(first)]) == numbers
    # The result of one streak at a time is the same.
    ends = [[row[name] for name in ("x1_pix", "y1_pix", "x2_pix", "y2_pix")] for row in rows]
    alone = [model.identify(frame=path, pixels=np.reshape(end, (2, 2)), output="dict") for end in ends]
    assert [one.candidates["norad_id"][0] for one in alone] == numbers
    np.testing.assert_allclose(found.unknown_probability, [one.unknown_probability for one in alone])
    # All forms of tables and frames; names of frames in memory, and paths relative to the table or the current folder.
    fits = pytest.importorskip("astropy.io.fits")
    columns = {name: [row[name] for row in rows] for name in rows[0]}
    named = {**columns, "image": [path.name] * len(rows)}
    beside = path.parent / "named.csv"
    with open(beside, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([named, *zip(*named.values())])
    monkeypatch.chdir(path.parent)
    with fits.open(path) as hdus:
        measured = model.measure(hdus, streaks=rows, seeing="90arcsec").table
        forms = [
            (dict(streaks=rows, frame=path), str(path)),
            (dict(streaks=[table], frame=path), str(path)),
            (dict(streaks=columns, frame=hdus), "frame"),
            (dict(streaks=measured["streak", "image", "x1_pix", "y1_pix", "x2_pix", "y2_pix"], frame=hdus), "frame"),
            (dict(streaks=named), str(path)),
            (dict(streaks=beside), str(path)),
        ]
        for given, image in forms:
            one = model.identify(**given, top=2)
            np.testing.assert_allclose(one.unknown_probability, found.unknown_probability, atol=1e-3, err_msg=str(given.keys()))
            assert set(one.streak["image"]) == {image}
    assert list(model.measure([], streaks=named, table="dict").table["norad_id"]) == numbers


def test_damaged_frames_of_several_are_left_out(frame, model, tmp_path):
    from astropy.io import fits

    path = tmp_path / "damaged.fits.fz"
    with fits.open(frame[0]) as hdus:
        fits.HDUList([fits.PrimaryHDU(), fits.CompImageHDU(hdus[0].data, hdus[0].header)]).writeto(path)
    content = bytearray(path.read_bytes())
    content[-10000:-4000] = b"\xff" * 6000
    path.write_bytes(content)
    alone = model.measure(frame[0], seeing="90arcsec", table="dict").table
    found, warned = messages(lambda: model.measure([path, frame[0]], seeing="90arcsec", table="dict"))
    assert list(found.table["norad_id"]) == list(alone["norad_id"]) and len(alone["norad_id"]) > 0
    begin = f"{path}: CFITSIO: damaged compressed data"
    assert sum(text.startswith(begin) and text.endswith("; the frame is left out") for text in warned) == 1, warned
    with pytest.raises(streakcast.StreakcastError, match="damaged compressed data"):
        model.measure(path, seeing="90arcsec")


def test_rows_that_cannot_be_used_have_warnings(frame, model):
    path, truth = frame
    good = {**streak_rows(truth)[0], "id": "good"}
    bad = {**good, "id": "bad", "x1_pix": "left"}
    empty = {"id": "empty"}
    found, warned = messages(lambda: model.identify(streaks=[good, bad, empty], frame=path))
    assert list(found.streak["streak"]) == ["good"] and len(found.n_candidates) == 1
    for words in ("streaks: line 3: x1_pix is 'left'; allowed: -1000000 to 1000000; the streak is left out", "streaks without ends are left out: empty"):
        assert any(words in message for message in warned), (words, warned)
    found, warned = messages(lambda: streakcast.measure_streaks(path, [good, bad, empty]))
    assert list(found.table["streak"]) == ["good", "empty"]
    assert any(message.startswith("streaks: line 3: x1_pix is 'left'") for message in warned), warned
    # Names of temporary files are not shown.
    coloured = [{**good, "colour": 3}]
    for remarks in (model.identify(streaks=coloured, frame=path).remarks, streakcast.measure_streaks(path, coloured).remarks):
        assert "streaks: columns that are not used: colour" in remarks
    # Without any row left, the first problem is an error.
    for call in (lambda rows: model.identify(streaks=rows, frame=path), lambda rows: streakcast.measure_streaks(path, rows)):
        with pytest.raises(streakcast.StreakcastError, match="^streaks: line 2: x1_pix is 'left'"):
            call([bad])
    for given, words in (
        (dict(ends=((1, 2), (3, 4))), "ends and streaks; allowed, one of"),
        (dict(times=["2026-08-14T23:29:05Z"] * 2), "times is accepted with ends only"),
        (dict(frame="none.fits"), "none.fits"),
    ):
        with pytest.raises(ValueError, match=words):
            model.identify(streaks=[good], **given)
