"""The example of the README runs, and the documentation contains all exported classes."""

import re
from pathlib import Path

import almanac
import night
import streakcast_rubin
from conftest import EVENING

README = Path(__file__).resolve().parents[1] / "README.md"


def test_the_example_runs(folder):
    (code,) = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    observatory = night.observatory_of(EVENING, folder)
    names = {"elements": folder / "4408.csv", "surveys": night.surveys_of("pairs", almanac.noon_of(EVENING)), "slewtime_weight": 3.0}
    exec(compile(code, "README.md", "exec"), names)
    scheduler = names["scheduler"]
    scheduler.update_conditions(observatory.return_conditions())
    assert scheduler.request_observation().size == 1
    for counts in (scheduler.queue_manager.counts, names["ahead"].counts):
        assert counts["asked"] > 0 and counts["failed"] == counts["clock"] == 0
    # One map for the surveys of all bands.
    assert names["ahead"].counts["made"] == 1


def test_the_example_night_runs(folder, monkeypatch, capsys):
    # The example writes an almanac into a temporary folder, and sets this variable.
    monkeypatch.setenv("RUBIN_SIM_DATA_DIR", str(folder))
    monkeypatch.setattr("sys.argv", ["night.py", "--shells", "starlink-gen1,oneweb", "--evening", "2026-10-20", "--hours", "0.2"])
    night.main()
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in lines[:2]] == ["without streakcast", "with streakcast"] and "visits were exchanged" in lines[2]


def test_all_exports_are_documented():
    text = README.read_text() + (README.parents[2] / "docs" / "reference" / "rubin.md").read_text()
    assert [name for name in streakcast_rubin.__all__ if name not in text] == []
