"""Writes src/frames/deep_sky.csv: names and positions of the Messier and Caldwell objects.

    python tests/reference/make_deep_sky.py Messier.csv Caldwell.csv > src/frames/deep_sky.csv

Both files are in https://github.com/timmyd7777/SSCore, folder SSData/DeepSky ("free of charge for any purpose"). Their
positions are those of the Revised NGC and IC of W. Steinicke.
"""

import csv
import re
import sys


def degrees(text):
    """Returns the degrees of a sexagesimal text: a sign, then three numbers."""
    sign = -1 if text.startswith("-") else 1
    first, minutes, seconds = (float(part) for part in text.lstrip("+-").split())
    return sign * (first + minutes / 60 + seconds / 3600)


print("# names separated by |;right ascension deg;declination deg (ICRS)")
print("# Origin: W. Steinicke, Revised NGC and IC, through SSCore (T. DeBenedictis); made by tests/reference/make_deep_sky.py")
for path in sys.argv[1:]:
    for row in csv.DictReader(open(path)):
        # M, Caldwell, NGC and IC numbers; other catalogues are omitted.
        names = [re.sub(r"^C (\d+)$", r"Caldwell \1", name.strip()) for name in row["IDs"].split(";")]
        names = [name for name in names if re.fullmatch(r"(M|NGC|IC|Caldwell) ?\d+", name)]
        names += [name.strip() for name in (row["Names"] or "").split(";") if name.strip()]
        print(f"{'|'.join(names)};{15 * degrees(row['RA']):.4f};{degrees(row['Dec']):.4f}")
