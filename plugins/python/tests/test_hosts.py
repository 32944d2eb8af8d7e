"""A hook goes on whatever happens to files, clocks and questions; one line in the log, one count."""

import copy
import datetime
import logging
import os
import pickle
import time

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
    assert hook.counts == {"asked": 4, "failed": 3}
    (record,) = [record for record in caplog.records if record.name == "streakcast.test"]
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
    assert "-37.0 s off" in record.message and "TAI" in record.message
    hook.see_clock(datetime.datetime.now(utc) + datetime.timedelta(seconds=3))
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


@pytest.mark.parametrize("arguments", [("no model", "test"), (None, "test")])
def test_impossible_things_are_said_at_construction(arguments):
    with pytest.raises(TypeError, match="StreakModel"):
        Hook(*arguments)


def test_watch_must_be_positive(model):
    with pytest.raises(ValueError, match="watch_s = 0"):
        Hook(model, "test", watch_s=0)
