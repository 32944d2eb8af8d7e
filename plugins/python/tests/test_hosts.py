"""A hook goes on whatever happens to files, clocks and questions; one line in the log, one count."""

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
    """Written as if some time ago: files that are just being written are left alone."""
    path.write_text(text)
    then = time.time() - 10.0 - write.times
    write.times += 1
    os.utime(path, (then, then))


write.times = 0


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
    return hook.ask(lambda model: model.satellites(START), -1)


def look(hook):
    answer = count(hook)
    hook.settle()
    return answer


def test_an_error_is_answered_counted_and_logged_once(model, caplog):
    hook = Hook(model, "test")
    for length in (-1.0, -2.0, -3.0):
        assert hook.ask(lambda model: model.assess(TARGET, START, length).verdict, "clear") == "clear"
    assert hook.ask(lambda model: model.assess(TARGET, START, 30.0).verdict, "clear") == "avoid"
    assert hook.counts["asked"] == 4 and hook.counts["failed"] == 3
    (record,) = [record for record in caplog.records if record.name == "streakcast.test" and "failed" in record.message]
    assert record.levelno == logging.WARNING and "exposure" in record.message


def test_new_files_are_taken(hook, path):
    assert count(hook) == 20
    write(path, elements(25))
    look(hook)
    assert count(hook) == 25
    assert hook.counts["reloaded"] == 1 and hook.counts["failed"] == 0


@pytest.mark.parametrize("content", [None, "", "<html>no\n", elements(20)[: 69 * 12]])
def test_missing_and_half_written_files_leave_the_old_satellites(hook, path, content, caplog):
    if content is None:
        path.unlink()
    else:
        write(path, content)
    for _ in range(3):
        look(hook)
    assert count(hook) == 20
    assert hook.counts["kept_old"] >= 1 and hook.counts["failed"] == 0 and hook.counts["reloaded"] == 0
    assert len([record for record in caplog.records if record.name == "streakcast.test"]) == 1
    hook.settle()
    write(path, elements(30))
    look(hook)
    assert count(hook) == 30


def test_a_file_that_is_being_written_is_left_alone(hook, path):
    path.write_text(elements(30))
    look(hook)
    assert count(hook) == 20 and hook._state.reading is None


def test_site(model, caplog):
    hook = Hook(model, "test")
    site = model.site
    hook.see_site((site.latitude_deg + 0.008, site.longitude_deg, site.height_m))
    assert hook.counts["site"] == 0
    for _ in range(2):
        hook.see_site((site.latitude_deg + 0.01, site.longitude_deg, site.height_m))
    assert hook.counts["site"] == 2
    (record,) = caplog.records
    assert "1.1 km apart" in record.message
    coordinates = pytest.importorskip("astropy.coordinates")
    hook.see_site(model.location)
    assert hook.counts["site"] == 2
    hook.see_site(coordinates.EarthLocation.from_geodetic(lon=20.81, lat=-32.38, height=1798.0))
    assert hook.counts["site"] == 3


def test_clock(model, caplog):
    hook = Hook(model, "test")
    utc = datetime.timezone.utc
    hook.see_clock(datetime.datetime.now(utc))
    hook.see_clock("2020-01-01T00:00:00Z")
    assert hook.counts["clock"] == 0
    mjd = time.time() / 86_400.0 + 40_587.0
    hook.see_clock(mjd, "tai")
    assert hook.counts["clock"] == 1
    (record,) = caplog.records
    assert re.search(r"-3[67]\.\d s off", record.message) and "TAI" in record.message
    hook.see_clock(datetime.datetime.now(utc) + datetime.timedelta(seconds=60))
    assert hook.counts["clock"] == 2


def test_copies(hook):
    count(hook)
    text = pickle.dumps(hook)
    assert len(text) < 10_000
    other = pickle.loads(text)
    assert other.counts == hook.counts and count(other) == 20
    assert hook.counts["asked"] == 1


def test_deep_copies_are_one_hook(hook, path, caplog):
    copies = [copy.deepcopy(hook) for _ in range(3)]
    write(path, elements(25))
    look(copies[0])
    assert [count(one) for one in (hook, *copies)] == [25] * 4
    assert hook.counts["reloaded"] == 1 and hook.counts["asked"] == 5
    for one in copies:
        assert one.ask(lambda model: model.assess(TARGET, START, -1.0), None) is None
    assert hook.counts["failed"] == 3
    assert len([record for record in caplog.records if record.levelno == logging.WARNING]) == 1
    # A copy of a copy made after new files came takes them too.
    write(path, elements(30))
    late = copy.deepcopy(copies[1])
    look(late)
    assert count(hook) == 30


def test_a_pickle_of_yesterday_takes_the_files_of_today(hook, path):
    text = pickle.dumps(hook)
    write(path, elements(25))
    assert count(pickle.loads(text)) == 25


def spoil(path, content):
    """Missing, or not whole."""
    if content is None:
        path.unlink()
    else:
        write(path, content)


@pytest.mark.parametrize("content", [None, "<html>no\n"])
def test_a_pickle_that_comes_while_files_are_away_takes_them_when_they_are_there(hook, path, content):
    text = pickle.dumps(hook)
    spoil(path, content)
    other = pickle.loads(text)
    assert [look(other) for _ in range(2)] == [-1, -1]
    assert other.counts["asked"] == other.counts["failed"] == 2
    write(path, elements(25))
    assert count(other) == 25 and other.counts["failed"] == 2
    # They are watched from then on.
    other.settle()
    write(path, elements(30))
    look(other)
    assert count(other) == 30


@pytest.mark.parametrize("arguments", [("no model", "test"), (None, "test")])
def test_impossible_things_are_said_at_construction(arguments):
    with pytest.raises(TypeError, match="StreakModel"):
        Hook(*arguments)


def test_watch_must_be_positive(model):
    with pytest.raises(ValueError, match="watch_s = 0"):
        Hook(model, "test", watch_s=0)


class Clock:
    """A clock that a test turns."""

    def __init__(self):
        self.now = 1000.0

    def monotonic(self):
        return self.now

    def time(self):
        return time.time()


@pytest.fixture
def turned(monkeypatch):
    turned = Clock()
    for module in (streakcast.hosts, streakcast._hook_state):
        monkeypatch.setattr(module, "clock", turned)
    return turned


def test_a_read_that_failed_is_tried_again(path, turned, monkeypatch):
    """A file server hiccups while new elements are read; nothing about the files changes afterwards."""
    hook = Hook(streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg"), "test", watch_s=60.0)
    good = streakcast.StreakModel.reloaded
    tries = []

    def reloaded(model):
        tries.append(turned.now)
        if len(tries) <= 2:
            raise OSError("Stale file handle")
        return good(model)

    monkeypatch.setattr(streakcast.StreakModel, "reloaded", reloaded)
    write(path, elements(25))
    for _ in range(10):
        turned.now += 60.5
        look(hook)
    assert count(hook) == 25
    assert hook.counts["kept_old"] == 2 and hook.counts["reloaded"] == 1 and len(tries) == 3


def test_broken_files_are_not_read_all_night(path, turned, monkeypatch):
    hook = Hook(streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg"), "test", watch_s=60.0)
    write(path, "<html>no\n")
    tries = []

    def reloaded(model):
        tries.append(turned.now)
        raise streakcast.SetupError("no element sets")

    monkeypatch.setattr(streakcast.StreakModel, "reloaded", reloaded)
    for _ in range(600):
        turned.now += 60.0
        look(hook)
    waits = [after - before for before, after in zip(tries, tries[1:])]
    assert waits[:4] == [60.0, 120.0, 240.0, 480.0] and max(waits) == 1800.0
    assert count(hook) == 20 and hook.counts["kept_old"] == len(tries)
    # A new file is looked at when it comes.
    monkeypatch.undo()
    write(path, elements(25))
    hook._state.next_look_s = 0.0
    look(hook)
    assert count(hook) == 25


def test_a_site_or_a_clock_that_cannot_be_looked_at(model, caplog):
    hook = Hook(model, "test")
    for _ in range(3):
        hook.see_site(("north", None))
        hook.see_site(lambda: 1 / 0)
        hook.see_clock("no time")
        hook.see_clock(lambda: 1 / 0)
    assert hook.counts["site"] == hook.counts["clock"] == 6 and hook.counts["failed"] == 0
    assert len([record for record in caplog.records if "cannot be looked at" in record.message]) == 2
    site = model.site
    hook.see_site(lambda: (site.latitude_deg, site.longitude_deg, site.height_m))
    hook.see_site(lambda: None)
    hook.see_clock(lambda: None)
    hook.see_clock(lambda: datetime.datetime.now(datetime.timezone.utc))
    assert hook.counts["site"] == hook.counts["clock"] == 6


def old_model(path, day):
    """Elements of 2026-08-14, asked about 20 and more days later."""
    return streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg"), f"2026-09-{day:02d}T01:00:00Z"


def test_what_the_model_warns_of_is_counted_and_logged_once(path, caplog):
    model, start = old_model(path, 5)
    hook = Hook(model, "test")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(3):
            assert hook.ask(lambda model: model.assess(TARGET, start, 30.0).verdict, None) is not None
        assert hook.counts == {"asked": 3, "warned": 1}
    assert len([record for record in caplog.records if "14 days" in record.message]) == 1
    # Without a hook they are warnings as ever.
    model, start = old_model(path, 6)
    with pytest.warns(streakcast.StreakcastWarning, match="14 days"):
        model.assess(TARGET, start, 30.0)


def test_warnings_of_others_stay_as_they_were(model):
    """Said once a place by Python's own filters, also while a question is under way, and in threads."""
    hook = Hook(model, "test")

    def question(_):
        warnings.warn("somebody else's", DeprecationWarning)

    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("default")
        threads = [threading.Thread(target=lambda: [hook.ask(question, None) for _ in range(50)]) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert len(heard) == 1 and hook.counts["warned"] == 0


def in_a_process(hook, trouble):
    hook.ask(lambda model: model.satellites(START), None)
    for _ in range(3):
        hook.ask(lambda model: 1 / trouble, None)


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_another_process_is_counted_here(path, method, caplog):
    hook = Hook(streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg"), "test")
    count(hook)
    lent = [hook.for_process() for _ in range(2)]
    for one in lent:
        process = multiprocessing.get_context(method).Process(target=in_a_process, args=(one, 0))
        process.start()
        process.join(60.0)
        assert process.exitcode == 0
    assert hook.counts == {"asked": 9, "failed": 6}
    # Taken over once, and said once.
    assert hook.counts == {"asked": 9, "failed": 6}
    assert len([one for one in caplog.records if "in a process of its own" in one.message and "ZeroDivisionError" in one.message]) == 1
    # It pickles as ever, and then counts for itself.
    alone = pickle.loads(pickle.dumps(hook.for_process()))
    assert count(alone) == 20 and hook.counts["asked"] == 9


@pytest.mark.parametrize("content", [None, "<html>no\n"])
def test_a_process_that_begins_while_files_are_away_fails_open(hook, path, content):
    process = multiprocessing.get_context("spawn").Process(target=in_a_process, args=(hook.for_process(), 1))
    spoil(path, content)
    process.start()
    process.join(60.0)
    assert process.exitcode == 0 and hook.counts == {"asked": 4, "failed": 4}


def test_a_process_that_is_killed_is_counted_here(path):
    hook = Hook(streakcast.StreakModel(mpc="X05", elements=path, fov="3.5deg"), "test")
    lent = hook.for_process()

    def asks_and_dies():
        in_a_process(lent, 0)
        os.kill(os.getpid(), signal.SIGKILL)

    process = multiprocessing.get_context("fork").Process(target=asks_and_dies)
    process.start()
    process.join(60.0)
    assert process.exitcode == -signal.SIGKILL and hook.counts == {"asked": 4, "failed": 3}


def when_told(hook, begin):
    begin.wait(60.0)
    in_a_process(hook, 0)


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_a_process_that_still_runs_is_counted_here(hook, method):
    """`Process` forgets its arguments when it starts: nobody here holds the hook of a process that runs."""
    context = multiprocessing.get_context(method)
    begin = context.Event()
    process = context.Process(target=when_told, args=(hook.for_process(), begin))
    process.start()
    for _ in range(2):
        assert hook.counts["asked"] == 0
    begin.set()
    process.join(60.0)
    assert process.exitcode == 0 and hook.counts == {"asked": 4, "failed": 3}


def test_those_heard_of_last_are_still_listened_to(hook, monkeypatch):
    monkeypatch.setattr(streakcast.hosts, "LENT_MOST", 3)
    held = hook.for_process()
    speaker = hook.for_process()._state.mailbox
    for number in range(1, 11):
        hook.for_process()
        speaker.put("asked", number)
        assert hook.counts["asked"] == number
    assert len(hook._state.lent) == 4
    # Whoever is held here may be in a process, or on the way into one.
    count(held)
    assert hook.counts["asked"] == 11
    del held
    gc.collect()
    for _ in range(5):
        hook.for_process()
    assert hook.counts["asked"] == 11 and len(hook._state.lent) == 3


def test_the_next_process_has_the_new_files(hook, path):
    write(path, elements(25))
    assert count(hook.for_process()) == 25 and hook.counts["reloaded"] == 1


def test_counts_of_another_process_can_be_copied(hook):
    lent = hook.for_process()
    count(lent)
    copied = lent.counts.copy()
    copied["asked"] += 5
    assert type(copied) is Counter and copied == {"asked": 6}
    # The copy is nobody's.
    assert hook.counts == lent.counts == {"asked": 1}


def test_counts_that_are_added_all_at_once_arrive(hook):
    lent = hook.for_process()
    lent.counts.update({"masked": 3}, capped=1)
    assert hook.counts == {"masked": 3, "capped": 1}
    lent.counts.update(["masked", "masked"])
    lent.counts.update()
    assert hook.counts == lent.counts == {"masked": 5, "capped": 1}


@pytest.fixture
def slow_read(monkeypatch):
    """Reads of files wait for this event."""
    monkeypatch.setattr(streakcast.hosts, "PATIENCE_S", 120.0)
    good, go_on = streakcast.StreakModel.reloaded, threading.Event()

    def reloaded(model):
        assert go_on.wait(120.0)
        return good(model)

    monkeypatch.setattr(streakcast.StreakModel, "reloaded", reloaded)
    return go_on


def test_the_next_process_looks_at_once_and_waits(path, slow_read):
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


def looks(hook, answers):
    look(hook)
    answers.put(count(hook))


@pytest.mark.parametrize("method", ["fork", "spawn"])
@pytest.mark.parametrize("trouble", ["slow", "failed"])
def test_a_process_made_with_old_files_looks_itself(hook, path, monkeypatch, method, trouble):
    """New files that this process could not read, or not in time."""
    let_go = threading.Event()

    def reloaded(model):
        assert trouble != "slow" or let_go.wait(60.0)
        raise OSError("Stale file handle")

    with monkeypatch.context() as patch:
        patch.setattr(streakcast.hosts, "PATIENCE_S", 0.1)
        patch.setattr(streakcast.StreakModel, "reloaded", reloaded)
        write(path, elements(25))
        lent = hook.for_process()
        assert lent.model.satellites(START) == 20
    context = multiprocessing.get_context(method)
    answers = context.Queue()
    process = context.Process(target=looks, args=(lent, answers))
    process.start()
    assert answers.get(timeout=60.0) == 25
    process.join(60.0)
    let_go.set()
    hook.settle()


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_process_forked_while_files_are_read_reads_too(hook, path, monkeypatch):
    """The lock that the reading thread holds is held by nobody in the child."""
    monkeypatch.setattr(streakcast.hosts, "PATIENCE_S", 0.1)
    write(path, elements(25))
    context = multiprocessing.get_context("fork")
    answers = context.Queue()
    with streakcast._state._skies_lock:
        process = context.Process(target=looks, args=(hook.for_process(), answers), daemon=True)
        process.start()
    try:
        assert answers.get(timeout=60.0) == 25
    finally:
        process.kill()
