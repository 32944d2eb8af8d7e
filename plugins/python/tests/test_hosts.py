"""A hook returns a fallback after errors of files, clocks and calls. Each kind of error is counted and logged once."""

import copy
import datetime
import gc
import logging
import multiprocessing
import os
import pickle
import re
import signal
import threading
import time
import warnings
from collections import Counter

import pytest

import streakcast
from streakcast.hosts import Hook

from conftest import START, TARGET

TLE = """\
TEST {n:05d}
1 {n:05d}U 24001A   26226.50000000  .00000000  00000-0  00000-0 0  9990
2 {n:05d}  53.0000 {node:8.4f} 0001000   0.0000 {anomaly:8.4f} 15.06000000    00
"""


def checksummed(line):
    return line[:68] + str(sum(int(one) if one.isdigit() else one == "-" for one in line[:68]) % 10)


def elements(count):
    lines = "".join(TLE.format(n=90000 + i, node=i * 3.0, anomaly=i * 7.0 % 360.0) for i in range(count)).splitlines()
    return "\n".join(checksummed(line) if line[:2] in ("1 ", "2 ") else line for line in lines) + "\n"


def write(path, text):
    """Writes a file with a modification time in the past, because files that were just modified are not read."""
    path.write_text(text)
    modified = time.time() - 10.0 - write.calls
    write.calls += 1
    os.utime(path, (modified, modified))


write.calls = 0


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "elements.tle"
    write(path, elements(20))
    return path


@pytest.fixture
def hook(path):
    model = streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg", limit_mag=7)
    return Hook(model, "test", watch_s=1e-9)


def count(hook):
    return hook.evaluate(lambda model: model.satellites(START), -1)


def count_and_settle(hook):
    result = count(hook)
    hook.settle()
    return result


def test_an_error_gives_the_fallback_and_is_counted_and_logged_once(model, caplog):
    hook = Hook(model, "test")
    for length in (-1.0, -2.0, -3.0):
        assert hook.evaluate(lambda model: model.assess(TARGET, START, length).verdict, "clear") == "clear"
    assert hook.evaluate(lambda model: model.assess(TARGET, START, 30.0).verdict, "clear") == "avoid"
    assert hook.counts["asked"] == 4 and hook.counts["failed"] == 3
    (record,) = [record for record in caplog.records if record.name == "streakcast.test" and "failed" in record.message]
    assert record.levelno == logging.WARNING and "exposure" in record.message


def test_new_files_are_read(hook, path):
    assert count(hook) == 20
    write(path, elements(25))
    count_and_settle(hook)
    assert count(hook) == 25
    assert hook.counts["reloaded"] == 1 and hook.counts["failed"] == 0


@pytest.mark.parametrize("content", [None, "", "<html>no\n", elements(20)[: 69 * 12]])
def test_missing_and_partial_files_keep_the_old_satellites(hook, path, content, caplog):
    if content is None:
        path.unlink()
    else:
        write(path, content)
    for _ in range(3):
        count_and_settle(hook)
    assert count(hook) == 20
    assert hook.counts["kept_old"] >= 1 and hook.counts["failed"] == 0 and hook.counts["reloaded"] == 0
    assert len([record for record in caplog.records if record.name == "streakcast.test"]) == 1
    hook.settle()
    write(path, elements(30))
    count_and_settle(hook)
    assert count(hook) == 30


def test_a_file_being_written_is_not_read(hook, path):
    path.write_text(elements(30))
    count_and_settle(hook)
    assert count(hook) == 20 and hook._state.reading is None


def test_site(model, caplog):
    hook = Hook(model, "test")
    site = model.site
    hook.check_site((site.latitude_deg + 0.008, site.longitude_deg, site.height_m))
    assert hook.counts["site"] == 0
    for _ in range(2):
        hook.check_site((site.latitude_deg + 0.01, site.longitude_deg, site.height_m))
    assert hook.counts["site"] == 2
    (record,) = caplog.records
    assert "1.1 km apart" in record.message
    coordinates = pytest.importorskip("astropy.coordinates")
    hook.check_site(model.location)
    assert hook.counts["site"] == 2
    hook.check_site(coordinates.EarthLocation.from_geodetic(lon=20.81, lat=-32.38, height=1798.0))
    assert hook.counts["site"] == 3


def test_clock(model, caplog):
    hook = Hook(model, "test")
    utc = datetime.timezone.utc
    hook.check_clock(datetime.datetime.now(utc))
    hook.check_clock("2020-01-01T00:00:00Z")
    assert hook.counts["clock"] == 0
    mjd = time.time() / 86_400.0 + 40_587.0
    hook.check_clock(mjd, "tai")
    assert hook.counts["clock"] == 1
    (record,) = caplog.records
    assert re.search(r"-3[67]\.\d s off", record.message) and "TAI" in record.message
    hook.check_clock(datetime.datetime.now(utc) + datetime.timedelta(seconds=60))
    assert hook.counts["clock"] == 2


def test_copies(hook):
    count(hook)
    text = pickle.dumps(hook)
    assert len(text) < 10_000
    other = pickle.loads(text)
    assert other.counts == hook.counts and count(other) == 20
    assert hook.counts["asked"] == 1


def test_deep_copies_share_one_state(hook, path, caplog):
    copies = [copy.deepcopy(hook) for _ in range(3)]
    write(path, elements(25))
    count_and_settle(copies[0])
    assert [count(one) for one in (hook, *copies)] == [25] * 4
    assert hook.counts["reloaded"] == 1 and hook.counts["asked"] == 5
    for one in copies:
        assert one.evaluate(lambda model: model.assess(TARGET, START, -1.0), None) is None
    assert hook.counts["failed"] == 3
    assert len([record for record in caplog.records if record.levelno == logging.WARNING]) == 1
    # A copy of a copy that is made after a file change reads the new file.
    write(path, elements(30))
    late = copy.deepcopy(copies[1])
    count_and_settle(late)
    assert count(hook) == 30


def test_an_old_pickle_uses_the_present_files(hook, path):
    text = pickle.dumps(hook)
    write(path, elements(25))
    assert count(pickle.loads(text)) == 25


def replace_content(path, content):
    """Deletes the file, or replaces its content."""
    if content is None:
        path.unlink()
    else:
        write(path, content)


@pytest.mark.parametrize("content", [None, "<html>no\n"])
def test_a_pickle_loaded_while_files_are_missing_reads_them_later(hook, path, content):
    text = pickle.dumps(hook)
    replace_content(path, content)
    other = pickle.loads(text)
    assert [count_and_settle(other) for _ in range(2)] == [-1, -1]
    assert other.counts["asked"] == other.counts["failed"] == 2
    write(path, elements(25))
    assert count(other) == 25 and other.counts["failed"] == 2
    # Changes are detected after that.
    other.settle()
    write(path, elements(30))
    count_and_settle(other)
    assert count(other) == 30


@pytest.mark.parametrize("arguments", [("no model", "test"), (None, "test")])
def test_invalid_arguments_are_reported_at_construction(arguments):
    with pytest.raises(TypeError, match="StreakModel"):
        Hook(*arguments)


def test_watch_must_be_positive(model):
    with pytest.raises(ValueError, match="watch_s is 0"):
        Hook(model, "test", watch_s=0)


class Clock:
    """Clock that is set by the test."""

    def __init__(self):
        self.now = 1000.0

    def monotonic(self):
        return self.now

    def time(self):
        return time.time()


@pytest.fixture
def fake_clock(monkeypatch):
    fake_clock = Clock()
    for module in (streakcast.hosts, streakcast._hook_state):
        monkeypatch.setattr(module, "clock", fake_clock)
    return fake_clock


def test_a_failed_read_is_retried(path, fake_clock, monkeypatch):
    """A file server fails for some time while new element sets are read. The files do not change later."""
    hook = Hook(streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg"), "test", watch_s=60.0)
    original = streakcast.StreakModel.reloaded
    tries = []

    def reloaded(model):
        tries.append(fake_clock.now)
        if len(tries) <= 2:
            raise OSError("Stale file handle")
        return original(model)

    monkeypatch.setattr(streakcast.StreakModel, "reloaded", reloaded)
    write(path, elements(25))
    for _ in range(10):
        fake_clock.now += 60.5
        count_and_settle(hook)
    assert count(hook) == 25
    assert hook.counts["kept_old"] == 2 and hook.counts["reloaded"] == 1 and len(tries) == 3


def test_broken_files_are_read_with_growing_delays(path, fake_clock, monkeypatch):
    hook = Hook(streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg"), "test", watch_s=60.0)
    write(path, "<html>no\n")
    tries = []

    def reloaded(model):
        tries.append(fake_clock.now)
        raise streakcast.SetupError("no element sets")

    monkeypatch.setattr(streakcast.StreakModel, "reloaded", reloaded)
    for _ in range(600):
        fake_clock.now += 60.0
        count_and_settle(hook)
    waits = [after - before for before, after in zip(tries, tries[1:])]
    assert waits[:4] == [60.0, 120.0, 240.0, 480.0] and max(waits) == 1800.0
    assert count(hook) == 20 and hook.counts["kept_old"] == len(tries)
    # A new file is read immediately.
    monkeypatch.undo()
    write(path, elements(25))
    hook._state.next_check_s = 0.0
    count_and_settle(hook)
    assert count(hook) == 25


def test_an_unreadable_site_or_clock_is_counted(model, caplog):
    hook = Hook(model, "test")
    for _ in range(3):
        hook.check_site(("north", None))
        hook.check_site(lambda: 1 / 0)
        hook.check_clock("no time")
        hook.check_clock(lambda: 1 / 0)
    assert hook.counts["site"] == hook.counts["clock"] == 6 and hook.counts["failed"] == 0
    assert len([record for record in caplog.records if "cannot be read" in record.message]) == 2
    site = model.site
    hook.check_site(lambda: (site.latitude_deg, site.longitude_deg, site.height_m))
    hook.check_site(lambda: None)
    hook.check_clock(lambda: None)
    hook.check_clock(lambda: datetime.datetime.now(datetime.timezone.utc))
    assert hook.counts["site"] == hook.counts["clock"] == 6


def old_model(path, day):
    """Returns a model with element sets of 2026-08-14, and a start at least 20 days later."""
    return streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg"), f"2026-09-{day:02d}T01:00:00Z"


def test_warnings_of_the_model_are_counted_and_logged_once(path, caplog):
    model, start = old_model(path, 5)
    hook = Hook(model, "test")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(3):
            assert hook.evaluate(lambda model: model.assess(TARGET, start, 30.0).verdict, None) is not None
        assert hook.counts == {"asked": 3, "warned": 1}
    assert len([record for record in caplog.records if "14 days" in record.message]) == 1
    # Without a hook they are Python warnings.
    model, start = old_model(path, 6)
    with pytest.warns(streakcast.StreakcastWarning, match="14 days"):
        model.assess(TARGET, start, 30.0)


def test_other_warnings_are_not_affected(model):
    """Python's filters issue other warnings once per location, also during calls of the hook and in threads."""
    hook = Hook(model, "test")

    def warn(_):
        warnings.warn("of another library", DeprecationWarning)

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        threads = [threading.Thread(target=lambda: [hook.evaluate(warn, None) for _ in range(50)]) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert len(caught) == 1 and hook.counts["warned"] == 0


def in_process(hook, divisor):
    hook.evaluate(lambda model: model.satellites(START), None)
    for _ in range(3):
        hook.evaluate(lambda model: 1 / divisor, None)


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_another_process_is_counted_here(path, method, caplog):
    hook = Hook(streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg"), "test")
    count(hook)
    hooks = [hook.for_process() for _ in range(2)]
    for one in hooks:
        process = multiprocessing.get_context(method).Process(target=in_process, args=(one, 0))
        process.start()
        process.join(60.0)
        assert process.exitcode == 0
    assert hook.counts == {"asked": 9, "failed": 6}
    # Counts are added once, and the message is logged once.
    assert hook.counts == {"asked": 9, "failed": 6}
    assert len([one for one in caplog.records if "in another process" in one.message and "ZeroDivisionError" in one.message]) == 1
    # A pickled hook has its own counts.
    alone = pickle.loads(pickle.dumps(hook.for_process()))
    assert count(alone) == 20 and hook.counts["asked"] == 9


@pytest.mark.parametrize("content", [None, "<html>no\n"])
def test_a_process_started_while_files_are_missing_uses_the_fallback(hook, path, content):
    process = multiprocessing.get_context("spawn").Process(target=in_process, args=(hook.for_process(), 1))
    replace_content(path, content)
    process.start()
    process.join(60.0)
    assert process.exitcode == 0 and hook.counts == {"asked": 4, "failed": 4}


def test_a_process_that_is_killed_is_counted_here(path):
    hook = Hook(streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg"), "test")
    remote = hook.for_process()

    def run_and_die():
        in_process(remote, 0)
        os.kill(os.getpid(), signal.SIGKILL)

    process = multiprocessing.get_context("fork").Process(target=run_and_die)
    process.start()
    process.join(60.0)
    assert process.exitcode == -signal.SIGKILL and hook.counts == {"asked": 4, "failed": 3}


def wait_and_run(hook, begin):
    begin.wait(60.0)
    in_process(hook, 0)


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_a_process_that_still_runs_is_counted_here(hook, method):
    """`Process` deletes its arguments when it starts, so that the hook is not referenced in this process."""
    context = multiprocessing.get_context(method)
    begin = context.Event()
    process = context.Process(target=wait_and_run, args=(hook.for_process(), begin))
    process.start()
    for _ in range(2):
        assert hook.counts["asked"] == 0
    begin.set()
    process.join(60.0)
    assert process.exitcode == 0 and hook.counts == {"asked": 4, "failed": 3}


def test_the_most_recently_active_hooks_are_still_read(hook, monkeypatch):
    monkeypatch.setattr(streakcast.hosts, "MAX_REMOTE_HOOKS", 3)
    held = hook.for_process()
    mailbox = hook.for_process()._state.mailbox
    for number in range(1, 11):
        hook.for_process()
        mailbox.put("asked", number)
        assert hook.counts["asked"] == number
    assert len(hook._state.remote_hooks) == 4
    # A hook that is referenced here may be used by a process, or may be passed to one.
    count(held)
    assert hook.counts["asked"] == 11
    del held
    gc.collect()
    for _ in range(5):
        hook.for_process()
    assert hook.counts["asked"] == 11 and len(hook._state.remote_hooks) == 3


def test_the_next_process_uses_the_new_files(hook, path):
    write(path, elements(25))
    assert count(hook.for_process()) == 25 and hook.counts["reloaded"] == 1


def test_counts_of_another_process_can_be_copied(hook):
    remote = hook.for_process()
    count(remote)
    copied = remote.counts.copy()
    copied["asked"] += 5
    assert type(copied) is Counter and copied == {"asked": 6}
    # The copy is not connected to the mailbox.
    assert hook.counts == remote.counts == {"asked": 1}


def test_counts_added_with_update_are_collected(hook):
    remote = hook.for_process()
    remote.counts.update({"masked": 3}, capped=1)
    assert hook.counts == {"masked": 3, "capped": 1}
    remote.counts.update(["masked", "masked"])
    remote.counts.update()
    assert hook.counts == remote.counts == {"masked": 5, "capped": 1}


@pytest.fixture
def slow_read(monkeypatch):
    """Returns an event for which reading of files waits."""
    monkeypatch.setattr(streakcast.hosts, "MAX_WAIT_S", 120.0)
    original, may_continue = streakcast.StreakModel.reloaded, threading.Event()

    def reloaded(model):
        assert may_continue.wait(120.0)
        return original(model)

    monkeypatch.setattr(streakcast.StreakModel, "reloaded", reloaded)
    return may_continue


def test_the_next_process_checks_files_and_waits(path, slow_read):
    threading.Timer(0.5, slow_read.set).start()
    hook = Hook(streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg"), "test", watch_s=60.0)
    write(path, elements(25))
    assert count(hook.for_process()) == 25


def test_the_next_process_waits_for_a_read_under_way(hook, path, slow_read):
    write(path, elements(25))
    count(hook)
    assert hook._state.reading.is_alive()
    threading.Timer(0.5, slow_read.set).start()
    assert count(hook.for_process()) == 25


def count_in_process(hook, results):
    count_and_settle(hook)
    results.put(count(hook))


@pytest.mark.parametrize("method", ["fork", "spawn"])
@pytest.mark.parametrize("failure", ["slow", "failed"])
def test_a_process_started_with_old_files_reads_the_new_ones(hook, path, monkeypatch, method, failure):
    """The new files could not be read in this process, or not in time."""
    may_fail = threading.Event()

    def reloaded(model):
        assert failure != "slow" or may_fail.wait(60.0)
        raise OSError("Stale file handle")

    with monkeypatch.context() as patch:
        patch.setattr(streakcast.hosts, "MAX_WAIT_S", 0.1)
        patch.setattr(streakcast.StreakModel, "reloaded", reloaded)
        write(path, elements(25))
        remote = hook.for_process()
        assert remote.model.satellites(START) == 20
    context = multiprocessing.get_context(method)
    results = context.Queue()
    process = context.Process(target=count_in_process, args=(remote, results))
    process.start()
    assert results.get(timeout=60.0) == 25
    process.join(60.0)
    may_fail.set()
    hook.settle()


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_process_forked_during_a_read_can_read_files(hook, path, monkeypatch):
    """In the child process, the lock of the reading thread is never released."""
    monkeypatch.setattr(streakcast.hosts, "MAX_WAIT_S", 0.1)
    write(path, elements(25))
    context = multiprocessing.get_context("fork")
    results = context.Queue()
    with streakcast._state._sky_caches_lock:
        process = context.Process(target=count_in_process, args=(hook.for_process(), results), daemon=True)
        process.start()
    try:
        assert results.get(timeout=60.0) == 25
    finally:
        process.kill()
