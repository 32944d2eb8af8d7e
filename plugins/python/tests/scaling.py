"""Measures the processor time of nights of a simulated survey for several constellations, scaled to ten years.

Run manually; requires STREAKCAST_DATA.

    RAYON_NUM_THREADS=1 python tests/scaling.py
"""

import os
import time
from pathlib import Path

import numpy as np
from survey import baseline

import streakcast

#: Number of visits in ten years of the Legacy Survey of Space and Time: 769 a night in the simulated survey.
TEN_YEARS = 3652.4 * 769


def main():
    visits = baseline(Path(os.environ["STREAKCAST_DATA"]))
    night = np.floor(visits["start"] - 0.697).astype(int)
    for shells in (["starlink-gen1"], ["starlink-gen1", "starlink-gen2"], ["starlink-gen1", "starlink-gen2", "oneweb"]):
        model = streakcast.StreakModel(mpc="X05", shells=shells, telescope="rubin", limit_mag=7, mjd_scale="utc")
        seconds, count = [], 0
        for number in np.unique(night)[2:5]:
            rows = night == number
            begin = time.process_time()
            model.assess((visits["ra_deg"][rows], visits["dec_deg"][rows]), visits["start"][rows], visits["exposure_s"][rows])
            seconds.append(time.process_time() - begin)
            count += rows.sum()
        satellites = model.satellites(visits["start"][0])
        hours = sum(seconds) / count * TEN_YEARS / 3600.0
        nights = ", ".join(f"{one:.2f}" for one in seconds)
        print(f"{satellites} satellites: nights of {count // 3} visits in {nights} s; ten years in {hours:.2f} processor hours")


if __name__ == "__main__":
    main()
