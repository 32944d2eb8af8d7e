"""Ctrl-C during long computations: they would take many minutes, and must end with KeyboardInterrupt."""

import signal
import subprocess
import sys
import time

import pytest

#: Bound after which a computation counts as not interrupted, seconds. All of them take much longer without a signal.
DEADLOCK_S = 120

SETUP = """
import signal
import numpy, streakcast
from astropy.time import Time
# Background jobs of a shell inherit an ignored SIGINT.
signal.signal(signal.SIGINT, signal.default_int_handler)
START = "2026-08-14T23:29:05Z"
model = streakcast.StreakModel(
    mpc="X05", shells=["starlink-gen1", "starlink-gen2", "guowang", "qianfan"], fov="3.5deg", epoch=START,
    policy={"limit_mag": 7, "min_probability": 0.01},
)
rows = numpy.arange(1_000_000)
target = (190 + rows % 60, -60 + rows % 70)
starts = numpy.datetime64("2026-08-14T23:29:05") + rows % 30_000 * numpy.timedelta64(1, "s")
"""

CALLS = {
    "assess": "model.assess(target, starts, 300, scale='utc')",
    "flag": "model.flag(target, starts, 300, scale='utc')",
    "windows": "model.windows((target[0][:5000], target[1][:5000]), START, '2026-08-15T09:00:00Z', 30)",
    "learn": "streakcast.learn(rows // 4, Time(starts), rows % 7 / 7, rows * 0.0, kind='oneweb')",
    "forecast": "model.forecast(start=START, end='2026-09-14T23:00:00Z', include_dark=True)",
}


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT cannot be sent to one process on Windows")
@pytest.mark.parametrize("call", CALLS)
def test_ctrl_c_ends_a_long_computation(call):
    script = f"{SETUP}\nmodel.assess((190, -30), START, 30)\nprint('ready', flush=True)\n{CALLS[call]}\nprint('completed', flush=True)\n"
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "ready\n", process.stderr.read()
        # In most cases the computation has begun after this time; a signal before it also ends the process.
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        try:
            output, errors = process.communicate(timeout=DEADLOCK_S)
        except subprocess.TimeoutExpired:
            process.kill()
            pytest.fail("the computation was not interrupted")
    assert output == "" and errors.rstrip().endswith("KeyboardInterrupt"), errors
    assert process.returncode in (-signal.SIGINT, 130), process.returncode


def test_an_exception_of_another_signal_handler_is_raised(model):
    """The exception of any signal handler stops a computation, and the model can still be used."""
    if not hasattr(signal, "setitimer"):
        pytest.skip("no timers on this system")

    class Stopped(Exception):
        pass

    def stop(*_):
        raise Stopped

    before = signal.signal(signal.SIGALRM, stop)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(Stopped):
            model.forecast(start="2026-08-14T23:29:05Z", end="2026-09-14T23:00:00Z", include_dark=True)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert model.assess((198.9, 7.7), "2026-08-14T23:29:05Z", 30).n_streaks >= 0
