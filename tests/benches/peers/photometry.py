"""Compares streakcast, a vectorised numpy form of the same model, and lumos-sat on the same directions.

    pip install --no-deps -r tests/benches/peers/requirements-photometry.txt
    python tests/benches/peers/photometry.py [--rounds 5]

Every round runs each program once, and ratios are computed within a round; medians are printed. streakcast is measured
by `cargo bench --bench magnitudes` (columns on one core; its first lines) and `--bench photometry` (earthshine computed
and from the table), numpy by tests/reference/model_magnitudes.py on one thread, and lumos-sat by its published
calculator with one direction per call.
"""

import argparse
import os
import re
import statistics
import subprocess
import sys
import time
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np  # noqa: E402

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/reference"))
from model_magnitudes import basis, magnitude  # noqa: E402

SHAPE = (8.1, 2.8, 1.3, 2.8)
COEFFICIENTS = (0.05, 0.0279, 0.0053, 0.1097, 0.0844, 5.0, 22.0)


def streakcast_ns():
    text = subprocess.run(["cargo", "bench", "-q", "--bench", "magnitudes"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return float(re.search(r"both lobes: ([0-9.]+) ns a direction at once", text)[1])


def numpy_ns(n=20_000, repeats=11):
    rng = np.random.default_rng(1)
    angles = rng.uniform(-0.4, -0.05, n), rng.uniform(0, 6.28, n), rng.uniform(-1.5, -0.3, n)
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        magnitude(basis(SHAPE, *angles), COEFFICIENTS)
        times.append(time.perf_counter() - start)
    return statistics.median(times) / n * 1e9


def lumos_ns(earthshine, n):
    import lumos.brdf.library as brdf
    import lumos.calculator as calculator
    from lumos.geometry import Surface

    c1, c2, _, c4, c5, n_sail, n_base = COEFFICIENTS
    surfaces = [
        Surface(SHAPE[2] * SHAPE[3], np.array([0.0, 0.0, -1.0]), brdf.PHONG(c5, c4, n_base)),
        Surface(SHAPE[0] * SHAPE[1], np.array([0.0, 1.0, 0.0]), brdf.PHONG(c2, c1, n_sail)),
    ]
    rng = np.random.default_rng(1)
    earth_m = 6.371e6
    times = []
    for _ in range(n):
        away, around, past = rng.uniform(0, 0.25), rng.uniform(0, 6.28), rng.uniform(0.05, 0.35)
        place = earth_m * np.array([np.sin(away) * np.cos(around), np.sin(away) * np.sin(around), np.cos(away)])
        start = time.perf_counter()
        calculator.get_intensity_satellite_frame(
            surfaces, 550e3, past, place, include_earthshine=earthshine, earth_brdf=brdf.LAMBERTIAN(0.3)
        )
        times.append(time.perf_counter() - start)
    return statistics.median(times) * 1e9


def streakcast_map_ns():
    command = ["cargo", "bench", "-q", "--bench", "maps", "--", "all_sky_nside_64", "--sample-count", "30"]
    text = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    # Columns: fastest, slowest, median. In the first row the Sun is at 0, with sunlight only.
    row = next(line for line in text.splitlines() if re.search(r"─ 0 +[0-9.]+ ", line))
    number, unit = re.search(r"([0-9.]+) (ns|µs|ms)", row.split("│")[-4]).groups()
    return float(number) * {"ns": 1, "µs": 1e3, "ms": 1e6}[unit]


def numpy_map_ns(repeats=7, nside=64, height_km=550.0):
    """Measures all directions of nside 64 with the Sun at the horizon: positions, body-frame angles, magnitudes."""
    n = 6 * nside**2 + 2 * nside
    altitude = np.arcsin((np.arange(n) + 0.5) / n)
    azimuth = np.mod(2.399963 * np.arange(n), 2 * np.pi)
    earth_km, sun = 6378.137, np.array([1.0, 0.0, 0.0]) * 149_597_870.7
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        d = np.stack([np.cos(altitude) * np.cos(azimuth), np.cos(altitude) * np.sin(azimuth), np.sin(altitude)])
        b = earth_km * d[2]
        rho = -b + np.sqrt(b * b + (earth_km + height_km) ** 2 - earth_km**2)
        place = d * rho
        place[2] += earth_km
        z = place / np.sqrt((place**2).sum(0))
        s = sun[:, None] - place
        s /= np.sqrt((s**2).sum(0))
        sin_s, sin_o = (s * z).sum(0), -(d * z).sum(0)
        ds, do = np.arcsin(sin_s), np.arcsin(sin_o)
        cos_a = ((s * -d).sum(0) - sin_s * sin_o) / (np.cos(ds) * np.cos(do))
        a = np.arccos(np.clip(cos_a, -1, 1))
        m = magnitude(basis(SHAPE, ds, a, do), COEFFICIENTS) + 5 * np.log10(rho / 1000)
        times.append(time.perf_counter() - start)
        assert np.isfinite(m).all()
    return statistics.median(times) * 1e9


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    subprocess.run(["cargo", "bench", "-q", "--bench", "magnitudes", "--no-run"], cwd=ROOT, check=True)
    rows, maps = [], []
    for _ in range(rounds):
        rows.append((streakcast_ns(), numpy_ns(), lumos_ns(False, 2000), lumos_ns(True, 50)))
        maps.append((streakcast_map_ns(), numpy_map_ns()))
    names = ("streakcast, columns", f"numpy {np.__version__}", "lumos-sat, Sun only", "lumos-sat, earthshine 150")
    print(f"{'':28} {'ns a direction':>16} {'ratio':>12}")
    for place, name in enumerate(names):
        ratio = statistics.median(row[place] / row[0] for row in rows)
        print(f"{name:28} {statistics.median(row[place] for row in rows):16,.1f} {ratio:12,.1f}")
    streakcast_ms, numpy_ms = (statistics.median(row[place] for row in maps) / 1e6 for place in (0, 1))
    ratio = statistics.median(row[1] / row[0] for row in maps)
    print(f"all sky at nside 64: {streakcast_ms:.2f} ms on all cores, numpy on one {numpy_ms:.1f} ms, ratio {ratio:.1f}")


if __name__ == "__main__":
    main()
