"""Detects streaks added by `streakcast inject` with independent programs.

    tests/independent.sh, or
    venv/bin/python tests/reference/recover_streaks.py target/release/streakcast ../shared/data

Position and angle are those of acstools' median Radon transform (findsat_mrt), which does not use the true values. The
flux is NumPy's integral of the median cross-section, times the length. The width is that of a Moffat profile fitted by
SciPy to the mean cross-section. The exit code is 1 if a difference exceeds the limits below.
"""
import csv
import pathlib
import subprocess
import sys
import tempfile
import warnings

import numpy as np
from acstools.findsat_mrt import TrailFinder
from astropy.io import fits
from scipy.ndimage import map_coordinates
from scipy.optimize import curve_fit

warnings.simplefilter("ignore")
BINARY, DATA = sys.argv[1], pathlib.Path(sys.argv[2])
FRAMES = DATA / "frames"
# Limits: degrees between angles; pixels between lines; fractions of flux and width. The transform has steps of 0.5
# degrees and one pixel; 0.5 degrees move the ends in the shortest frame by one pixel.
ANGLE_DEG, PLACE_PIX, FLUX_SHARE, WIDTH_SHARE = 1.0, 2.0, 0.05, 0.10
CASES = [
    ("synthetic", ["--synthetic", "examples/synthetic.toml", "--exposure", "30s"], 5.5, ["--seeing", "1.5arcsec"], 0),
    ("Horsehead", ["--image", FRAMES / "clean/HorseHead.fits"], 4.5, ["--seeing", "3arcsec", "--zero-point", "34", "--gain", "1"], 0),
    ("SDSS", ["--image", FRAMES / "trailblazer/cutout_frame-i-008108-5-0025.fits"], 6.0, ["--seeing", "1.3arcsec"], 0),
    ("calexp", ["--image", FRAMES / "trailblazer/cutout_calexp-0941420_23.fits", "--start", "2020-03-06T00:04:15.41Z"], 5.0,
     ["--telescope", "decam", "--zero-point", "31.4", "--gain", "4"], 1),
]


def inject(what, magnitude, more, seed, folder):
    out, truth = folder / "out.fits", folder / "truth.csv"
    subprocess.run([BINARY, "inject", *map(str, what), "-o", out, "--truth", truth, "--random-streaks", "1", "--magnitude", str(magnitude),
                    "--seed", str(seed), "--quiet", *more], check=True)
    rows = list(csv.DictReader(line for line in truth.open() if not line.startswith("#")))
    return out, rows[0]


def found_by_transform(image):
    finder = TrailFinder(image=image, threshold=5, min_length=25, max_width=75, buffer=20, processes=2, theta=np.arange(0, 180, 0.5), plot=False,
                         save_catalog=False, save_diagnostic=False, check_persistence=False)
    finder.run_mrt()
    finder.find_mrt_sources()
    # The source filter of findsat_mrt fits widths, which fails for some frames; the strongest source is the streak.
    sources = finder.source_list
    return np.array(sources[np.argmax(sources["max_value" if "max_value" in sources.colnames else "flux"])]["endpoints"], dtype=float)


def cut_across(image, start, end, half):
    way = (end - start) / np.hypot(*(end - start))
    across = np.array([-way[1], way[0]])
    along = np.arange(10, np.hypot(*(end - start)) - 10, 0.5)
    offsets = np.arange(-half, half + 0.25, 0.25)
    x = start[0] + along[None, :] * way[0] + offsets[:, None] * across[0]
    y = start[1] + along[None, :] * way[1] + offsets[:, None] * across[1]
    return offsets, np.nanmedian(map_coordinates(image, [y, x], order=1, mode="nearest"), axis=1)


failed = 0
print(f"{'frame':24}{'angle deg':>12}{'place pix':>12}{'flux':>9}{'width':>9}")
for name, what, magnitude, more, hdu in CASES:
    if what[0] == "--image" and not what[1].is_file():
        print(f"*** SKIPPED independent.sh: {name}: no {what[1]}")
        continue
    with tempfile.TemporaryDirectory() as folder:
        out, truth = inject(what, magnitude, more, 3, pathlib.Path(folder))
        image = np.nan_to_num(fits.getdata(out, hdu).astype(float), nan=np.nanmedian(fits.getdata(out, hdu)))
    image -= np.median(image)
    ends = found_by_transform(image)
    true = np.array([[float(truth[f"{axis}{end}_pix"]) - 1 for axis in "xy"] for end in "12"])
    angle = lambda pair: np.degrees(np.arctan2(*(pair[1] - pair[0])[::-1])) % 180
    turned = (angle(ends) - angle(true) + 90) % 180 - 90
    way = (true[1] - true[0]) / np.hypot(*(true[1] - true[0]))
    normal = np.array([-way[1], way[0]])
    middle = ends.mean(axis=0)
    beside = (middle - true[0]) @ normal
    # Flux and width are measured on the true line, which agrees with the detected one within the tolerance.
    length = np.hypot(*(true[1] - true[0]))
    half = 6 * float(truth["width_pix"])
    offsets, profile = cut_across(image, *true, half)
    moffat = lambda x, height, centre, alpha, beta, sky: sky + height * (1 + ((x - centre) / alpha) ** 2) ** -beta
    guess = [profile.max() - profile.min(), 0.0, float(truth["width_pix"]), 3.0, profile.min()]
    (_, _, alpha, beta, sky), _ = curve_fit(moffat, offsets, profile, p0=guess, maxfev=20000)
    width = 2 * abs(alpha) * np.sqrt(2 ** (1 / beta) - 1) / float(truth["width_pix"])
    # The median cross-section times the length is insensitive to stars on the streak.
    flux = np.trapezoid(profile - sky, offsets) * length / float(truth["counts"])
    good = abs(turned) < ANGLE_DEG and abs(beside) < PLACE_PIX and abs(flux - 1) < FLUX_SHARE and abs(width - 1) < WIDTH_SHARE
    failed += not good
    print(f"{name:24}{turned:12.2f}{beside:12.2f}{flux:9.3f}{width:9.3f}{'' if good else '   OUTSIDE'}")
sys.exit(failed > 0)
