"""Writes src/frames/bright_stars.csv: positions and magnitudes of the stars to V = 6.

    python tests/reference/make_bright_stars.py stars.6.json > src/frames/bright_stars.csv

The file is in the npm package d3-celestial 0.7.35, folder data. Its stars are those of XHIP, an extended Hipparcos
compilation (Anderson and Francis 2012, VizieR V/137D), ICRS at epoch J2000.
"""

import json
import sys

print("# ra_deg,dec_deg,v_mag: ICRS at epoch J2000, degrees; Hipparcos magnitude V")
print("# Origin: XHIP (Anderson and Francis 2012, VizieR V/137D), through d3-celestial 0.7.35 (O. Frohn); made by tests/reference/make_bright_stars.py")
for star in json.load(open(sys.argv[1]))["features"]:
    longitude_deg, dec_deg = star["geometry"]["coordinates"]
    print(f"{longitude_deg % 360:.3f},{dec_deg:.3f},{star['properties']['mag']:.2f}")
