"""Writes mean magnitudes of bundled models over the population of `streakcast model check`.

The method differs from that of the program: satellites with uniform nodes and arguments of latitude on circular orbits
are used if they are above 30 deg and in full sunlight. Earth and shadow are spherical.

    venv/bin/python tests/reference/make_population_means.py > tests/data/population_means.csv
"""
import json
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from model_magnitudes import MODELS, bundled_magnitude  # noqa: E402

EARTH_KM, AU_KM, SUN_KM = 6378.137, 149597870.7, 695700.0
SHELLS = {"visorsat": (550, 53), "visorsat-panels": (550, 53), "starlink-v1.5": (540, 53.2), "starlink-v1.5-facets": (540, 53.2),
          "starlink-v1.5-phase": (540, 53.2), "v2mini": (525, 53), "v2mini-panels": (525, 53), "direct-to-cell": (360, 53),
          "oneweb-panels": (1200, 87.9)}
MOMENTS = 48


def angles(height_km, inclination_deg):
    """Returns the Sun's latitude and the observer's longitude and latitude of all selected satellites, at all times."""
    r, i, site = EARTH_KM + height_km, np.radians(inclination_deg), np.radians(40)
    node, u = np.meshgrid(np.arange(1200) * 2 * np.pi / 1200, (np.arange(1201) + 0.5) * 2 * np.pi / 1201, indexing="ij")
    z = np.stack([np.cos(node) * np.cos(u) - np.sin(node) * np.sin(u) * np.cos(i),
                  np.sin(node) * np.cos(u) + np.cos(node) * np.sin(u) * np.cos(i), np.sin(u) * np.sin(i)]).reshape(3, -1)
    up = np.array([np.cos(site), 0, np.sin(site)])
    way = r * z - EARTH_KM * up[:, None]
    way /= np.linalg.norm(way, axis=0)
    high = up @ way > 0.5
    z, way = z[:, high], way[:, high]
    ends = [np.arccos(np.sin(np.radians(a)) / np.cos(site)) for a in (-12, -30)]
    found = []
    for k in range(MOMENTS):
        h = ends[0] + (ends[1] - ends[0]) * (k + 0.5) / MOMENTS
        sun = np.array([np.cos(h), -np.sin(h), 0])
        # Full sunlight: seen from the satellite, the whole disk of the Sun is above the limb of the Earth.
        s = sun[:, None] * AU_KM - r * z
        s /= np.linalg.norm(s, axis=0)
        to_sun_from_nadir = np.arccos(-(s * z).sum(0))
        lit = to_sun_from_nadir > np.arcsin(EARTH_KM / r) + np.arcsin(SUN_KM / AU_KM)
        s, o, n = s[:, lit], -way[:, lit], z[:, lit]
        ds, do = np.arcsin((s * n).sum(0)), np.arcsin((o * n).sum(0))
        a = np.arccos(np.clip(((s * o).sum(0) - np.sin(ds) * np.sin(do)) / (np.cos(ds) * np.cos(do)), -1, 1))
        found.append(np.stack([ds, a, do]))
    return np.concatenate(found, axis=1)


print("# Mean and standard deviation of model magnitudes at 1000 km over satellites of a shell in twilight.")
print(f"# numpy {np.__version__}; python tests/reference/make_population_means.py; 2026-11-22")
print("model,mean_mag,sd_mag")
for name, shell in SHELLS.items():
    ds, a, do = angles(*shell)
    # Models predict medians; the mean of single magnitudes is 0.2 sigma brighter.
    value = bundled_magnitude(name, ds, a, do) - 0.2 * json.load(open(MODELS / f"{name}.json"))["sigma_mag"]
    print(f"{name},{np.nanmean(value):.4f},{np.nanstd(value):.4f}")
