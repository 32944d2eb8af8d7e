"""A real frame beside the same frame with the mask of its streak: `mask.py PICTURE.png`; docs/build.sh calls this script.

Needs STREAKCAST_BIN and the folder of real data (STREAKCAST_DATA). The frame is a part of exposure HSCA21787010 of Hyper
Suprime-Cam with the streak of a satellite (NORAD 25791), from the test data of trailblazer (MIT licence).
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

DATA = Path(os.environ.get("STREAKCAST_DATA", Path(__file__).parents[2] / "shared" / "data"))
FRAME = DATA / "frames/trailblazer/cutout_HSCA21787010.fits"
SATELLITES = ["--elements", DATA / "tle/fullcat/tle_2020-05-17.txt", "--accept-bad-checksums", "--quiet"]
# The mask of a measured streak does not depend on the zero point.
OPTIONS = [*SATELLITES, "--zero-point", "30.5", "--seeing", "0.8arcsec"]
MASK_COLOUR = (230, 97, 1)
GAP_PIX = 16


def image(path):
    """First image of a small FITS file of integers, with the first row at the top."""
    data = Path(path).read_bytes()
    text = data.decode("latin-1")
    cards = {}
    for at in range(0, len(text), 80):
        key = text[at : at + 8].strip()
        if key == "END":
            break
        cards[key] = text[at + 10 : at + 80].split("/")[0].strip()
    shape = int(cards["NAXIS2"]), int(cards["NAXIS1"])
    kind = {"8": "u1", "16": ">i2"}[cards["BITPIX"]]
    values = np.frombuffer(data, kind, shape[0] * shape[1], -(-(at + 80) // 2880) * 2880)
    return values.reshape(shape) + float(cards.get("BZERO", 0))


def main(picture):
    binary = os.environ["STREAKCAST_BIN"]
    with tempfile.TemporaryDirectory() as folder:
        measured, mask = Path(folder, "measured.csv"), Path(folder, "mask.fits")
        subprocess.run([binary, "measure", FRAME, *OPTIONS, "--gain", "3.2", "--fit-width", "-o", measured], check=True)
        subprocess.run([binary, "mask", FRAME, *OPTIONS, "--measured", measured, "-o", mask], check=True)
        pixels, is_masked = image(FRAME)[::-1], image(mask)[::-1] != 0
    sky, noise = np.median(pixels), 1.4826 * np.median(np.abs(pixels - np.median(pixels)))
    grey = np.arcsinh((pixels - sky) / (5 * noise)) / np.arcsinh(60)
    grey = np.clip(0.15 + 0.85 * grey, 0, 1)[..., None] * [255, 255, 255]
    masked = np.where(is_masked[..., None], 0.5 * grey + 0.5 * np.array(MASK_COLOUR), grey)
    gap = np.full((len(grey), GAP_PIX, 3), 255)
    both = np.concatenate([grey, gap, masked], axis=1).astype(np.uint8)
    Image.fromarray(both).quantize(256, dither=0).save(picture, optimize=True)


if __name__ == "__main__":
    main(sys.argv[1])
