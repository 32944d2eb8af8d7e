"""Writes a schedule for benchmarks: 1,000 exposures of 30 s every 34 s from 2026-04-25T23:40Z, Cerro Pachon.

Pointings are uniform over the sky above an altitude of 30 deg (at mid exposure), from a fixed seed. The schedule is not
part of the repository, because it is generated in a second.

    STREAKCAST_DATA=... python tests/reference/make_bench_exposures.py schedule.csv [--count 1000]
"""

import argparse

import numpy as np

from sky_frames import DAY_S, LATITUDE_DEG, LONGITUDE_DEG, Frames, jd_to_utc, utc_to_jd, vector_to_radec

START, DURATION_S, CADENCE_S, SEED = "2026-04-25T23:40:00.000Z", 30.0, 34.0, 20260425


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output")
    parser.add_argument("--count", type=int, default=1000, help="exposures; the cadence shrinks where they would not fit the night")
    arguments = parser.parse_args()
    frames, random = Frames(), np.random.default_rng(SEED)
    cadence = min(CADENCE_S, 1000 * CADENCE_S / arguments.count)
    jd, fraction = utc_to_jd(START)
    starts = fraction + np.round(np.arange(arguments.count) * cadence, 3) / DAY_S
    longitude, latitude = np.radians([LONGITUDE_DEG, LATITUDE_DEG])
    east = np.array([-np.sin(longitude), np.cos(longitude), 0.0])
    north = np.cross(frames.up_itrs, east)
    _, itrs_to_gcrs, _ = frames.at(jd, starts + DURATION_S / 2 / DAY_S)
    altitude = np.arcsin(random.uniform(0.5, 1.0, arguments.count))
    azimuth = random.uniform(0, 2 * np.pi, arguments.count)
    with open(arguments.output, "w") as file:
        file.write("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n")
        for i in range(arguments.count):
            local = np.cos(altitude[i]) * (np.cos(azimuth[i]) * north + np.sin(azimuth[i]) * east) + np.sin(altitude[i]) * frames.up_itrs
            ra_deg, dec_deg = vector_to_radec(itrs_to_gcrs[i] @ local)
            file.write(f"e{i:05d},{jd_to_utc(jd, starts[i])},{DURATION_S:g},{ra_deg % 360:.6f},{dec_deg:.6f}\n")


if __name__ == "__main__":
    main()
