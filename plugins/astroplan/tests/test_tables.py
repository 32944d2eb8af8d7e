"""Tables of clear windows and of streaks."""

import re
from pathlib import Path

import numpy as np
import pytest
from astroplan import ObservingBlock
from astropy import units as u
from astropy.coordinates import SkyCoord

from conftest import FOV_DEG, START
from streakcast_astroplan import clear_windows, streak_table

RANGE = (START, START + 40 * u.min)


def test_valid_exposures_that_begin_in_windows_are_clear_by_brute_force(model, sky, observer, targets):
    few = targets[:3]
    table = clear_windows(model, few, RANGE, 60 * u.s, observer=observer)
    assert table.colnames == ["target", "first_start", "last_start", "length"] and set(table["target"]) == {one.name for one in few}
    between = 0
    for one in few:
        mine = table[table["target"] == one.name]
        for row in mine:
            for start in (row["first_start"], row["last_start"]):
                assert not sky.streaks(one.coord, start, 60.0, FOV_DEG / 2)
            assert row["length"].to_value("s") == pytest.approx((row["last_start"] - row["first_start"]).to_value("s"), abs=1e-3)
        for earlier, later in zip(mine[:-1], mine[1:]):
            # A satellite crosses between two windows.
            middle = earlier["last_start"] + 0.5 * (later["first_start"] - earlier["last_start"])
            between += bool(sky.streaks(one.coord, middle, 60.0, FOV_DEG / 2))
    assert between >= 5
    assert (table["first_start"] >= RANGE[0]).all() and (table["last_start"] + 60 * u.s <= RANGE[1] + 1 * u.ms).all()


def test_targets_of_every_kind(model, targets):
    one = clear_windows(model, targets[0], RANGE, 30.0)
    assert set(one["target"]) == {"field-00"}
    several = clear_windows(model, SkyCoord([target.coord for target in targets[:2]]), RANGE, 30.0)
    assert set(several["target"]) == {"0", "1"}
    assert (several[several["target"] == "0"]["length"] == one["length"]).all()
    assert len(clear_windows(model, SkyCoord(10, 85, unit="deg"), RANGE, 30.0)) == 0


def test_the_streaks_of_blocks(model, targets):
    blocks = [ObservingBlock.from_exposures(target, 1, 50 * u.s, 10, readout_time=10 * u.s) for target in targets[:6]]
    for number, block in enumerate(blocks[:5]):
        block.start_time = START + 10 * number * u.min
        block.end_time = block.start_time + 10 * u.min
    table = streak_table(model, blocks)
    assert table.colnames[:4] == ["block", "target", "exposure", "exposure_start"] and len(table) >= 3
    # The last block has no start.
    assert set(table["block"]) <= set(range(5))
    for row in table:
        block = blocks[row["block"]]
        assert row["target"] == block.target.name
        assert abs((row["exposure_start"] - block.start_time).to_value("s") - 60 * row["exposure"]) < 1e-3
        assert row["enter_utc"] <= row["exposure_start"] + 50 * u.s and row["exit_utc"] >= row["exposure_start"]
    # A block without information on exposures is one exposure.
    single = streak_table(model, [_plain(block) for block in blocks[:5]])
    crossings, single_crossings = ({(int(row["block"]), int(row["norad_id"])) for row in one} for one in (table, single))
    assert crossings <= single_crossings and set(single["exposure"]) == {0}


def _plain(block):
    plain = ObservingBlock(block.target, block.duration, 1)
    plain.start_time, plain.end_time = block.start_time, block.end_time
    return plain


def test_the_readme_runs(tmp_path, elements, monkeypatch):
    text = (Path(__file__).parents[1] / "README.md").read_text()
    (code,) = re.findall(r"```python\n(.*?)```", text, flags=re.S)
    (tmp_path / "gp.csv").write_text(elements[0].read_text())
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(code, names)
    assert len(names["schedule"].observing_blocks) == 2
    assert np.all(names["windows"]["length"] >= 0 * u.s)
