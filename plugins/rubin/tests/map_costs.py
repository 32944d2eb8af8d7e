"""Costs in the map of visits that start now, compared with those of `StreakModel.assess`. Prints the table of
docs/explanation/rubin.md.

`PYTHONPATH=examples python tests/map_costs.py FOLDER`; FOLDER is for almanacs and element files. Requires STREAKCAST_DATA.
"""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path

import night
import numpy as np
import streakcast
from nights import elements_of
from rubin_scheduler.utils import _hpid2_ra_dec
from streakcast_rubin import StreakCostBasisFunction
from streakcast_rubin._candidates import OPEN_SHARE
from streakcast_rubin._tracks import VISIT_S
from streakcast_rubin.cost_map import SLEW_UNIT_S

#: Satellites, evening, age of the elements (days) and model of drag.
CASES = (
    ("catalogue", "2026-04-25", 1, None),
    ("catalogue", "2026-05-02", 7, None),
    ("catalogue", "2026-05-02", 7, "published"),
    ("40768", "2026-07-15", 0, None),
)
#: Times after the start of the night, hours, and cost above which a cell is crossed, seconds of open shutter.
AFTER_H, CROSSED_S = (0.1, 0.8), 0.02


def compared(model: streakcast.StreakModel, conditions: object) -> tuple[float, float, float]:
    """Returns the ratio of the means, the correlation, and the percentage of the cells that agree, for every second cell
    above 30 degrees."""
    cells = np.flatnonzero(np.isfinite(conditions.slewtime) & (conditions.alt > np.radians(30.0)))[::2]
    found = -OPEN_SHARE * SLEW_UNIT_S * StreakCostBasisFunction(model)(conditions)[cells]
    starts = conditions.mjd + conditions.slewtime[cells] / 86_400.0
    expected = np.asarray(model.assess(tuple(np.degrees(_hpid2_ra_dec(32, cells))), starts, VISIT_S).streak_cost_s)
    same = np.mean((found > CROSSED_S) == (expected > CROSSED_S))
    return found.mean() / expected.mean(), np.corrcoef(found, expected)[0, 1], 100.0 * same


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore", streakcast.StreakcastWarning)
    print("| satellites, evening | age of the elements (days) | mean of the map / `assess` | correlation | cells that agree whether the "
          f"cost is above {CROSSED_S} s (%) |\n|---|---|---|---|---|")
    for sky, evening, age_days, drag in CASES:
        setup = {} if drag is None else {"drag": drag}
        elements = elements_of(sky, evening, folder)
        model = streakcast.StreakModel(site="Rubin Observatory", elements=elements, telescope="rubin", mjd_scale="utc", **setup)
        nights = (night.run(evening, "pairs", folder / f"almanac-{evening}", hours=hours) for hours in AFTER_H)
        conditions = [one.observatory.return_conditions() for one in nights]
        rows = [compared(model, one) for one in conditions]
        count = f"{model.satellites(float(np.max(conditions[0].mjd))):,}{' simulated' if age_days == 0 else ''}"
        name = f"{count}{'' if drag is None else f' with the {drag} drag'}, {evening}"
        ratios, correlations, same = (", ".join(form.format(one) for one in column) for form, column in zip(("{:.2f}", "{:.2f}", "{:.0f}"), zip(*rows)))
        print(f"| {name} | {age_days} | {ratios} | {correlations} | {same} |", flush=True)


if __name__ == "__main__":
    main()
