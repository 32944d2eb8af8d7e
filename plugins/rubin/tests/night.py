"""Simulated nights of rubin_scheduler with its model observatory: pairs or greedy visits."""

from __future__ import annotations

import contextlib
import io
import warnings
from dataclasses import dataclass
from pathlib import Path

import almanac
import healpy as hp
import numpy as np
from rubin_scheduler.scheduler import sim_runner
from rubin_scheduler.scheduler.detailers import RotspUpdateDetailer
from rubin_scheduler.scheduler.example.simple_examples import simple_greedy_survey, simple_pairs_survey, standard_masks
from rubin_scheduler.scheduler.model_observatory import ModelObservatory
from rubin_scheduler.scheduler.schedulers import BaseQueueManager, CoreScheduler
from rubin_scheduler.utils import _hpid2_ra_dec

NSIDE = 32


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


def surveys_of(kind: str, noon: float, masks=(), rewards=()) -> list:
    """Returns surveys: pairs in three bands, or greedy visits in one band. `rewards` are pairs (function, weight).

    Masks use the fields of the survey.
    """
    common = {"nside": NSIDE, "survey_start": noon, "footprints_hp": footprint()}
    if kind == "pairs":
        surveys = [
            simple_pairs_survey(bandname=one, bandname2=two, mask_basis_functions=[*standard_masks(NSIDE), *masks], **common)
            for one, two in (("g", "r"), ("r", "i"), ("i", "z"))
        ]
    elif kind == "greedy":
        surveys = [simple_greedy_survey(bandname="r", mask_basis_functions=[*standard_masks(NSIDE), *masks], **common)]
    else:
        raise ValueError(kind)
    for survey in surveys:
        for mask in masks:
            mask.follow(survey)
        for function, weight in rewards:
            survey.basis_functions.append(function)
            survey.basis_weights.append(weight)
    return surveys


def run(
    evening: str, kind: str, folder: Path, *, queue_manager=None, masks=(), rewards=(), start_h=0.0, hours=10.0, **more
) -> Night:
    """Simulates a night from 12 degree twilight, starting `start_h` hours later, for at most `hours`."""
    observatory = observatory_of(evening, folder)
    surveys = surveys_of(kind, almanac.noon_of(evening), masks, rewards)
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
