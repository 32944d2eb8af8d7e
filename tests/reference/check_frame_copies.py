#!/usr/bin/env python3
"""Compares copies of real frames with their originals with astropy: unchanged content and valid checksums.

    STREAKCAST_DATA=... STREAKCAST_KEEP=FOLDER cargo test --test images frame_copies
    python tests/reference/check_frame_copies.py DATA_FOLDER FOLDER

The test writes each copy with the name of its original. In the copy one image is changed, one line of HISTORY is added,
and one image and one table are appended. This script reads both files with astropy only.
"""

import pathlib
import sys
import warnings

import numpy as np
from astropy.io import fits

warnings.simplefilter("ignore")
data, folder = pathlib.Path(sys.argv[1]) / "frames", pathlib.Path(sys.argv[2])
# Keywords in the header of the table of tiles that may change by compression. EXTEND is T if there are extensions;
# astropy adds it if it is missing.
packing = {"EXTEND", "PCOUNT", "TFORM1", "TFORM2", "TFORM3", "CHECKSUM", "DATASUM", "THEAP"}
failures = 0


def report_failure(*words):
    global failures
    failures += 1
    print("FAIL", *words)


def cards(header, left_out=()):
    return [card.image for card in header.cards if card.keyword not in left_out]


def ones_complement(data):
    total = int(np.frombuffer(data, ">u4").sum(dtype=np.uint64))
    while total >> 32:
        total = (total & 0xFFFFFFFF) + (total >> 32)
    return total


def verified(path, number):
    """Checks CHECKSUM and DATASUM of an HDU from its bytes (astropy changes some headers before its check)."""
    with fits.open(path, disable_image_compression=True) as hdus:
        place, header = hdus.fileinfo(number), hdus[number].header
    data = path.read_bytes()
    begin, middle, end = place["hdrLoc"], place["datLoc"], place["datLoc"] + place["datSpan"]
    return [ones_complement(data[begin:end]) == 0xFFFFFFFF if "CHECKSUM" in header else None,
            ones_complement(data[middle:end]) == int(header["DATASUM"]) if "DATASUM" in header else None]


for copy in sorted(folder.iterdir()):
    original = next(data.glob(f"*/{copy.name}"))
    with fits.open(original, disable_image_compression=True) as before, fits.open(copy, disable_image_compression=True) as after:
        if len(after) != len(before) + 2:
            report_failure(copy.name, len(before), len(after))
        changed = [n for n in range(len(before)) if cards(before[n].header, {"EXTEND"}) != cards(after[n].header, {"EXTEND"})]
        for number, (old, new) in enumerate(zip(before, after)):
            if number not in changed:
                if before.fileinfo(number)["datSpan"] != after.fileinfo(number)["datSpan"]:
                    report_failure(copy.name, number, "data")
                continue
            history = [card for card in cards(new.header) if card.startswith("HISTORY") and card not in cards(old.header)]
            stayed = [card for card in cards(new.header, packing) if card not in history]
            if stayed != cards(old.header, packing):
                report_failure(copy.name, number, "cards", set(stayed) ^ set(cards(old.header, packing)))
            if len(history) != 1:
                report_failure(copy.name, number, "history", history)
            if any(result is False for result in verified(copy, number)):
                report_failure(copy.name, number, "sums", verified(copy, number))
        sums = [verified(copy, number) for number in changed]
    with fits.open(original) as before, fits.open(copy) as after:
        for number in range(len(before)):
            old, new = before[number].data, after[number].data
            if old is None:
                continue
            if old.dtype.names:
                if old.tobytes() != new.tobytes():
                    report_failure(copy.name, number, "table")
            elif number in changed:
                other = np.argwhere(~((old == new) | (np.isnan(old.astype(float)) & np.isnan(new.astype(float)))))
                rows = set(other[:, 0]) - set(range(10, 20))
                if rows or len(other) == 0:
                    report_failure(copy.name, number, "rows", rows, len(other))
            elif not np.array_equal(old, new, equal_nan=old.dtype.kind == "f"):
                report_failure(copy.name, number, "pixels")
        if after[-2].name != "MASK" or after[-1].name != "STREAKS":
            report_failure(copy.name, after[-2].name, after[-1].name)
    print(f"{copy.name}: {len(before)} HDUs kept, changed {changed}, CHECKSUM and DATASUM right: {sums}")
print(f"{failures} failures")
sys.exit(failures != 0)
