"""Ours and the peers on the same work, in one interleaved run: medians, ratios, and who found what.

The work: all crossings of a schedule's exposures (tests/reference/make_bench_exposures.py) against a catalogue.
Machines are noisy, so every round runs each tool once, and ratios are taken within a round; a tool's time is what it
reports of itself from the elements' text to the last crossing, start-up and imports aside.

    python tests/reference/make_bench_exposures.py /tmp/schedule.csv
    python tests/benches/peers/compare.py --elements tle/active/active_2026-04-25.txt --schedule /tmp/schedule.csv \
        --ours "target/release/... {elements} {schedule} {fov_deg} {limit}" --satidentifier CHECKOUT --rounds 5

`--ours` prints either {"name", "exposures", "timings": {"total_s", ...}, "crossings": [[exposure_id, norad_id], ...]} or
what `streakcast passes --format json` prints (then its time is the whole process). `--only astroz=1000,sgp4=100` names
peers and how many exposures of the schedule they get: times are per exposure then, sets are compared on those.

Where sets differ, the true closest approach is found by brute force (tests/reference/brute_force_crossings.py): within
`--graze-arcsec` of the field's edge a difference is one of method, beyond it somebody is wrong. Exit 1 if that is us.
"""

import argparse
import json
import shlex
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from chord import SPEED_OF_LIGHT_KM_S, Frames, radec_to_vector, read_schedule, utc_to_jd  # noqa: E402
from brute_force_crossings import Exposure, read_catalogue  # noqa: E402
from sky_frames import DAY_S, unit, vector_to_radec  # noqa: E402


def satidentifier_exposures(rows, frames, path):
    """Pointings as geometric directions: astrometric + v_Earth / c."""
    exposures = []
    for row in rows:
        jd, fraction = utc_to_jd(row["start_utc"])
        _, _, earth_km_s = frames.at(jd, fraction + float(row["duration_s"]) / 2 / DAY_S)
        ra_deg, dec_deg = vector_to_radec(
            unit(radec_to_vector(float(row["ra_deg"]), float(row["dec_deg"])) + earth_km_s[0] / SPEED_OF_LIGHT_KM_S)
        )
        exposures.append({
            "id": row["exposure_id"], "t0_ms": round((jd - 2440587.5 + fraction) * 86_400_000), "duration_s": float(row["duration_s"]),
            "ra_deg": ra_deg, "dec_deg": dec_deg, "dut1_s": float(frames.table.ut1_utc(jd, fraction).to_value("s")),
        })  # fmt: skip
    Path(path).write_text(json.dumps(exposures))


def answer(command, rows):
    """Run one tool; its JSON, with `total_s` and `crossings` in any case."""
    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True)
    wall_s = time.perf_counter() - start
    # `passes` exits 1 where it found nothing.
    if done.returncode not in (0, 1) or not done.stdout.strip():
        sys.exit(f"{shlex.join(command)} failed ({done.returncode}):\n{done.stderr[-2000:]}")
    report = json.loads(done.stdout)
    if "passes" in report:
        report = {
            "name": "streakcast passes", "exposures": len(report["exposures"]), "timings": {"total_s": wall_s},
            "crossings": [(row["exposure_id"], row["norad_id"]) for row in report["passes"]],
        }  # fmt: skip
    if report["exposures"] != len(rows):
        sys.exit(f"{report['name']} answered {report['exposures']} exposures of {len(rows)}")
    return report


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", required=True)
    parser.add_argument("--schedule", required=True)
    parser.add_argument("--ours", help="command, with {elements} {schedule} {fov_deg} {limit}")
    parser.add_argument("--satidentifier", help="a clone of github.com/exoplanet5/SatIdentifier")
    parser.add_argument("--only", default="astroz=0,sgp4=100,satidentifier=100", help="peers and their number of exposures, 0 for all")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--fov-deg", type=float, default=3.5)
    parser.add_argument("--limit", type=int, default=0, help="only the first exposures of the schedule, 0 for all")
    parser.add_argument("--graze-arcsec", type=float, default=60.0)
    options = parser.parse_args()

    frames, rows = Frames(), read_schedule(options.schedule, options.limit)
    folder = tempfile.TemporaryDirectory()
    tools = {}
    if options.ours:
        words = {"elements": options.elements, "schedule": options.schedule, "fov_deg": options.fov_deg, "limit": len(rows)}
        tools["ours"] = (len(rows), [word.format(**words) for word in shlex.split(options.ours)])
    for word in options.only.split(",") if options.only else []:
        peer, _, count = word.partition("=")
        count = min(int(count or 0) or len(rows), len(rows))
        if peer == "satidentifier":
            if not options.satidentifier:
                print("satidentifier: left out, no --satidentifier CHECKOUT", file=sys.stderr)
                continue
            path = f"{folder.name}/exposures.json"
            satidentifier_exposures(rows[:count], frames, path)
            command = ["node", str(HERE / "peer_satidentifier.cjs"), options.satidentifier, options.elements, path, str(options.fov_deg)]
        else:
            command = [sys.executable, str(HERE / f"peer_{peer}.py"), options.elements, options.schedule, str(options.fov_deg), str(count)]
        tools[peer] = (count, command)

    reports = {tool: [] for tool in tools}
    for turn in range(options.rounds):
        for tool, (count, command) in tools.items():
            report = answer(command, rows[:count])
            reports[tool].append(report)
            timings = ", ".join(f"{key} {value:.4f}" for key, value in report["timings"].items())
            print(f"round {turn + 1}: {report['name']}: {report['exposures']} exposures, {len(report['crossings'])} crossings; {timings}", file=sys.stderr)

    # One-time work (reading, making ready) is counted whole; what grows with exposures is scaled to the whole schedule.
    def whole_s(report):
        timings = report["timings"]
        if report["exposures"] == len(rows) or "crossings_s" not in timings:
            return timings["total_s"]
        once_s = timings.get("read_s", 0.0)
        return once_s + (timings["total_s"] - once_s) * len(rows) / report["exposures"]

    print(f"\n{len(rows)} exposures, {options.rounds} rounds: medians, and the median of the ratios of each round")
    print(f"| {'tool':42s} | total, s | of it reading, s | per exposure, ms | times ours |\n|{'-' * 44}|---|---|---|---|")
    for tool, (count, _) in tools.items():
        mine = reports[tool]
        total_s = statistics.median(map(whole_s, mine))
        read_s = statistics.median(r["timings"].get("read_s", float("nan")) for r in mine)
        each_ms = statistics.median((r["timings"].get("crossings_s", r["timings"]["total_s"]) + r["timings"].get("frames_s", 0.0)) / r["exposures"] * 1e3 for r in mine)
        ratio = statistics.median(whole_s(r) / whole_s(o) for r, o in zip(mine, reports["ours"])) if "ours" in tools else float("nan")
        scaled = "" if count == len(rows) else f" (from {count})"
        print(f"| {mine[0]['name'] + scaled:42s} | {total_s:.3f} | {read_s:.3f} | {each_ms:.4f} | {ratio:.1f} |")

    satellites, ids = read_catalogue(Path(options.elements))
    row_of = {row["exposure_id"]: row for row in rows}
    radius = np.radians(options.fov_deg / 2)
    found = {tool: {(str(e), int(n)) for e, n in mine[0]["crossings"]} for tool, mine in reports.items()}
    changing = [tool for tool, mine in reports.items() if any({(str(e), int(n)) for e, n in r["crossings"]} != found[tool] for r in mine)]
    if changing:
        print(f"\nnot the same answer in every round: {', '.join(changing)}")
    print("\ncrossings: " + ", ".join(f"{tool} {len(pairs)} in {tools[tool][0]}" for tool, pairs in found.items()))
    seen_by = {tool: {row["exposure_id"] for row in rows[:count]} for tool, (count, _) in tools.items()}
    wrong = {tool: 0 for tool in tools}
    for exposure_id, norad in sorted(set().union(*found.values())):
        asked = [tool for tool in tools if exposure_id in seen_by[tool]]
        yes = [tool for tool in asked if (exposure_id, norad) in found[tool]]
        if len(yes) == len(asked):
            continue
        row = row_of[exposure_id]
        exposure = Exposure(frames, row["start_utc"], float(row["duration_s"]), float(row["ra_deg"]), float(row["dec_deg"]))
        least = [exposure.chords(satellites[i])[1] for i in np.flatnonzero(ids == norad)]
        edge = [(value - radius) * 180 / np.pi * 3600 for value in least]
        crosses = any(value <= 0 for value in edge)
        grazing = min(map(abs, edge), default=float("nan")) <= options.graze_arcsec
        if not grazing:
            for tool in asked:
                wrong[tool] += (tool in yes) != crosses
        records = f" ({len(least)} records in the catalogue)" if len(least) > 1 else ""
        print(f"  {exposure_id} {norad}: found by {', '.join(yes)}, not by {', '.join(t for t in asked if t not in yes)}; closest approach "
              f"{', '.join(f'{value:+.1f}' for value in edge)} arcsec from the edge{records}: {'grazing' if grazing else 'REAL'}")  # fmt: skip
    print("real differences against the truth: " + ", ".join(f"{tool} {count}" for tool, count in wrong.items()))
    folder.cleanup()
    sys.exit(1 if wrong.get("ours") else 0)


if __name__ == "__main__":
    main()
