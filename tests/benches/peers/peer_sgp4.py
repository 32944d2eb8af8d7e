"""python-sgp4 with `SatrecArray` (C++, one thread), and chords."""

import numpy as np
import sgp4
from sgp4.api import WGS72, Satrec, SatrecArray

from chord import run


def load(pairs):
    satellites = [Satrec.twoline2rv(first, second, WGS72) for first, second in pairs]
    return SatrecArray(satellites), np.array([satellite.satnum for satellite in satellites])


def propagate(array, jd, fractions):
    error, position, velocity = array.sgp4(np.full_like(fractions, jd), fractions)
    position[error != 0] = np.nan
    return position.transpose(1, 0, 2), velocity.transpose(1, 0, 2)


if __name__ == "__main__":
    run(f"python-sgp4 {sgp4.__version__}, chord test", load, propagate)
