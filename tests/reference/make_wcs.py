#!/usr/bin/env python3
"""Writes golden data of world coordinates: positions on the sky by astropy and wcslib.

    python tests/reference/make_wcs.py DATA_FOLDER > tests/data/wcs_golden.csv

DATA_FOLDER is the folder of real frames (STREAKCAST_DATA); invented headers are in tests/data/wcs. Headers that
streakcast accepts and wcslib rejects are corrected first (see `corrected`).
"""

import datetime
import pathlib
import re
import sys
import warnings

import astropy
import astropy.wcs._wcs
import numpy as np
from astropy.io import fits
from astropy.wcs import WCS

warnings.simplefilter("ignore")
data = pathlib.Path(sys.argv[1])
own = pathlib.Path(__file__).resolve().parent.parent / "data" / "wcs"


def corrected(header):
    """Returns a copy of the header that wcslib reads with the intended meaning."""
    # Only these keywords are kept: with those of the Digitized Sky Survey, wcslib uses the plate solution instead of
    # CTYPE.
    # Values are reformatted, because wcslib reads -1.5D-04 as -1.5.
    used_keywords = re.compile(r"(NAXIS\d?|CTYPE\d|CUNIT\d|CRVAL\d|CRPIX\d|CDELT\d|CROTA\d|CD\d_\d|PC\d_\d|PV\d_\d+|LONPOLE|LATPOLE|RADE.*|"
                        r"EQUINOX|[AB]P?_.*|WAT\d_\d+|IMAGE[WH])$")
    header = fits.Header([(card.keyword, card.value, card.comment) for card in header.cards if used_keywords.match(card.keyword)])
    for axis in "12":
        # 'degree' is not a unit of the FITS standard.
        if header.get(f"CUNIT{axis}", "").strip() == "degree":
            header[f"CUNIT{axis}"] = "deg"
        # SIP coefficients are applied without the suffix; wcslib requires the suffix.
        ctype = header.get(f"CTYPE{axis}", "")
        if "A_ORDER" in header and ctype.endswith("TAN"):
            header[f"CTYPE{axis}"] = ctype + "-SIP"
    # If declination is first, wcslib uses the wrong variables in the polynomials of TPV, so that declination increases
    # with right ascension. The same header with right ascension first is used instead.
    if header.get("CTYPE1") == "DEC--TPV":
        def swapped(name):
            found = re.match(r"(CTYPE|CUNIT|CRVAL|CD|PV)([12])(_\d+)?$", name)
            return found[1] + {"1": "2", "2": "1"}[found[2]] + (found[3] or "") if found else name

        header = fits.Header([(swapped(card.keyword), card.value, card.comment) for card in header.cards])
    if "NAXIS1" not in header and "IMAGEW" in header:
        header["NAXIS"], header["NAXIS1"], header["NAXIS2"] = 2, header["IMAGEW"], header["IMAGEH"]
    return header


def rows(name, hdu, header, count):
    header = corrected(header)
    size = [header["NAXIS1"], header["NAXIS2"]]
    random = np.random.default_rng(20260401 + hdu)
    # The corners, the centre, and positions inside and slightly outside.
    pixels = [[0, 0], [size[0] - 1, 0], [0, size[1] - 1], [size[0] - 1, size[1] - 1], [size[0] / 2, size[1] / 2]]
    inside = random.uniform(-20, np.array(size) + 20, (count, 2)) if count else np.empty((0, 2))
    pixels = np.concatenate([np.array(pixels, float), inside])
    wcs = WCS(header, naxis=2)
    first, second = wcs.all_pix2world(pixels[:, 0], pixels[:, 1], 0)
    if header["CTYPE1"].startswith("DEC"):
        first, second = second, first
    for (x, y), ra, dec in zip(pixels, first, second):
        if np.isfinite(ra) and np.isfinite(dec):
            print(f"{name},{hdu},{x:.17g},{y:.17g},{ra % 360:.17g},{dec:.17g}")


print(f"# astropy {astropy.__version__} (wcslib {astropy.wcs._wcs.WCSLIB_VERSION}), "
      f"make_wcs.py, {datetime.date.today()}: pixels from 0, degrees; files of tests/data/wcs and, with a slash, of the data folder")
print("header,hdu,x,y,ra_deg,dec_deg")
for path in sorted(own.glob("*.hdr")):
    rows(path.name, 0, fits.Header.fromstring(path.read_text(), sep="\n"), 12)
for name in ["galsim_wcs/tpv.fits", "galsim_wcs/tanpv.fits", "galsim_wcs/tanflip.fits", "galsim_wcs/zpx.fits", "galsim_wcs/tnx.fits",
             "galsim_wcs/sipsample.fits", "wcs_rs/cutout-CDS_P_allWISE_W3.fits", "wcs_rs/panstarrs-rotated-around-orion.fits",
             "astride/long.fits", "clean/HorseHead.fits", "clean/gc_2mass_k.fits", "trailblazer/cutout_HSCA21787010.fits",
             "trailblazer/cutout_GMOSN.i.2021-01-17T14_35_11.5_2PAC.fits", "trailblazer/cutout_LMI.VR.2021-06-01T04_06_03.67_1PA.fits",
             "trailblazer/cutout_frame-i-008108-5-0025.fits"]:
    rows("frames/" + name, 0, fits.getheader(data / "frames" / name, 0), 12)
name = "frames/trailblazer/cutout_A3671-C2018_F4-R-3.txt"
text = (data / name).read_text()
rows(name, 0, fits.Header.fromstring(text), 12)
for name in ["cutout_c4d_200306_000415_ori.fits.fz", "cutout_calexp-0941420_23.fits", "cutout_lbcb.20210407.120357.fits"]:
    name = "frames/trailblazer/" + name
    with fits.open(data / name) as hdus:
        for number, hdu in enumerate(hdus):
            if number > 0 and hdu.header.get("NAXIS") == 2 and re.match("RA|DEC", hdu.header.get("CTYPE1", "")):
                rows(name, number, hdu.header, 1)
