"""What the tests share: a synthetic sky that needs no download, real data where there are any, the command line."""

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
#: A busy evening of Starlink's first shells over Rubin.
START = "2026-08-14T23:29:05Z"
TARGET = (198.9, 7.7)


@pytest.fixture(scope="session")
def model():
    """Starlink gen1, synthetic, of the day of the command line's own first example."""
    return streakcast.StreakModel(mpc="X05", shells="starlink-gen1", telescope="rubin", fov="3.5deg", limit_mag=7, epoch=START)


@pytest.fixture(scope="session")
def command_line():
    """Runs the command line and reads its JSON; the binary is named by STREAKCAST_BIN (plugins/test.sh builds it)."""
    binary = os.environ.get("STREAKCAST_BIN") or shutil.which("streakcast")
    if binary is None:
        pytest.fail("no command line to compare with: set STREAKCAST_BIN, or run plugins/test.sh")

    def run(*arguments):
        done = subprocess.run([binary, *arguments, "--format", "json", "--quiet"], capture_output=True, text=True, check=False)
        assert done.returncode in (0, 1), done.stderr
        # Decimals keep the number of digits that were written.
        return json.loads(done.stdout, parse_float=Decimal)

    return run


@pytest.fixture(scope="session")
def data():
    """The folder of real catalogues; tests that need it are left out, and say so, where there is none."""
    folder = Path(os.environ.get("STREAKCAST_DATA", ROOT.parent / "shared" / "data"))
    if not (folder / "INDEX.md").is_file():
        warnings.warn(f"*** SKIPPED tests on real data: no folder {folder}", stacklevel=1)
        pytest.skip(f"no data folder {folder}; name one by STREAKCAST_DATA")
    return folder


def pytest_configure(config):
    config.addinivalue_line("filterwarnings", "ignore::streakcast.StreakcastWarning")
