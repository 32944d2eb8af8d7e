"""The YAML of the README creates the constraint and the merit."""

import re
from pathlib import Path

import yaml
from pyobs.object import get_object

from conftest import LOCATION
from streakcast_pyobs import SatelliteConstraint, SatelliteMerit


def test_the_yaml_of_the_readme_is_valid(elements, observer):
    text = (Path(__file__).parents[1] / "README.md").read_text()
    (scheduler, task) = re.findall(r"```yaml\n(.*?)```", text, flags=re.S)
    scheduler, task = (one.replace("/var/elements/gp.csv", str(elements[0])) for one in (scheduler, task))
    created = get_object(yaml.safe_load(scheduler)["scheduler"], observer=observer, location=LOCATION)
    assert [type(one) for one in created._global_constraints][-1] is SatelliteConstraint
    (merit,) = yaml.safe_load(task)["merits"]
    assert type(created.pyobs_model_validate(SatelliteMerit, merit, by_alias=True)) is SatelliteMerit
