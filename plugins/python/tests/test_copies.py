"""Pickles are small, copies use the same satellites, and changed files are detected."""

import copy
import pickle
import shutil
import threading

import pytest

import streakcast
from conftest import ROOT, START, TARGET

#: Folder with the element set of an invented satellite. The crossings are those of a simulated constellation.
ELEMENTS = ROOT / "tests" / "data" / "elements"


def element_file(folder):
    """Copies an element file to a folder."""
    source = ELEMENTS / "sample.3le"
    target = folder / "elements.tle"
    shutil.copy(source, target)
    return target


def model_of(path, **more):
    return streakcast.StreakModel(mpc="X05", elements=path, shells="starlink-gen1", fov="3.5deg", epoch=START, **more)


def test_pickles_are_small_and_give_the_same_results(model):
    data = pickle.dumps(model)
    assert len(data) < 10_000
    again = pickle.loads(data)
    assert again.assess(TARGET, START, 30.0) == model.assess(TARGET, START, 30.0)
    assert pickle.dumps(again) == data
    # Calls of methods do not enlarge the pickle.
    model.passes(TARGET, START, 300.0)
    assert len(pickle.dumps(model)) == len(data)


def test_deep_copies_share_the_satellites(model):
    # Inside other objects, as in a snapshot of a scheduler.
    snapshot = {"queue": [model, model], "other": {"model": model}}
    copied = copy.deepcopy(snapshot)
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
    with pytest.raises(TypeError, match="create a new StreakModel"):
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
    # The existing model is not affected, and reports the changed file.
    assert repr(made.assess(TARGET, START, 30.0)) == repr(expected)
    assert made.changed_files() == [str(path)]
    assert made.reloaded().changed_files() == []


def test_missing_and_broken_files_do_not_affect_a_loaded_model(tmp_path):
    path = element_file(tmp_path)
    made = model_of(path)
    whole = path.read_text()
    for broken in (None, "", whole[: len(whole) // 3], "not elements"):
        path.unlink(missing_ok=True)
        if broken is not None:
            path.write_text(broken)
        # Another night is prepared from the satellites in memory.
        assert made.assess(TARGET, "2026-08-17T23:29:05Z", 30.0).n_streaks >= 0
        assert made.changed_files() == [str(path)]
        try:
            new = made.reloaded()
        except streakcast.SetupError as error:
            assert "elements.tle" in str(error)
        else:
            # A third of the file may contain a complete record, and is then a valid file.
            assert new.satellites(START) > 0
    path.write_text(whole)
    assert made.changed_files() == [] and made.reloaded()._open()[0] is made._open()[0]


def test_several_threads_can_load_a_model_at_once(tmp_path):
    path = element_file(tmp_path)
    data = pickle.dumps(model_of(path))
    fresh = pickle.loads(data)
    results, begin = [], threading.Barrier(4)

    def assess():
        begin.wait()
        results.append(fresh.assess(TARGET, START, 30.0).n_streaks)

    threads = [threading.Thread(target=assess) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 4 and len(set(results)) == 1
