"""Shared fixtures: almanacs, element files of simulated satellites, and simulated nights."""

import copy
from pathlib import Path

import almanac
import brute_force
import night
import numpy as np
import pytest
import streakcast
from astropy import units as u
from astropy.time import Time
from rubin_scheduler.scheduler.detailers import RotspUpdateDetailer
from streakcast_rubin import StreakQueueManager

#: In January, satellites above Rubin Observatory are lit all night.
EVENING = "2026-01-15"
SKIES = {4408: ["starlink-gen1"], 40768: ["starlink-gen1", "starlink-gen2", "oneweb"]}
#: Duration of simulations that are shorter than a night, hours.
HOURS = 1.5


def pytest_configure(config):
    config.addinivalue_line("filterwarnings", "ignore::streakcast.StreakcastWarning")


def manager_of(model, **options):
    return StreakQueueManager(model, detailers=[RotspUpdateDetailer()], **options)


def ids(visits):
    return np.ravel(visits["target_id"]).tolist()


@pytest.fixture(scope="session")
def folder(tmp_path_factory) -> Path:
    """Returns a folder with the data of rubin_scheduler for the evening, and the element files."""
    path = tmp_path_factory.mktemp("rubin")
    almanac.make(EVENING, path)
    for count, names in SKIES.items():
        epoch = Time(f"{EVENING}T12:00:00") + 0.5 * u.day
        assert brute_force.write_walker(names, epoch, path / f"{count}.csv") == count
    return path


@pytest.fixture(scope="session")
def models(folder):
    return {
        count: streakcast.StreakModel(site="Rubin Observatory", elements=folder / f"{count}.csv", telescope="rubin", mjd_scale="utc")
        for count in SKIES
    }


@pytest.fixture(scope="session")
def truths(folder):
    return {count: brute_force.Truth(brute_force.read_elements(folder / f"{count}.csv")) for count in SKIES}


@pytest.fixture
def model(models):
    return models[4408]


@pytest.fixture(scope="session")
def pairs_night(folder):
    """Returns a whole night of pairs without streakcast."""
    return night.run(EVENING, "pairs", folder)


@pytest.fixture(scope="session")
def pairs_evening(folder):
    """Returns the first hours of that night."""
    return night.run(EVENING, "pairs", folder, hours=HOURS)


@pytest.fixture(scope="session")
def planned():
    """Returns the predicted shutter openings, a map from target_id to MJD, which `dodged_evening` fills."""
    return {}


@pytest.fixture(scope="session")
def dodged_evening(folder, models, planned):
    """Returns the same hours with 40,768 satellites and the queue manager."""

    class RecordingQueueManager(StreakQueueManager):
        def _choice(self, model, conditions, valid):
            chosen = super()._choice(model, conditions, valid)
            if chosen is not None:
                visit = np.asarray(self.desired_observations_array)[[chosen]]
                planned[int(visit["target_id"][0])] = float(self.mount.openings(conditions, visit).start_mjd[0])
            return chosen

    manager = RecordingQueueManager(models[40768], detailers=[RotspUpdateDetailer()])
    return night.run(EVENING, "pairs", folder, hours=HOURS, queue_manager=manager)


@pytest.fixture(scope="session")
def _ready(folder):
    """Returns a scheduler with a queue of pairs, ten minutes after the start of the night."""
    done = night.run(EVENING, "pairs", folder, hours=0.17)
    done.scheduler.update_conditions(done.observatory.return_conditions())
    return done


@pytest.fixture
def ready(_ready):
    return copy.deepcopy(_ready)


@pytest.fixture
def take_over():
    """Returns a function that replaces the queue manager of a scheduler, and keeps queue and last visit."""

    def take(done, manager):
        previous = done.scheduler.queue_manager
        manager.set_queue(previous.desired_observations_array)
        manager.need_observing = previous.need_observing.copy()
        manager.add_observation(np.atleast_1d(done.visits[-1:]))
        done.scheduler.queue_manager = manager
        return done.scheduler

    return take


@pytest.fixture
def costly(monkeypatch):
    """Returns a function that sets the costs of the candidates, seconds of open shutter, independent of the satellites."""

    def set_costs(cost_s):
        def assess(self, target, start, exposure, **_):
            n = np.size(target[0])
            # The queue manager converts the cost of the longer exposure.
            costs = np.resize(np.asarray(cost_s, dtype=float), n) * np.asarray(exposure) / (np.asarray(exposure) - 2.0)
            streaks = (costs > 0.0).astype(int)
            return streakcast.Assessment(
                verdict=np.where(streaks, "streaked", "clear"), crosses=streaks > 0, n_streaks=streaks,
                brightest_mag=np.where(streaks, 7.0, np.nan), lost_fraction=0.0 * costs, p_any=1.0 * streaks,
                streak_length_deg=1.0 * streaks, streak_cost_s=costs,
            )  # fmt: skip

        monkeypatch.setattr(streakcast.StreakModel, "assess", assess)

    return set_costs
