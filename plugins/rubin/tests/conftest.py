"""What the tests share: almanacs, synthetic satellites in files that brute force reads too, and nights that several tests look at."""

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

#: In January satellites are lit all night over Rubin.
EVENING = "2026-01-15"
SKIES = {4408: ["starlink-gen1"], 40768: ["starlink-gen1", "starlink-gen2", "oneweb"]}
#: How much of the evening is simulated where a whole night is too long, hours.
HOURS = 1.5


def pytest_configure(config):
    config.addinivalue_line("filterwarnings", "ignore::streakcast.StreakcastWarning")


def manager_of(model, **options):
    return StreakQueueManager(model, detailers=[RotspUpdateDetailer()], **options)


def ids(visits):
    return np.ravel(visits["target_id"]).tolist()


@pytest.fixture(scope="session")
def folder(tmp_path_factory) -> Path:
    """The host's data for the evening, and the satellites' elements."""
    made = tmp_path_factory.mktemp("rubin")
    almanac.make(EVENING, made)
    for count, names in SKIES.items():
        epoch = Time(f"{EVENING}T12:00:00") + 0.5 * u.day
        assert brute_force.write_walker(names, epoch, made / f"{count}.csv") == count
    return made


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
    """A whole night of pairs without hooks."""
    return night.run(EVENING, "pairs", folder)


@pytest.fixture(scope="session")
def pairs_evening(folder):
    """The first hours of it."""
    return night.run(EVENING, "pairs", folder, hours=HOURS)


@pytest.fixture(scope="session")
def planned():
    """Where the hook meant the shutter to open: target_id to MJD, filled by `dodged_evening`."""
    return {}


@pytest.fixture(scope="session")
def dodged_evening(folder, models, planned):
    """The same hours under 40,768 satellites with the queue manager."""

    class Noting(StreakQueueManager):
        def _account(self, choice, visits, verdicts, openings, now):
            planned[int(visits["target_id"][choice.place])] = float(openings.start_mjd[choice.place])
            super()._account(choice, visits, verdicts, openings, now)

    manager = Noting(models[40768], detailers=[RotspUpdateDetailer()])
    return night.run(EVENING, "pairs", folder, hours=HOURS, queue_manager=manager)


@pytest.fixture(scope="session")
def _ready(folder):
    """A scheduler with a queue of pairs, ten minutes into the evening."""
    done = night.run(EVENING, "pairs", folder, hours=0.17)
    done.scheduler.update_conditions(done.observatory.return_conditions())
    return done


@pytest.fixture
def ready(_ready):
    return copy.deepcopy(_ready)


@pytest.fixture
def take_over():
    """Puts a queue manager into a scheduler, with the queue and the last visit of the one before."""

    def take(done, manager):
        before = done.scheduler.queue_manager
        manager.set_queue(before.desired_observations_array)
        manager.need_observing = before.need_observing.copy()
        manager.add_observation(np.atleast_1d(done.visits[-1:]))
        done.scheduler.queue_manager = manager
        return done.scheduler

    return take


@pytest.fixture
def blocked(monkeypatch):
    """Names the visits (by their places among the candidates) that are crossed, whatever the sky is like."""

    def block(model_class, places, damage=None):
        def passes(self, target, *_, **__):
            n = np.size(target[0])
            crossed = np.arange(n) if places == "all" else np.array([one for one in places if one < n], dtype=int)
            lost = np.ones(n) if damage is None else np.resize(damage, n)
            ones = np.ones(crossed.size)
            return {
                "exposure_id": crossed, "magnitude_peak": 7.0 * ones, "lost_pixel_fraction": lost[crossed],
                "streak_length_deg": ones, "probability": ones,
            }  # fmt: skip

        monkeypatch.setattr(model_class, "passes", passes)

    return block
