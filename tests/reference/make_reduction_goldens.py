"""Writes golden values of the reduction of photometry: quartiles, kernel modes, and HEALPix cells of directions.

    python tests/reference/make_reduction_goldens.py tests/data

Quartiles are computed by numpy, kernel modes by scipy.stats.gaussian_kde on a fine grid (with the same bandwidth, so
that only the density is compared), half-sample modes by a direct implementation of the recursion of Bickel and
Fruehwirth (2006), and cells by healpy.
"""

import datetime
import sys
from pathlib import Path

import healpy
import numpy as np
import scipy
from scipy.stats import gaussian_kde


def half_sample_mode(x):
    """Returns the half-sample mode of a sorted sample, by recursion."""
    n = len(x)
    if n == 1:
        return x[0]
    if n == 2:
        return (x[0] + x[1]) / 2
    if n == 3:
        low, high = x[1] - x[0], x[2] - x[1]
        return (x[0] + x[1]) / 2 if low < high else (x[1] + x[2]) / 2 if low > high else x[1]
    half = -(-n // 2)
    widths = x[half - 1 :] - x[: n - half + 1]
    ties = np.flatnonzero(widths == widths.min())
    start = ties[(len(ties) - 1) // 2]
    return half_sample_mode(x[start : start + half])


def kernel_mode(x, sigma):
    density = gaussian_kde(x, bw_method=sigma / x.std(ddof=1))
    grid = np.linspace(x[0], x[-1], 20001)
    best = grid[np.argmax(density(grid))]
    fine = np.linspace(best - 2 * (grid[1] - grid[0]), best + 2 * (grid[1] - grid[0]), 2001)
    return fine[np.argmax(density(fine))]


def samples(random):
    for n in (4, 5, 9, 20, 80, 81, 300):
        yield random.normal(7, 0.3, n)
        core = random.normal(6.5, 0.15, n)
        yield np.where(random.uniform(size=n) < 0.3, core + random.exponential(1.0, n), core)


def origin(what):
    today = datetime.date.today()
    return f"# {what}; python tests/reference/make_reduction_goldens.py tests/data; {today}\n"


def main(folder):
    random = np.random.default_rng(20210101)
    with open(folder / "density_modes.csv", "w") as out:
        out.write(origin(f"numpy {np.__version__}, scipy {scipy.__version__}; half-sample mode: Bickel and Fruehwirth (2006), written plainly"))
        out.write("first_quartile,median,third_quartile,kernel_sigma,kernel_mode,half_sample_mode,sample\n")
        for sample in samples(random):
            x = np.sort(np.round(sample, 4))
            quartiles = np.percentile(x, [25, 50, 75])
            # Silverman (1986), eq. 3.31
            sigma = 0.9 * min(x.std(ddof=1), (quartiles[2] - quartiles[0]) / 1.34) * len(x) ** -0.2
            numbers = [*quartiles, sigma, kernel_mode(x, sigma), half_sample_mode(x)]
            out.write(",".join(f"{number:.9f}" for number in numbers))
            out.write("," + " ".join(f"{value:.4f}" for value in x) + "\n")
    with open(folder / "healpix_cells.csv", "w") as out:
        out.write(origin(f"healpy {healpy.__version__}: ang2pix(nside, longitude, latitude, lonlat=True), RING"))
        out.write("nside,longitude_deg,latitude_deg,cell\n")
        for nside in (1, 2, 7, 32, 64, 1024):
            longitudes = random.uniform(-180, 540, 40)
            latitudes = np.degrees(np.arcsin(random.uniform(-1, 1, 40)))
            latitudes[:2] = [89.999, -89.999]
            for longitude, latitude in zip(longitudes, latitudes):
                cell = healpy.ang2pix(nside, longitude % 360, latitude, lonlat=True)
                out.write(f"{nside},{longitude:.12f},{latitude:.12f},{cell}\n")


main(Path(sys.argv[1]))
