"""Long computations release the interpreter lock."""

import multiprocessing
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from conftest import START, TARGET
from test_hosts import elements


#: Number of steps of the other thread from which it follows that the lock was released.
ENOUGH = 10
#: Time limit of the repetitions in `steps_while`, seconds.
LIMIT_S = 120.0


def steps_while(work):
    """Counts the steps of another thread while `work` is repeated.

    The work is repeated until there are enough steps: on a loaded machine, one call may end before the other thread
    runs.

    The other thread releases the lock at each step; this thread releases it only inside `work`.
    """
    done = threading.Event()
    begun = threading.Event()
    steps = [0]

    def count():
        while not done.is_set():
            steps[0] += 1
            begun.set()
            time.sleep(0)

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e4)
    counter = threading.Thread(target=count)
    counter.start()
    try:
        begun.wait()
        before, end = steps[0], time.monotonic() + LIMIT_S
        while steps[0] - before <= ENOUGH and time.monotonic() < end:
            work()
        return steps[0] - before
    finally:
        done.set()
        counter.join()
        sys.setswitchinterval(interval)


def test_holding_the_lock_is_detected(monkeypatch):
    monkeypatch.setattr(sys.modules[__name__], "LIMIT_S", 0.5)
    assert steps_while(lambda: sum(range(3_000_000))) == 0


@pytest.mark.parametrize("method", ["judge", "flags", "passes", "clear_windows"])
def test_two_threads_overlap(model, method):
    _, engine = model._open()
    many = np.full(3000, TARGET[0]) + np.linspace(0, 10, 3000), np.full(3000, TARGET[1])
    exposures, bands, _ = model._exposure_columns(many, START, 30.0, 0.0, None, None)
    few, _, _ = model._exposure_columns((many[0][:20], many[1][:20]), START, 7200.0, 0.0, None, None)
    work = {
        "judge": lambda: engine.judge(exposures, bands),
        "flags": lambda: engine.flags({name: column[:500] for name, column in exposures.items()}, bands),
        "passes": lambda: engine.passes(exposures, False, 0, bands),
        "clear_windows": lambda: engine.clear_windows(few, bands, 30.0, 0.0, "any"),
    }[method]
    work()
    assert steps_while(work) > ENOUGH


def test_results_do_not_depend_on_concurrent_calls(model):
    starts = 61266.9785301 + np.arange(40) * 3e-4
    expected = [model.assess(TARGET, start, 30.0, scale="utc").n_streaks for start in starts]
    results = {}

    def assess(part):
        for index in range(part, 40, 4):
            results[index] = model.assess(TARGET, starts[index], 30.0, scale="utc").n_streaks

    threads = [threading.Thread(target=assess, args=(part,)) for part in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [results[index] for index in range(40)] == expected
    assert sum(expected) > 0


def _assess_in_child(model, pipe):
    pipe.send(model.assess(TARGET, START, 30.0).n_streaks)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_child_has_its_own_thread_pool(model):
    expected = model.assess(TARGET, START, 30.0).n_streaks
    here, there = multiprocessing.Pipe()
    child = multiprocessing.get_context("fork").Process(target=_assess_in_child, args=(model, there), daemon=True)
    child.start()
    # A child process that used the pool of its parent would be blocked forever.
    has_result = here.poll(300)
    child.terminate() if not has_result else child.join()
    assert has_result and here.recv() == expected


MANY_NIGHTS = """
import sys, threading, streakcast

model = streakcast.StreakModel(mpc="X05", elements=sys.argv[1], fov="3.5deg")
for first in range(2000):
    begin = threading.Barrier(4)

    def load(number):
        begin.wait()
        model.satellites(61260.0 + (first + 7 * number) % 40, scale="utc")

    threads = [threading.Thread(target=load, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
"""


def test_threads_with_many_nights_do_not_deadlock(tmp_path):
    path = tmp_path / "elements.tle"
    path.write_text(elements(20))
    # In a separate process, because a deadlock would block all other tests.
    subprocess.run([sys.executable, "-c", MANY_NIGHTS, str(path)], check=True, timeout=1800.0)
