"""Writes src/plot/bright_stars.csv: positions and magnitudes of the stars to V = 6.

    python tests/reference/make_bright_stars.py stars.6.json starnames.json > src/plot/bright_stars.csv

The files are in the npm package d3-celestial 0.7.35, folder data. Its stars are those of XHIP, an extended Hipparcos
compilation (Anderson and Francis 2012, VizieR V/137D), ICRS at epoch J2000. The 30 brightest stars and Polaris have
their names in the catalogue of star names of the International Astronomical Union; of α Centauri, only the brighter
component has one.
"""

import json
import sys

MOST_NAMED = 30
POLARIS, ALPHA_CENTAURI_B = 11767, 71681

stars = json.load(open(sys.argv[1]))["features"]
names = json.load(open(sys.argv[2]))
by_brightness = sorted(stars, key=lambda star: star["properties"]["mag"])
named = [star["id"] for star in by_brightness if star["id"] != ALPHA_CENTAURI_B][:MOST_NAMED] + [POLARIS]

print("# ra_deg,dec_deg,v_mag,name: ICRS at epoch J2000, degrees; Hipparcos magnitude V")
print("# Origin: XHIP (Anderson and Francis 2012, VizieR V/137D), through d3-celestial 0.7.35 (O. Frohn); made by tests/reference/make_bright_stars.py")
for star in stars:
    longitude_deg, dec_deg = star["geometry"]["coordinates"]
    name = names[str(star["id"])]["name"] if star["id"] in named else ""
    print(f"{longitude_deg % 360:.3f},{dec_deg:.3f},{star['properties']['mag']:.2f},{name}")
