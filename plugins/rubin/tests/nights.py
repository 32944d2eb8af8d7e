"""Whole nights with and without streakcast, checked by brute force. Prints the numbers of docs/tables/nights.md.

`python tests/nights.py FOLDER [--only WORD ...]` stores each run in FOLDER, and can be resumed. All runs take about two
hours on one core. The real catalogue requires STREAKCAST_DATA; without it, its rows are omitted with a message.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
import warnings
from dataclasses import dataclass, field
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
from streakcast_rubin import StreakMaskBasisFunction, StreakQueueManager

#: One night per season. In January satellites are lit all night, in August only at twilight.
NIGHTS = ("2026-01-15", "2026-04-25", "2026-08-14", "2026-10-20")
SKIES = {
    "4408": ["starlink-gen1"],
    "40768": ["starlink-gen1", "starlink-gen2", "oneweb"],
    # All active satellites on the evening of 2026-04-25, from LEO to GEO.
    "catalogue": None,
}
#: Along-track errors of the true positions, seconds, which the model does not include.
NOISE_S = (0.0, 1.0, 3.0, 10.0)
SEED = 1
LIMIT_MAG = 7.0


@dataclass
class CallTimes:
    """Durations of calls of a hook."""

    wall_s: list[float] = field(default_factory=list)
    cpu_s: list[float] = field(default_factory=list)

    def wrap(self, function: Any) -> Any:
        def timed(*arguments: Any, **more: Any) -> Any:
            wall, cpu = time.perf_counter(), time.process_time()
            try:
                return function(*arguments, **more)
            finally:
                self.wall_s.append(time.perf_counter() - wall)
                self.cpu_s.append(time.process_time() - cpu)

        return timed


@dataclass(frozen=True)
class Run:
    """One night with one configuration."""

    evening: str
    kind: str
    sky: str
    hook: str

    @property
    def name(self) -> str:
        return f"{self.kind}-{self.sky}-{self.hook}-{self.evening}"


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


def hooks_of(hook: str, model: streakcast.StreakModel, kind: str) -> dict[str, Any]:
    """Returns the hooks of a configuration: queue manager for pairs, mask for greedy visits.

    `cells` is the mask without the fields of the survey.
    """
    options: dict[str, dict[str, Any]] = {"any": {}, "cells": {}, "limit": {"limit_mag": LIMIT_MAG}, "pixels": {"damage": "pixels"}}
    if hook == "off":
        return {}
    if kind == "greedy":
        return {"masks": [StreakMaskBasisFunction(model, **options[hook])]}
    return {"queue_manager": StreakQueueManager(model, detailers=[RotspUpdateDetailer()], **options[hook])}


def simulate(run: Run, folder: Path) -> dict[str, Any]:
    """Simulates one night, evaluates it, and stores both results."""
    stored = folder / f"{run.name}.json"
    if stored.exists():
        return json.loads(stored.read_text())
    print(run.name, file=sys.stderr, flush=True)
    elements = elements_of(run.sky, run.evening, folder)
    model = streakcast.StreakModel(site="Rubin Observatory", elements=elements, telescope="rubin", mjd_scale="utc")
    hooks, clock = hooks_of(run.hook, model, run.kind), CallTimes()
    if "queue_manager" in hooks:
        hooks["queue_manager"]._choice = clock.wrap(hooks["queue_manager"]._choice)
    for mask in hooks.get("masks", ()):
        mask._calc_value = clock.wrap(mask._calc_value)
    # Without hooks, the night does not depend on the satellites.
    same = folder / f"{run.kind}-off-{run.evening}.npy"
    begun = time.time()
    if run.hook == "off" and same.exists():
        visits = np.load(same)
    else:
        done = night.run(run.evening, run.kind, folder / f"almanac-{run.evening}", follow=run.hook != "cells", **hooks)
        visits = np.asarray(done.visits)
        np.save(same if run.hook == "off" else folder / f"{run.name}.npy", visits)
    result = {"visits": len(visits), "slew_s": float(visits["slewtime"].sum()), "minutes": (time.time() - begun) / 60.0}
    result |= judge(visits, truth_of(elements), model, NOISE_S if run.kind == "pairs" and run.hook in ("off", "any") else NOISE_S[:1])
    if clock.wall_s:
        result |= {"hook_ms": [1e3 * float(np.median(one)) for one in (clock.wall_s, clock.cpu_s)]}
        result |= {"hook_most_ms": 1e3 * max(clock.wall_s)}
    if "queue_manager" in hooks:
        result |= {"counts": dict(hooks["queue_manager"].counts)}
    for mask in hooks.get("masks", ()):
        result |= {"counts": dict(mask.counts)}
    stored.write_text(json.dumps(result))
    return result


@cache
def truth_of(elements: Path) -> brute_force.Truth:
    """Reads the satellites once for all runs."""
    return brute_force.Truth(brute_force.read_elements(elements))


def judge(visits: np.ndarray, truth: brute_force.Truth, model: streakcast.StreakModel, noise_s: tuple[float, ...]) -> dict[str, Any]:
    """Counts streaked visits by brute force for every along-track error. Losses are computed by the model."""
    streaked = {f"{sigma_s:g}": int(brute_force.streaked(truth.delayed(sigma_s, SEED), visits).sum()) for sigma_s in noise_s}
    result = model.with_options(limit_mag=LIMIT_MAG).assess(
        (np.degrees(visits["RA"]), np.degrees(visits["dec"])), visits["mjd"], visits["exptime"]
    )
    lost = np.nan_to_num(result.lost_fraction)
    return {"streaked": streaked, "bright": int(result.avoid.sum()), "lost_fraction": float(lost.sum())}


def summed(rows: list[dict[str, Any]]) -> dict[str, Any]:
    total = {key: sum(row[key] for row in rows) for key in ("visits", "slew_s", "bright", "lost_fraction")}
    total["streaked"] = {sigma: sum(row["streaked"][sigma] for row in rows) for sigma in rows[0]["streaked"]}
    timed = [row["hook_ms"] for row in rows if "hook_ms" in row]
    total["hook_ms"] = np.median(timed, axis=0).tolist() if timed else None
    total["hook_most_ms"] = max((row.get("hook_most_ms", 0.0) for row in rows), default=0.0)
    return total


def line(kind: str, sky: str, hook: str, nights: int, total: dict[str, Any], off: dict[str, Any] | None) -> str:
    """Formats a row of the table, with changes in percent relative to the nights without hooks."""
    slew_s = total["slew_s"] / total["visits"]
    cells = [kind, sky, str(nights), hook, str(total["visits"]), f"{total['streaked']['0']}", f"{total['bright']}", f"{slew_s:.2f}"]
    if off is not None:
        before_s = off["slew_s"] / off["visits"]
        cells[4] += f" ({100.0 * (total['visits'] / off['visits'] - 1.0):+.1f} %)"
        cells[5] += f" ({100.0 * (total['streaked']['0'] / max(off['streaked']['0'], 1e-9) - 1.0):+.0f} %)"
        cells[6] += f" ({100.0 * (total['bright'] / max(off['bright'], 1e-9) - 1.0):+.0f} %)"
        cells[7] += f" ({100.0 * (slew_s / before_s - 1.0):+.1f} %)"
    cells.append(f"{1e4 * total['lost_fraction'] / total['visits']:.2f}")
    cells.append("" if total["hook_ms"] is None else f"{total['hook_ms'][0]:.1f} / {total['hook_ms'][1]:.1f}")
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="*", default=[], help="words that the names of runs must contain")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    warnings.simplefilter("ignore", streakcast.StreakcastWarning)
    table = {
        ("pairs", "4408"): (NIGHTS, ("off", "any")),
        ("pairs", "40768"): (NIGHTS[:3], ("off", "any", "limit", "pixels")),
        ("pairs", "catalogue"): (NIGHTS[1:2], ("off", "any")),
        ("greedy", "4408"): (NIGHTS, ("off", "any")),
        ("greedy", "40768"): (NIGHTS, ("off", "any")),
        ("greedy", "catalogue"): (NIGHTS[1:2], ("off", "any")),
    }
    lines, curve = [], []
    for (kind, sky), (nights, hooks) in table.items():
        if arguments.only and not any(word in f"{kind}-{sky}" for word in arguments.only):
            continue
        if sky == "catalogue" and catalogue() is None:
            print("*** the real catalogue is omitted: set STREAKCAST_DATA to the data folder", file=sys.stderr)
            continue
        totals = {hook: summed([simulate(Run(evening, kind, sky, hook), arguments.folder) for evening in nights]) for hook in hooks}
        for hook, total in totals.items():
            lines.append(line(kind, sky, hook, len(nights), total, totals["off"] if hook != "off" else None))
            shares = [f"{100.0 * one / total['visits']:.1f} %" for one in total["streaked"].values()]
            if len(shares) == len(NOISE_S):
                curve.append(f"| {kind} | {sky} | {hook} | " + " | ".join(shares) + " |")
    print("| survey | satellites | nights | hook | visits | streaked | brighter than 7 mag | mean slew (s) | lost pixels (1e-4) | hook wall / CPU (ms) |")
    print("|---|---|---|---|---|---|---|---|---|---|", *lines, sep="\n")
    print("\nStreaked visits with Gaussian along-track errors of the true positions:\n")
    print("| survey | satellites | hook | " + " | ".join(f"{one:g} s" for one in NOISE_S) + " |")
    print("|---|---|---|---|---|---|---|", *curve, sep="\n")


if __name__ == "__main__":
    main()
