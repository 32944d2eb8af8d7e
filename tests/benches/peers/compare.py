"""Compares streakcast with other programs on the same input: times, ratios, and differences of the results.

The task is to find all crossings of the exposures of a schedule (tests/reference/make_bench_exposures.py) by a
catalogue. Every round runs each program once, and ratios are computed within a round, because the speed of the machine
varies. The time of a program is the one that it reports, from the text of the elements to the last crossing, without
start-up and imports. Medians are printed.

    python tests/reference/make_bench_exposures.py schedule.csv
    python tests/benches/peers/compare.py --elements tle/active/active_2026-04-25.txt --schedule schedule.csv \
        --streakcast "target/release/... {elements} {schedule} {fov_deg} {limit}" --satidentifier CHECKOUT --rounds 5

`--streakcast` prints either {"name", "exposures", "timings": {"total_s", ...}, "crossings": [[exposure_id, norad_id], ...],
"left_out": [norad_id, ...]} or the output of `streakcast passes --drag published --format json`; in the latter case its time is that of
the whole process. `--only astroz=1000,sgp4=100` selects programs with numbers of exposures; times are then per
exposure, and results are compared for these exposures.

For differing results, the closest approach is computed by brute force (tests/reference/brute_force_crossings.py).
Within `--graze-arcsec` of the edge of the field, a difference is due to the method; farther away, one program is wrong.
The exit code is 1 if that is streakcast. (Years after its epoch SGP4 may give any position for a decayed object; such
results are listed and not counted.)
"""

import argparse
import json
import os
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


# Upper limit of the speed of objects in bound orbits.
ESCAPE_KM_S = 11.2


def satidentifier_exposures(rows, frames, path):
    """Converts pointings to geometric directions: astrometric + v_Earth / c."""
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
    """Runs one program. Returns its JSON, with `total_s` and `crossings`."""
    start = time.perf_counter()
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        child = subprocess.Popen(command, stdout=out, stderr=err)
        _, status, used = os.wait4(child.pid, 0)
        wall_s = time.perf_counter() - start
        child.returncode = os.waitstatus_to_exitcode(status)
        texts = []
        for stream in (out, err):
            stream.seek(0)
            texts.append(stream.read().decode())
    # The exit code of `passes` is 1 if there are no crossings.
    if child.returncode not in (0, 1) or not texts[0].strip():
        sys.exit(f"{shlex.join(command)} failed ({child.returncode}):\n{texts[1][-2000:]}")
    report = json.loads(texts[0])
    if "passes" in report:
        report = {
            "name": "streakcast passes", "exposures": len(report["exposures"]), "timings": {"total_s": wall_s},
            "crossings": [(row["exposure_id"], row["norad_id"]) for row in report["passes"]],
        }  # fmt: skip
    if report["exposures"] != len(rows):
        sys.exit(f"{report['name']} answered {report['exposures']} exposures of {len(rows)}")
    report["peak_mb"] = used.ru_maxrss / 1024
    return report


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", required=True)
    parser.add_argument("--schedule", required=True)
    parser.add_argument("--streakcast", help="command, with {elements} {schedule} {fov_deg} {limit}")
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
    if options.streakcast:
        values = {"elements": options.elements, "schedule": options.schedule, "fov_deg": options.fov_deg, "limit": len(rows)}
        tools["streakcast"] = (len(rows), [word.format(**values) for word in shlex.split(options.streakcast)])
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

    # Reading and preparation are counted once; the time per exposure is scaled to the whole schedule.
    def whole_s(report):
        timings = report["timings"]
        if report["exposures"] == len(rows) or "crossings_s" not in timings:
            return timings["total_s"]
        once_s = timings.get("read_s", 0.0)
        return once_s + (timings["total_s"] - once_s) * len(rows) / report["exposures"]

    print(f"\n{len(rows)} exposures, {options.rounds} rounds: medians, and the median of the ratios of each round")
    print(f"| {'tool':42s} | total, s | of it reading, s | per exposure, ms | peak, MB | ratio |\n|{'-' * 44}|---|---|---|---|---|")
    for tool, (count, _) in tools.items():
        mine = reports[tool]
        total_s = statistics.median(map(whole_s, mine))
        read_s = statistics.median(r["timings"].get("read_s", float("nan")) for r in mine)
        each_ms = statistics.median((r["timings"].get("crossings_s", r["timings"]["total_s"]) + r["timings"].get("frames_s", 0.0)) / r["exposures"] * 1e3 for r in mine)
        ratio = statistics.median(whole_s(r) / whole_s(o) for r, o in zip(mine, reports["streakcast"])) if "streakcast" in tools else float("nan")
        scaled = "" if count == len(rows) else f" (from {count})"
        print(f"| {mine[0]['name'] + scaled:42s} | {total_s:.3f} | {read_s:.3f} | {each_ms:.4f} | {statistics.median(r['peak_mb'] for r in mine):.0f} | {ratio:.1f} |")

    satellites, ids = read_catalogue(Path(options.elements))
    row_of = {row["exposure_id"]: row for row in rows}
    radius = np.radians(options.fov_deg / 2)
    found = {tool: {(str(e), int(n)) for e, n in mine[0]["crossings"]} for tool, mine in reports.items()}
    changing = [tool for tool, mine in reports.items() if any({(str(e), int(n)) for e, n in r["crossings"]} != found[tool] for r in mine)]
    if changing:
        print(f"\nnot the same crossings in every round: {', '.join(changing)}")
    print("\ncrossings: " + ", ".join(f"{tool} {len(pairs)} in {tools[tool][0]}" for tool, pairs in found.items()))
    seen_by = {tool: {row["exposure_id"] for row in rows[:count]} for tool, (count, _) in tools.items()}
    wrong = {tool: 0 for tool in tools}
    for exposure_id, norad in sorted(set().union(*found.values())):
        tools_run = [tool for tool in tools if exposure_id in seen_by[tool]]
        yes = [tool for tool in tools_run if (exposure_id, norad) in found[tool]]
        if len(yes) == len(tools_run):
            continue
        row = row_of[exposure_id]
        exposure = Exposure(frames, row["start_utc"], float(row["duration_s"]), float(row["ra_deg"]), float(row["dec_deg"]))
        least = [exposure.chords(satellites[i])[1] for i in np.flatnonzero(ids == norad)]
        edge = [(value - radius) * 180 / np.pi * 3600 for value in least]
        crosses = any(value <= 0 for value in edge)
        grazing = min(map(abs, edge), default=float("nan")) <= options.graze_arcsec
        # Years after its epoch, SGP4 may return invalid positions without an error.
        jd, fraction = utc_to_jd(row["start_utc"])
        # The velocity may look valid, but positions a second apart do not.
        steps = [[np.array(satellites[i].sgp4(jd, fraction + t / DAY_S)[1]) for t in (0.0, 1.0)] for i in np.flatnonzero(ids == norad)]
        speeds_km_s = [float(np.linalg.norm(there - here)) for here, there in steps]
        nonsense = any(not speed <= ESCAPE_KM_S for speed in speeds_km_s)
        verdict = f"no orbit ({max(speeds_km_s):.0f} km/s)" if nonsense else "grazing" if grazing else "REAL"
        if verdict == "REAL":
            for tool in tools_run:
                wrong[tool] += (tool in yes) != crosses
        named = [tool for tool, mine in reports.items() if norad in mine[0].get("left_out", [])]
        records = f" ({', '.join(named)} names it as left out)" if named else ""
        records += f" ({len(least)} records in the catalogue)" if len(least) > 1 else ""
        print(f"  {exposure_id} {norad}: found by {', '.join(yes)}, not by {', '.join(t for t in tools_run if t not in yes)}; closest approach "
              f"{', '.join(f'{value:+.1f}' for value in edge)} arcsec from the edge{records}: {verdict}")  # fmt: skip
    print("real differences against the truth: " + ", ".join(f"{tool} {count}" for tool, count in wrong.items()))
    folder.cleanup()
    sys.exit(1 if wrong.get("streakcast") else 0)


if __name__ == "__main__":
    main()
