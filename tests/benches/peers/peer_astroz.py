"""astroz for near-Earth objects, python-sgp4 for deep space, and chords: the fastest combination that was found.

The SIMD SGP4 of astroz writes to one preallocated array, without velocities, as in `astroz.propagate`. Its batch SDP4
takes three times as long as python-sgp4 for the 888 deep-space objects (10.4 against 3.1 ms for four times), and its
threads are slow on a busy machine; neither is used.
"""

import astroz
import numpy as np
import sgp4
from astroz import _astroz
from sgp4.api import WGS72, Satrec, SatrecArray

from chord import SAMPLES, run


class Sky:
    def __init__(self, pairs):
        near, deep = [], []
        for first, second in pairs:
            satellite = _astroz.Satrec.twoline2rv(first, second, _astroz.WGS72)
            if satellite.is_deep_space:
                deep.append(Satrec.twoline2rv(first, second, WGS72))
            elif satellite.error == 0:
                near.append(satellite)
        self.near = _astroz.Sgp4Constellation(near, gravity_model=_astroz.WGS72)
        self.deep = SatrecArray(deep)
        self.epochs = np.array(self.near.epochs)
        self.ids = np.array([s.satnum for s in near + deep])
        self.position = np.empty((SAMPLES, len(self.ids), 3))


def load(pairs):
    sky = Sky(pairs)
    return sky, sky.ids


def propagate(sky, jd, fractions):
    first = jd + fractions[0]
    sky.near.propagate_into(
        (fractions - fractions[0]) * 1440.0, sky.position, None,
        epoch_offsets=(first - sky.epochs) * 1440.0, output="teme", time_major=True, output_stride=len(sky.ids),
    )  # fmt: skip
    error, position, _ = sky.deep.sgp4(np.full_like(fractions, jd), fractions)
    position[error != 0] = np.nan
    sky.position[:, len(sky.epochs) :] = position.transpose(1, 0, 2)
    return sky.position, None


if __name__ == "__main__":
    run(f"astroz {astroz.__version__} + python-sgp4 {sgp4.__version__}, chord", load, propagate)
