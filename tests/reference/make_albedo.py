"""Share of land and of lasting ice in cells of 10 degrees, for src/photometry/earthshine/land_10deg.csv.

pip install global-land-mask==1.0.0 numpy; python tests/reference/make_albedo.py > src/photometry/earthshine/land_10deg.csv

global-land-mask (MIT licence) is NOAA's GLOBE elevation model as a mask of one arc minute; here sampled every 0.25 degrees.
Lasting ice is land south of 60 S, and Greenland: land within 60-84 N, 73-11 W, without Ellesmere (78 N up, west of
65 W) and Iceland (south of 67 N, east of 25 W).
"""

from importlib.metadata import version

import numpy as np
from global_land_mask import globe

print("# Share of land, and of it the share under lasting ice, in cells of 10 degrees, named by their centres.")
print(f"# Origin: global-land-mask {version('global-land-mask')} (NOAA GLOBE, 1 arc minute), by tests/reference/make_albedo.py, 2026-11-21.")
print("latitude_deg,longitude_deg,land_fraction,ice_fraction")
step = 0.25
for south in range(-90, 90, 10):
    for west in range(-180, 180, 10):
        lat, lon = np.meshgrid(south + step / 2 + np.arange(0, 10, step), west + step / 2 + np.arange(0, 10, step), indexing="ij")
        land = globe.is_land(lat, lon)
        greenland = (lat > 60) & (lat < 84) & (lon > -73) & (lon < -11)
        greenland &= ~((lat > 78) & (lon < -65)) & ~((lat < 67) & (lon > -25))
        ice = land & ((lat < -60) | greenland)
        weight = np.cos(np.radians(lat))
        share = lambda mask: (mask * weight).sum() / weight.sum()
        print(f"{south + 5},{west + 5},{share(land):.3f},{share(ice):.3f}")
