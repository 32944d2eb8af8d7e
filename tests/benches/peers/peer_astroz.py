"""astroz: SIMD SGP4 and threaded SDP4 into one array made once, and the chord test.

As `astroz.propagate` calls its kernels, without its allocations and without velocities: the fastest way it offers.
"""

import astroz
import numpy as np
from astroz import _astroz

from chord import SAMPLES, run


class Sky:
    def __init__(self, pairs):
        satellites = [_astroz.Satrec.twoline2rv(first, second, _astroz.WGS72) for first, second in pairs]
        near = [s for s in satellites if not s.is_deep_space and s.error == 0]
        self.deep = [s for s in satellites if s.is_deep_space]
        self.near = _astroz.Sgp4Constellation(near, gravity_model=_astroz.WGS72)
        self.epochs = np.array(self.near.epochs)
        self.ids = np.array([s.satnum for s in near + self.deep])
        self.position = np.empty((SAMPLES, len(self.ids), 3))
        self.unused_velocity = np.empty_like(self.position)


def load(pairs):
    sky = Sky(pairs)
    return sky, sky.ids


def propagate(sky, jd, fractions):
    first, count = jd + fractions[0], len(sky.ids)
    sky.near.propagate_into(
        (fractions - fractions[0]) * 1440.0, sky.position, None,
        epoch_offsets=(first - sky.epochs) * 1440.0, output="teme", time_major=True, output_stride=count,
    )  # fmt: skip
    _astroz.sdp4_batch_propagate_into(
        sky.deep, np.full_like(fractions, jd), fractions, sky.position, sky.unused_velocity,
        output_stride=count, sat_offset=len(sky.epochs),
    )  # fmt: skip
    return sky.position, None


if __name__ == "__main__":
    run(f"astroz {astroz.__version__}, chord test", load, propagate)
