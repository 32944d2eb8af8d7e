"""Pickles are small, copies share, and a file that changed is noticed."""

import copy
import pickle
import shutil
import threading

import pytest

import streakcast
from conftest import ROOT, START, TARGET

#: The invented satellite; a shell gives the crossings.
ELEMENTS = ROOT / "tests" / "data" / "elements"


def element_file(folder):
    """An element file of its own in a folder."""
    source = ELEMENTS / "sample.3le"
    target = folder / "elements.tle"
    shutil.copy(source, target)
    return target


def model_of(path, **more):
    return streakcast.StreakModel(mpc="X05", elements=path, shells="starlink-gen1", fov="3.5deg", epoch=START, **more)


def test_pickles_are_small_and_answer_the_same(model):
    data = pickle.dumps(model)
    assert len(data) < 10_000
    again = pickle.loads(data)
    assert again.assess(TARGET, START, 30.0) == model.assess(TARGET, START, 30.0)
    assert pickle.dumps(again) == data
    # Asking leaves nothing behind that a pickle would carry.
    model.passes(TARGET, START, 300.0)
    assert len(pickle.dumps(model)) == len(data)


def test_deep_copies_share_the_satellites(model):
    # As a scheduler's own snapshot copies it: inside of something else, with locks around.
    held = {"queue": [model, model], "other": {"model": model}}
    copied = copy.deepcopy(held)
    assert copied["queue"][0] is not model
    assert copied["queue"][0]._open()[0] is model._open()[0]
    assert copied["other"]["model"].assess(TARGET, START, 30.0) == model.assess(TARGET, START, 30.0)
    assert copy.copy(model).site == model.site


def test_models_of_the_same_files_share_one_sky(tmp_path):
    path = element_file(tmp_path)
    first, second = model_of(path), model_of(path)
    assert first._open()[0] is second._open()[0]
    narrow = first.with_options(fov="1deg", limit_mag=5)
    assert narrow._open()[0] is first._open()[0]
    assert narrow.field_radius_deg == pytest.approx(0.5) and first.field_radius_deg == pytest.approx(1.75)
    assert pickle.loads(pickle.dumps(narrow)).field_radius_deg == pytest.approx(0.5)
    with pytest.raises(TypeError, match="make a new StreakModel"):
        first.with_options(site="Paranal")


def test_a_changed_file_is_an_error_after_unpickling(tmp_path):
    path = element_file(tmp_path)
    made = model_of(path)
    expected = made.assess(TARGET, START, 30.0)
    data, tolerant = pickle.dumps(made), pickle.dumps(model_of(path, on_changed_file="warn"))
    assert made.changed_files() == []
    path.write_text(path.read_text() + "\n")
    with pytest.raises(streakcast.ChangedFileError, match=str(path)):
        pickle.loads(data).assess(TARGET, START, 30.0)
    with pytest.warns(streakcast.StreakcastWarning, match="changed since"):
        pickle.loads(tolerant).assess(TARGET, START, 30.0)
    # The model at hand is not disturbed, and knows.
    assert repr(made.assess(TARGET, START, 30.0)) == repr(expected)
    assert made.changed_files() == [str(path)]
    assert made.reloaded().changed_files() == []


def test_a_file_that_goes_away_or_breaks_while_the_night_goes_on(tmp_path):
    path = element_file(tmp_path)
    made = model_of(path)
    whole = path.read_text()
    for broken in (None, "", whole[: len(whole) // 3], "not elements"):
        path.unlink(missing_ok=True)
        if broken is not None:
            path.write_text(broken)
        # Another night is made ready out of what was read.
        assert made.assess(TARGET, "2026-08-17T23:29:05Z", 30.0).n_streaks >= 0
        assert made.changed_files() == [str(path)]
        try:
            new = made.reloaded()
        except streakcast.SetupError as error:
            assert "elements.tle" in str(error)
        else:
            # A third of a file can be a whole record; then it is another sky, never a broken one.
            assert new.satellites(START) > 0
    path.write_text(whole)
    assert made.changed_files() == [] and made.reloaded()._open()[0] is made._open()[0]


def test_a_model_survives_threads_that_open_it_at_once(tmp_path):
    path = element_file(tmp_path)
    data = pickle.dumps(model_of(path))
    fresh = pickle.loads(data)
    answers, begin = [], threading.Barrier(4)

    def ask():
        begin.wait()
        answers.append(fresh.assess(TARGET, START, 30.0).n_streaks)

    threads = [threading.Thread(target=ask) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(answers) == 4 and len(set(answers)) == 1
