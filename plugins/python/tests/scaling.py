"""Measures the processor time of a simulated survey on a Dask cluster, scaled to two million visits.

Run manually; requires STREAKCAST_DATA. `python tests/scaling.py [--streaks] [--next-starts] [NIGHTS]`

The nights (30 by default) are evenly distributed over a year, with the visits of 13 nights of a simulated survey of
Rubin. The processor time is that of the workers, of the scheduler and of this program.
"""

import argparse
import os
import resource
import tempfile
import time
import warnings
from pathlib import Path

import distributed
import numpy as np
from survey import year

import streakcast
import streakcast.dask

#: Number of visits in ten years of the Legacy Survey of Space and Time.
TEN_YEARS = 2_000_000
SKIES = (["starlink-gen1"], ["starlink-gen1", "starlink-gen2"], ["starlink-gen1", "starlink-gen2", "oneweb"])


def processor_s():
    """Returns the processor time of this process, and of those of its children that have ended, seconds."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("nights", type=int, nargs="?", default=30)
    parser.add_argument("--streaks", action="store_true")
    parser.add_argument("--next-starts", action="store_true")
    given = parser.parse_args()
    visits = year(Path(os.environ["STREAKCAST_DATA"]))
    night = np.floor(visits["start"] - 0.697).astype(int)
    chosen = np.unique(night)[:: 365 // given.nights][: given.nights]
    few = {name: column[np.isin(night, chosen)] for name, column in visits.items()}
    count = len(few["start"])
    warnings.simplefilter("ignore", streakcast.StreakcastWarning)
    for shells in SKIES:
        model = streakcast.StreakModel(mpc="X05", shells=shells, telescope="rubin", limit_mag=7, mjd_scale="utc")
        satellites = model.satellites(few["start"][0])
        begin, begin_s = time.monotonic(), processor_s()
        with tempfile.TemporaryDirectory() as folder:
            cluster = distributed.LocalCluster(n_workers=os.cpu_count(), threads_per_worker=1, dashboard_address=None)
            with cluster, distributed.Client(cluster) as client:
                options = {"streaks": given.streaks, "next_starts": given.next_starts}
                files = streakcast.dask.annotate(few, model, client, folder, **options)
                elapsed_s = time.monotonic() - begin
            streaked = np.count_nonzero(streakcast.dask.read(files)["n_streaks"])
        used_s = processor_s() - begin_s
        print(
            f"{satellites} satellites, {len(chosen)} nights, {count} visits ({streaked} streaked): {elapsed_s:.0f} s with "
            f"{os.cpu_count()} workers, {used_s:.0f} s of processor time; "
            f"two million visits: {used_s / count * TEN_YEARS / 3600:.2f} processor hours"
        )


if __name__ == "__main__":
    main()
