"""Whole nights with and without streakcast, checked by brute force. Prints the tables of docs/tables/nights.md.

`PYTHONPATH=examples python tests/nights.py FOLDER` stores each run in FOLDER, and can be resumed. The surveys are pairs in
three bands with the queue manager and the map of the next 45 minutes. The real catalogue requires STREAKCAST_DATA; without
it, its rows are omitted with a message.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
import warnings
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import brute_force
import night
import numpy as np
import streakcast
from astropy import units as u
from astropy.time import Time
from rubin_scheduler.scheduler.detailers import RotspUpdateDetailer
from streakcast_rubin import StreakCostBasisFunction, StreakQueueManager
from streakcast_rubin._candidates import OPEN_SHARE
from streakcast_rubin._mount import Mount

SKIES = {
    # All active satellites on 2026-04-25, from LEO to GEO.
    "catalogue": None,
    "40768": ["starlink-gen1", "starlink-gen2", "oneweb"],
}
NIGHTS = {
    "catalogue": tuple(f"2026-04-{day}" for day in (25, 21, 28, 23, 29, 26)),
    "40768": ("2026-01-15", "2026-04-25", "2026-10-20"),
}
#: Values of `bright_share`; the default for all nights, the others for the first nights only.
DEFAULT, OTHERS, NIGHTS_OF_OTHERS = "0.08", ("0.3", "1"), 2
SHARES = (0.08, 0.3, 1.0)
LIMIT_MAG = 7.0
#: First evening and number of nights of a lunation, in which the excess path is measured with `bright_share` 1.
LUNATION = "2026-04-11", 29


@dataclass(frozen=True)
class Run:
    """One night with one value of `bright_share`, or without streakcast (`off`)."""

    evening: str
    sky: str
    hook: str

    @property
    def name(self) -> str:
        return f"{self.sky}-{self.hook}-{self.evening}"


class Timed:
    """Sum of the processor time of a method, seconds."""

    def __init__(self, hook: Any, method: str) -> None:
        self.cpu_s, function = 0.0, getattr(hook, method)

        def timed(*arguments: Any) -> Any:
            start = time.process_time()
            try:
                return function(*arguments)
            finally:
                self.cpu_s += time.process_time() - start

        setattr(hook, method, timed)


def elements_of(sky: str, evening: str, folder: Path) -> Path:
    """Returns the element file that is read by the model and by the brute force."""
    if sky == "catalogue":
        return catalogue()
    path = folder / f"{sky}-{evening}.csv"
    if not path.exists():
        brute_force.write_walker(SKIES[sky], Time(f"{evening}T12:00:00") + 0.5 * u.day, path)
    return path


def catalogue() -> Path | None:
    folder = os.environ.get("STREAKCAST_DATA")
    data = Path(folder) if folder else Path(__file__).resolve().parents[4] / "shared" / "data"
    path = data / "tle" / "active" / "active_2026-04-25.txt"
    return path if path.is_file() else None


def simulate(run: Run, folder: Path) -> dict[str, Any]:
    """Simulates one night, evaluates it, and stores both results."""
    stored = folder / f"{run.name}.json"
    if stored.exists():
        return json.loads(stored.read_text())
    print(run.name, file=sys.stderr, flush=True)
    elements = elements_of(run.sky, run.evening, folder)
    # The brute force applies the published drag.
    model = streakcast.StreakModel(
        site="Rubin Observatory", elements=elements, telescope="rubin", mjd_scale="utc", drag="published"
    )
    visits, hooks = visits_of(run, folder, model)
    result = {"satellites": model.satellites(visits["mjd"][0]), **hooks, **judge(visits, truth_of(elements), model)}
    stored.write_text(json.dumps(result))
    return result


def visits_of(run: Run, folder: Path, model: streakcast.StreakModel) -> tuple[np.ndarray, dict[str, float]]:
    """Returns the visits of a night, with counters and processor times of the hooks."""
    # Without hooks, the night does not depend on the satellites.
    stored = folder / f"off-{run.evening}.npy"
    if run.hook == "off" and stored.exists():
        return np.load(stored), {}
    almanac = folder / f"almanac-{run.evening}"
    if run.hook == "off":
        visits = np.asarray(night.run(run.evening, "pairs", almanac).visits)
        np.save(stored, visits)
        return visits, {}
    share = float(run.hook)
    manager = StreakQueueManager(model, bright_share=share, detailers=[RotspUpdateDetailer()])
    ahead = StreakCostBasisFunction(model, bright_share=share, ahead_min=45.0)
    cpu = {"queue_cpu_s": Timed(manager, "_choice"), "map_cpu_s": Timed(ahead, "_map_of")}
    done = night.run(run.evening, "pairs", almanac, queue_manager=manager, rewards=[(ahead, night.SLEWTIME_WEIGHT)])
    visits = np.asarray(done.visits)
    np.save(folder / f"{run.name}.npy", visits)
    for hook in (manager, ahead):
        if hook.counts["failed"] or hook.counts["unknown"]:
            raise RuntimeError(f"{run.name}: calls failed: {hook.counts}")
    counters = {name: float(manager.counts[name]) for name in ("asked", "compared", "exchanged", "saved_s", "detour_s")}
    return visits, {**counters, "maps": ahead.counts["made"], **{name: one.cpu_s for name, one in cpu.items()}}


@cache
def truth_of(elements: Path) -> brute_force.Truth:
    """Reads the satellites once for all runs."""
    return brute_force.Truth(brute_force.read_elements(elements))


def judge(visits: np.ndarray, truth: brute_force.Truth, model: streakcast.StreakModel) -> dict[str, Any]:
    """Counts streaked visits by brute force. Costs and magnitudes are computed by the model."""
    starts = Time(visits["mjd"], format="mjd", scale="utc")
    crossings = truth.crossings(visits["RA"], visits["dec"], starts, visits["exptime"], 1.75)
    revolutions_day = np.array([one.no_kozai for one in truth.satellites]) * 1440.0 / (2.0 * np.pi)
    target, exposures = (np.degrees(visits["RA"]), np.degrees(visits["dec"])), (visits["mjd"], visits["exptime"])
    costs = {share: model.with_options(bright_share=share).assess(target, *exposures).streak_cost_s for share in (0.0, *SHARES)}
    gaps_min, singles = pairs_of(visits)
    return {
        "visits": len(visits),
        "open_s": float(visits["exptime"].sum()),
        "slew_s": float(visits["slewtime"].sum()),
        "excess_s": excess_path_s(visits),
        "streaked": sum(bool(one) for one in crossings),
        "geostationary": sum(any(0.9 < revolutions_day[index] < 1.1 for index in one) for one in crossings),
        "bright": int(model.with_options(limit_mag=LIMIT_MAG).assess(target, *exposures).avoid.sum()),
        # t P q L / D: the loss if a bright streak destroys the visit, without the mask.
        "light_s": float((costs[1.0] - costs[0.0]).sum()),
        "cost_s": [float(costs[share].sum()) for share in SHARES],
        "gap_min": float(np.percentile(gaps_min, 95.0)),
        "singles": singles,
    }


def excess_path_s(visits: np.ndarray) -> float:
    """Returns by how much the path of the executed order is longer than that of the order of the queue, seconds, with the
    slew times of `KinemModel` without the rotator."""
    mount, executed = Mount(), np.arange(len(visits))
    # Numbers ascend in the order of the queue.
    queued, excess_s = np.argsort(visits["target_id"], kind="stable"), 0.0
    for step in executed[1:]:
        pairs = [(order[step - 1], order[step]) for order in (executed, queued)]
        if pairs[0] != pairs[1]:
            lengths_s = [mount.between(float(visits["mjd"][step]), visits[list(pair)])[0, 1] for pair in pairs]
            excess_s += lengths_s[0] - lengths_s[1]
    return float(excess_s)


def pairs_of(visits: np.ndarray) -> tuple[list[float], int]:
    """Returns the gaps of all pairs, minutes, and the number of visits without a second one."""
    fields: dict[tuple[float, float], list[float]] = {}
    for visit in visits:
        fields.setdefault((round(float(visit["RA"]), 9), round(float(visit["dec"]), 9)), []).append(float(visit["mjd"]))
    gaps_min = [(two - one) * 1440.0 for mjds in fields.values() for one, two in zip(mjds[::2], mjds[1::2])]
    return gaps_min, sum(len(mjds) % 2 for mjds in fields.values())


def change(runs: list[dict[str, Any]], off: list[dict[str, Any]], value: Any, digits: int = 1) -> str:
    """Returns the mean change relative to the nights without streakcast, in percent of their mean, with its error."""
    before = np.array([value(one) for one in off])
    changes = 100.0 * (np.array([value(one) for one in runs]) - before) / before.mean()
    return f"{changes.mean():+.{digits}f} ± {changes.std(ddof=1) / np.sqrt(len(changes)):.{digits}f} %"


def mean(runs: list[dict[str, Any]], name: str, digits: int = 0) -> str:
    return f"{np.mean([one[name] for one in runs]):.{digits}f}"


def row(cells: list[str]) -> str:
    return "|" + "|".join(f" {one} " for one in cells) + "|"


#: Columns of the three tables after the first ones: open shutter, streaks, checks.
TABLES = (
    ("visits", "net at 0.08", "net at 0.3", "net at 1"),
    ("streaked visits", "brighter than 7 mag", "bright light (s)", "cost at 0.08 (%)", "excess path (s)"),
    ("geostationary", "pair gap p95 (min)", "single visits", "exchanged", "saved (s)"),
)


def lines_of(first: list[str], runs: list[dict[str, Any]], off: list[dict[str, Any]]) -> list[str]:
    """Returns a row of each table. `off` has the same nights without streakcast."""
    opened, streaks = [mean(runs, "visits"), "", "", ""], [mean(runs, name) for name in ("streaked", "bright", "light_s")]
    cost_percent = 100.0 * sum(one["cost_s"][0] for one in runs) / sum(one["open_s"] for one in runs)
    checks = [mean(runs, "geostationary", 1), mean(runs, "gap_min", 1), mean(runs, "singles", 1), "", ""]
    if runs is not off:
        opened[0] += f" ({change(runs, off, lambda one: one['visits'])})"
        opened[1:] = [change(runs, off, lambda one: one["open_s"] - one["cost_s"][index]) for index in range(len(SHARES))]
        streaks = [f"{cell} ({change(runs, off, lambda one: one[name], 0)})" for cell, name in zip(streaks, ("streaked", "bright", "light_s"))]
        checks[3:] = [mean(runs, "exchanged"), mean(runs, "saved_s")]
    excess_s = np.array([one["excess_s"] for one in runs])
    excess = f"{excess_s.mean():.0f} ± {excess_s.std(ddof=1) / np.sqrt(excess_s.size):.0f}" if runs is not off else "0"
    return [row([*first, *cells]) for cells in (opened, [*streaks, f"{cost_percent:.2f}", excess], checks)]


def path_of_lunation(folder: Path) -> str:
    """Returns a sentence with the excess path of the nights of a lunation if streaks destroy visits. Positions far from the
    epochs of the elements are less certain."""
    elements, excess_s, saved_s = catalogue(), [], []
    model = streakcast.StreakModel(
        site="Rubin Observatory", elements=elements, telescope="rubin", mjd_scale="utc", drag="published"
    )
    first, count = LUNATION
    for number in range(count):
        evening = (Time(first) + number * u.day).strftime("%Y-%m-%d")
        stored = folder / f"path-{evening}.json"
        if not stored.exists():
            print(stored.stem, file=sys.stderr, flush=True)
            visits, hooks = visits_of(Run(evening, "catalogue", "1"), folder, model)
            stored.write_text(json.dumps([excess_path_s(visits), hooks["saved_s"]]))
        one_excess_s, one_saved_s = json.loads(stored.read_text())
        excess_s.append(one_excess_s)
        saved_s.append(one_saved_s)
    texts = [f"{np.mean(values):.0f} ± {np.std(values, ddof=1) / np.sqrt(count):.0f}" for values in (excess_s, saved_s)]
    return f"The {count} nights from {first}, `bright_share` 1: excess path {texts[0]} s per night, {texts[1]} s saved."


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore", streakcast.StreakcastWarning)
    tables: list[list[str]] = [[] for _ in TABLES]
    for sky, evenings in NIGHTS.items():
        if sky == "catalogue" and catalogue() is None:
            print("*** the real catalogue is omitted: set STREAKCAST_DATA to the data folder", file=sys.stderr)
            continue

        def of(hook: str, nights: int | None = None) -> list[dict[str, Any]]:
            return [simulate(Run(evening, sky, hook), arguments.folder) for evening in evenings[:nights]]

        off, few = of("off"), of("off", NIGHTS_OF_OTHERS)
        satellites = f"{off[0]['satellites']:,} " + ("real" if sky == "catalogue" else "simulated")
        default, others = of(DEFAULT), {hook: of(hook, NIGHTS_OF_OTHERS) for hook in OTHERS}
        costly = [run["saved_s"] < OPEN_SHARE * run["detour_s"] for run in default]
        if any(costly):
            print(f"*** {sky}: exchanges cost more than they save in {sum(costly)} nights", file=sys.stderr)
        cpu_ms = 1e3 * sum(run["queue_cpu_s"] + run["map_cpu_s"] for run in default) / sum(run["visits"] for run in default)
        print(f"{sky}: processor time of queue manager and map {cpu_ms:.2f} ms per visit", file=sys.stderr)
        rows = [("off", off, off), (DEFAULT, default, off), ("off", few, few), (DEFAULT, default[:NIGHTS_OF_OTHERS], few)]
        for hook, runs, without in [*rows, *((hook, runs, few) for hook, runs in others.items())]:
            for table, line in zip(tables, lines_of([satellites, str(len(runs)), hook], runs, without)):
                table.append(line)
    for columns, lines in zip(TABLES, tables):
        first = ["satellites", "nights", "`bright_share`", *columns]
        print(row(first), "|---" * len(first) + "|", *lines, "", sep="\n")
    if catalogue() is not None:
        print(path_of_lunation(arguments.folder))


if __name__ == "__main__":
    main()
