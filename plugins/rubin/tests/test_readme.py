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
    names = {"elements": folder / "4408.csv", "surveys": night.surveys_of("pairs", almanac.noon_of(EVENING))}
    exec(compile(code, "README.md", "exec"), names)
    scheduler = names["scheduler"]
    scheduler.update_conditions(observatory.return_conditions())
    assert scheduler.request_observation().size == 1
    assert scheduler.queue_manager.counts["checked"] > 0 and scheduler.queue_manager.counts["failed"] == 0


def test_all_exports_are_documented():
    text = README.read_text() + (README.parents[2] / "docs" / "reference" / "rubin.md").read_text()
    assert [name for name in streakcast_rubin.__all__ if name not in text] == []
