"""Computes the magnitudes of a black body in infrared bands, for `src/photometry/band.rs`.

pip install speclite==1.0.0; python tests/reference/make_infrared_bands.py FOLDER_OF_SPECLITE/data/filters

Response curves: 2MASS (Cohen et al. 2003, AJ 126, 1090) and WISE (Wright et al. 2010, AJ 140, 1868) as in speclite
1.0.0 (BSD licence). Prints AB magnitudes of 1 m2 of a black body at a range of 1000 km, and the colour corrections of
WISE for black bodies, which agree with table 1 of Wright et al. (2.0577, 1.3917, 1.1316 in W1; 1.3448, 1.1124, 1.0229 in
W2 at 200, 283 and 400 K).
"""

import math
import re
import sys
from pathlib import Path

# CODATA 2018: Planck's constant (J s), speed of light (m/s), Boltzmann's constant (J/K).
H, C, K = 6.62607015e-34, 2.99792458e8, 1.380649e-23
TO_UM = {"micron": 1.0, "Angstrom": 1e-4}


def read(path):
    """Returns wavelengths (um) and responses (electrons per photon, relative)."""
    text = path.read_text()
    scale = TO_UM[re.search(r"name: wavelength, unit: (\w+)", text).group(1)]
    cells = [line.split() for line in text.splitlines() if line[:1].isdigit()]
    return [(float(wavelength) * scale, float(response)) for wavelength, response in cells]


def planck(wavelength_um, kelvin):
    """Returns the spectral radiance B_nu, W m-2 Hz-1 sr-1."""
    frequency = C / (wavelength_um * 1e-6)
    return 2 * H * frequency**3 / C**2 / math.expm1(H * frequency / (K * kelvin))


def mean(curve, of):
    """Returns the mean of F_nu by photons: integral of F_nu R dlambda / lambda, over that of R dlambda / lambda."""
    total = weights = 0.0
    for (left, low), (right, high) in zip(curve, curve[1:]):
        for step in range(20):
            share = (step + 0.5) / 20
            wavelength = left + (right - left) * share
            weight = (low + (high - low) * share) * (right - left) / 20 / wavelength
            total += of(wavelength) * weight
            weights += weight
    return total / weights


def main():
    folder = Path(sys.argv[1])
    for name, isophotal in [("twomass-J", 1.235), ("twomass-H", 1.662), ("twomass-Ks", 2.159), ("wise2010-W1", 3.3526),
                            ("wise2010-W2", 4.6028)]:
        curve = read(folder / f"{name}.ecsv")
        kelvins = (200, 280, 283, 290, 400)
        flux = {kelvin: mean(curve, lambda um, kelvin=kelvin: planck(um, kelvin)) for kelvin in kelvins}
        # AB: 3631 Jy at magnitude 0; 1 m2 at 1e6 m is 1e-12 sr.
        magnitudes = [-2.5 * math.log10(flux[kelvin] * 1e-12 / 3631e-26) for kelvin in (280, 290)]
        # The reference spectrum of WISE is F_nu ~ nu^-2.
        reference = mean(curve, lambda um: um**2) / isophotal**2
        colours = [flux[kelvin] / planck(isophotal, kelvin) / reference for kelvin in (200, 283, 400)]
        print(name, "280 K, 290 K:", *(f"{one:.3f}" for one in magnitudes))
        print("    colours:", *(f"{one:.4f}" for one in colours))


if __name__ == "__main__":
    main()
