"""Simulated nights of rubin_scheduler with its model observatory, without its 2 GB of data: pairs or greedy visits.

`python night.py --elements gp.csv --evening 2026-04-25` simulates a night of pairs without and with streakcast, and prints
the costs of both. Each takes about a minute.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import tempfile
import warnings
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import almanac
import healpy as hp
import numpy as np
import streakcast
from rubin_scheduler.scheduler import sim_runner
from rubin_scheduler.scheduler.detailers import RotspUpdateDetailer
from rubin_scheduler.scheduler.example.simple_examples import simple_greedy_survey, simple_pairs_survey, standard_masks
from rubin_scheduler.scheduler.model_observatory import ModelObservatory
from rubin_scheduler.scheduler.schedulers import BaseQueueManager, CoreScheduler
from rubin_scheduler.utils import _hpid2_ra_dec
from streakcast_rubin import StreakCostBasisFunction, StreakQueueManager

NSIDE = 32
#: Weight of the slew time in the example surveys, and thus of costs of streaks.
SLEWTIME_WEIGHT = 3.0


@dataclass
class Night:
    """Result of a simulated night."""

    #: Visits as a table of rubin_scheduler: RA, dec and rotSkyPos in radians, mjd in UTC, exptime in seconds.
    visits: np.ndarray
    scheduler: CoreScheduler
    observatory: ModelObservatory

    @property
    def mean_slew_s(self) -> float:
        return float(np.mean(self.visits["slewtime"]))


def footprint() -> np.ndarray:
    """Returns a footprint from -70 to +10 degrees, which is the same in all bands."""
    maps = np.zeros(hp.nside2npix(NSIDE), dtype=[(band, float) for band in "ugrizy"])
    _, dec = _hpid2_ra_dec(NSIDE, np.arange(hp.nside2npix(NSIDE)))
    for band in "ugrizy":
        maps[band][(dec > np.radians(-70.0)) & (dec < np.radians(10.0))] = 1.0
    return maps


def observatory_of(evening: str, folder: Path) -> ModelObservatory:
    """Returns the model observatory for one evening: no clouds, constant seeing and sky brightness."""
    exists = (folder / "versions.txt").exists()
    almanac.use(folder) if exists else almanac.make(evening, folder)
    noon = almanac.noon_of(evening)
    observatory = ModelObservatory(
        nside=NSIDE, mjd=noon, mjd_start=noon, no_sky=True, cloud_data="ideal", seeing_data="ideal", downtimes="ideal"
    )
    observatory.sky_model = almanac.ConstantSky()
    return observatory


def surveys_of(kind: str, noon: float, rewards=()) -> list:
    """Returns surveys: pairs in three bands, or greedy visits in one band. `rewards` are pairs (function, weight).

    Maps of visits that start now use the fields of the survey.
    """
    common = {"nside": NSIDE, "survey_start": noon, "footprints_hp": footprint()}
    if kind == "pairs":
        surveys = [
            simple_pairs_survey(bandname=one, bandname2=two, mask_basis_functions=standard_masks(NSIDE), **common)
            for one, two in (("g", "r"), ("r", "i"), ("i", "z"))
        ]
    elif kind == "greedy":
        surveys = [simple_greedy_survey(bandname="r", mask_basis_functions=standard_masks(NSIDE), **common)]
    else:
        raise ValueError(kind)
    for survey in surveys:
        for function, weight in rewards:
            if getattr(function, "ahead_min", None) == 0.0:
                function.follow(survey)
            survey.basis_functions.append(function)
            survey.basis_weights.append(weight)
    return surveys


def run(
    evening: str, kind: str, folder: Path, *, queue_manager=None, rewards=(), start_h=0.0, hours=12.0, **more
) -> Night:
    """Simulates a night from 12 degree twilight, starting `start_h` hours later, for at most `hours`."""
    observatory = observatory_of(evening, folder)
    surveys = surveys_of(kind, almanac.noon_of(evening), rewards)
    manager = queue_manager if queue_manager is not None else BaseQueueManager(detailers=[RotspUpdateDetailer()])
    scheduler = CoreScheduler(
        surveys,
        nside=NSIDE,
        queue_manager=manager,
        survey_start_mjd=almanac.noon_of(evening),
        keep_rewards=more.get("record_rewards", False),
    )
    observatory.mjd = observatory.mjd + start_h / 24.0
    dawn = float(observatory.almanac.sunsets["sun_n12_rising"][observatory.almanac_indx])
    duration = min(hours / 24.0, dawn - observatory.mjd)
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        quiet = {"verbose": False, "save_on_fail": False, "start_result_size": 2000}
        result = sim_runner(observatory, scheduler, sim_duration=duration, **quiet, **more)
    return Night(visits=result[2], scheduler=scheduler, observatory=observatory)


def costs_s(model: streakcast.StreakModel, visits: np.ndarray) -> np.ndarray:
    """Returns the cost of the streaks of each visit, seconds of open shutter."""
    target = (np.degrees(visits["RA"]), np.degrees(visits["dec"]))
    return np.asarray(model.assess(target, visits["mjd"], visits["exptime"]).streak_cost_s)


def evening(text: str) -> str:
    """Returns the date of an evening."""
    return date.fromisoformat(text).isoformat()


def hours(text: str) -> float:
    """Returns a time in hours."""
    if not 0.0 < float(text) <= 24.0:
        raise argparse.ArgumentTypeError(f"{text}; allowed: above 0, at most 24")
    return float(text)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    satellites = parser.add_mutually_exclusive_group(required=True)
    satellites.add_argument("--elements", type=Path, help="file of element sets: TLE or OMM")
    satellites.add_argument("--shells", help="simulated constellations, separated by commas")
    parser.add_argument("--evening", type=evening, default="2026-01-15", help="date of the evening, as 2026-01-15")
    parser.add_argument("--hours", type=hours, default=12.0, help="longest simulated time")
    parser.add_argument("--bright-share", type=float, default=0.08, help="share of a visit that a bright streak destroys")
    options = parser.parse_args()
    model = streakcast.StreakModel(
        site="Rubin Observatory", elements=options.elements, shells=options.shells and options.shells.split(","),
        telescope="rubin", bright_share=options.bright_share, mjd_scale="utc",
    )  # fmt: skip
    manager = StreakQueueManager(model, detailers=[RotspUpdateDetailer()])
    ahead = StreakCostBasisFunction(model, ahead_min=45)
    hooks = {"without": {}, "with": {"queue_manager": manager, "rewards": [(ahead, SLEWTIME_WEIGHT)]}}
    with tempfile.TemporaryDirectory() as folder:
        for name, more in hooks.items():
            visits = run(options.evening, "pairs", Path(folder), hours=options.hours, **more).visits
            cost_s, open_s = costs_s(model, visits).sum(), visits["exptime"].sum()
            print(f"{name} streakcast: {len(visits)} visits, open shutter {open_s:.0f} s, cost of streaks {cost_s:.1f} s")
    counts = manager.counts
    print(f"{counts['exchanged']} visits were exchanged: {counts['saved_s']:.1f} s saved, detours of {counts['detour_s']:.1f} s")


if __name__ == "__main__":
    main()
