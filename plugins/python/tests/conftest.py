"""Shared fixtures: a simulated sky (no download), real data if available, the command line program."""

import json
import os
import shutil
import subprocess
import warnings
from decimal import Decimal
from pathlib import Path

import pytest

import streakcast

ROOT = Path(__file__).resolve().parents[3]
#: Evening with many crossings of the first Starlink shells over Rubin Observatory.
START = "2026-08-14T23:29:05Z"
TARGET = (198.9, 7.7)


@pytest.fixture(scope="session")
def model():
    """Returns a model of the simulated constellation Starlink gen1 at the date of the first command line example."""
    return streakcast.StreakModel(mpc="X05", shells="starlink-gen1", telescope="rubin", fov="3.5deg", limit_mag=7, epoch=START)


@pytest.fixture(scope="session")
def command_line():
    """Returns a function that runs the command line program (STREAKCAST_BIN) and parses its JSON."""
    binary = os.environ.get("STREAKCAST_BIN") or shutil.which("streakcast")
    if binary is None:
        pytest.fail("no command line to compare with: set STREAKCAST_BIN, or run plugins/test.sh")

    def run(*arguments):
        done = subprocess.run([binary, *arguments, "--format", "json", "--quiet"], capture_output=True, text=True, check=False)
        assert done.returncode in (0, 1), done.stderr
        # Decimal keeps the number of printed digits.
        return json.loads(done.stdout, parse_float=Decimal)

    return run


@pytest.fixture(scope="session")
def data():
    """Returns the folder of real data. Tests that need it are skipped with a warning if it is missing."""
    folder = Path(os.environ.get("STREAKCAST_DATA", ROOT.parent / "shared" / "data"))
    if not (folder / "INDEX.md").is_file():
        warnings.warn(f"*** SKIPPED tests on real data: no folder {folder}", stacklevel=1)
        pytest.skip(f"no data folder {folder}; set STREAKCAST_DATA")
    return folder


def pytest_configure(config):
    config.addinivalue_line("filterwarnings", "ignore::streakcast.StreakcastWarning")
