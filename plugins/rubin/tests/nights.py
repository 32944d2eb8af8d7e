"""Whole nights with and without streakcast, checked by brute force. Prints the tables of docs/tables/nights.md.

`python tests/nights.py FOLDER [--only WORD ...]` stores each run in FOLDER, and can be resumed. All runs take about an
hour on one core. The real catalogue requires STREAKCAST_DATA; without it, its rows are omitted with a message.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
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
#: What each hook avoids, in the words of the tables.
NAMES = {"off": "nothing", "any": "all", "limit": f"brighter than {LIMIT_MAG:g} mag", "pixels": 'all, `damage="pixels"`'}


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


def hook_of(hook: str, model: streakcast.StreakModel, kind: str) -> dict[str, Any]:
    """Returns the arguments of a night with a hook: queue manager for pairs, mask for greedy visits."""
    options: dict[str, dict[str, Any]] = {"any": {}, "limit": {"limit_mag": LIMIT_MAG}, "pixels": {"damage": "pixels"}}
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
    # The brute force applies the published drag.
    model = streakcast.StreakModel(
        site="Rubin Observatory", elements=elements, telescope="rubin", mjd_scale="utc", drag="published"
    )
    hooks = hook_of(run.hook, model, run.kind)
    # Without hooks, the night does not depend on the satellites.
    same = folder / f"{run.kind}-off-{run.evening}.npy"
    if run.hook == "off" and same.exists():
        visits = np.load(same)
    else:
        done = night.run(run.evening, run.kind, folder / f"almanac-{run.evening}", **hooks)
        visits = np.asarray(done.visits)
        np.save(same if run.hook == "off" else folder / f"{run.name}.npy", visits)
    result = {"satellites": model.satellites(visits["mjd"][0]), "visits": len(visits), "slew_s": float(visits["slewtime"].sum())}
    result |= judge(visits, truth_of(elements), model, NOISE_S if run.kind == "pairs" and run.hook in ("off", "any") else NOISE_S[:1])
    for hook in hooks.get("masks", hooks.values()):
        if hook.counts["failed"]:
            raise RuntimeError(f"{run.name}: {hook.counts['failed']} calls failed")
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
    total["slew_s"] /= total["visits"]
    return total


def changed(value: str, after: float, before: float, digits: int) -> str:
    """Appends the change relative to the nights without hooks, in percent."""
    return f"{value} ({100.0 * (after / before - 1.0):+.{digits}f} %)" if before else value


def line(first: list[str], hook: str, total: dict[str, Any], off: dict[str, Any]) -> str:
    """Formats a row of the table of visits. `off` is the total of the nights without hooks."""
    cells = [f"{total['visits']}", f"{total['streaked']['0']}", f"{total['bright']}", f"{total['slew_s']:.2f}"]
    if total is not off:
        after, before = ((one["visits"], one["streaked"]["0"], one["bright"], one["slew_s"]) for one in (total, off))
        cells = [changed(*one) for one in zip(cells, after, before, (1, 0, 0, 1))]
    return row([*first, NAMES[hook], *cells, f"{1e4 * total['lost_fraction'] / total['visits']:.2f}"])


def row(cells: list[str]) -> str:
    return "|" + "|".join(f" {one} " if one else " " for one in cells) + "|"


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
        runs = {hook: [simulate(Run(evening, kind, sky, hook), arguments.folder) for evening in nights] for hook in hooks}
        totals = {hook: summed(one) for hook, one in runs.items()}
        satellites = f"{runs['off'][0]['satellites']:,}" + (", real" if sky == "catalogue" else "")
        for hook, total in totals.items():
            first = [kind, satellites, str(len(nights))] if hook == "off" else ["", "", ""]
            lines.append(line(first, hook, total, totals["off"]))
            shares = [f"{100.0 * one / total['visits']:.1f} %" for one in total["streaked"].values()]
            if len(shares) == len(NOISE_S):
                curve.append(row([f"{satellites}, {NAMES[hook]}" + (" avoided" if hook == "off" else ""), *shares]))
    print("| survey | satellites | nights | avoided | visits | streaked visits | brighter than 7 mag | mean slew (s) | pixels lost (1e-4) |")
    print("|---|---|---|---|---|---|---|---|---|", *lines, sep="\n")
    print("\nStreaked visits of the nights of pairs if each satellite is late or early by a Gaussian error that is unknown to the")
    print("model, for four values of its sigma:\n")
    print("| streaked visits | " + " | ".join(f"{one:g} s" for one in NOISE_S) + " |")
    print("|---|---|---|---|---|", *curve, sep="\n")


if __name__ == "__main__":
    main()
