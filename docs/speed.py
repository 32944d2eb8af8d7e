"""Runs the benches, also with other programs, and writes their output into docs/tables/speed.md.

`docs/tables.sh speed [--only NAME,...]` calls this script. Each section has the command, date, machine and output of one
run. With `--only` the other sections are not changed.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "docs" / "tables" / "speed.md"
PEERS = Path("tests/benches/peers")
DATA = Path(os.environ.get("STREAKCAST_DATA", ROOT.parent / "shared" / "data"))
ACTIVE = DATA / "tle" / "active" / "active_2026-04-25.txt"

#: Benches of this crate alone.
BENCHES = ["night", "catalogue", "frames", "magnitudes", "photometry", "maps", "reduce", "frame_files", "streaks",
           "measure"]
#: Comparisons with other programs: name -> (requirements in PEERS, benches to build first, command line).
WITH_PEERS = {
    "compare-peers": ("requirements.txt", ["peers"], ["compare.py", "--elements", "{active}", "--schedule", "{schedule}", "--only", "astroz=0,sgp4=100", "--rounds",
                                                      "{rounds}", "--streakcast", "cargo bench -q --bench peers -- {{elements}} {{schedule}} {{fov_deg}} {{limit}}"]),
    "photometry-peers": ("requirements-photometry.txt", ["magnitudes", "photometry"], ["photometry.py", "--rounds", "{rounds}"]),
    "fit-peers": ("requirements-fit.txt", ["fit"], ["fit.py", "--rounds", "{rounds}"]),
    "streaks-peers": ("requirements-streaks.txt", ["streaks"], ["streaks.py", "--rounds", "{rounds}"]),
}  # fmt: skip
NAMES = BENCHES + list(WITH_PEERS)


def run(command):
    """Returns the standard output of a command; its standard error is not captured."""
    return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def interpreter(requirements):
    """Returns the Python of an environment with these requirements, or `None` if pip cannot install them.

    The environment is in the target folder and is created again if the requirements change.
    """
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    folder = target / "peers" / Path(requirements).stem
    required, done = (ROOT / PEERS / requirements).read_text(), folder / "installed.txt"
    python = folder / "bin" / "python"
    if done.exists() and done.read_text() == required:
        return python
    try:
        subprocess.run([os.environ.get("PYTHON", sys.executable), "-m", "venv", "--clear", folder], check=True)
        # Files that mention --no-deps list all packages, because pip would install older releases as dependencies.
        flags = ["--no-deps"] if "--no-deps" in required else []
        subprocess.run([python, "-m", "pip", "install", "--quiet", *flags, "--requirement", ROOT / PEERS / requirements], check=True)
    except subprocess.CalledProcessError as error:
        print(f"*** LEFT OUT: pip cannot install {requirements}: {error} ***", file=sys.stderr)
        return None
    done.write_text(required)
    return python


def printed(name, rounds):
    """Returns the command and its output; `None` if it cannot run."""
    if name in BENCHES:
        return f"cargo bench --bench {name}", run(["cargo", "bench", "--quiet", "--bench", name])
    requirements, benches, words = WITH_PEERS[name]
    if name == "compare-peers" and not ACTIVE.is_file():
        print(f"*** LEFT OUT: {name} needs {ACTIVE} (STREAKCAST_DATA) ***", file=sys.stderr)
        return None
    python = interpreter(requirements)
    if python is None:
        return None
    for bench in benches:
        run(["cargo", "bench", "--quiet", "--bench", bench, "--no-run"])
    with tempfile.TemporaryDirectory() as folder:
        schedule = f"{folder}/schedule.csv"
        if name == "compare-peers":
            run([python, "tests/reference/make_bench_exposures.py", schedule])
        words = [word.format(active=ACTIVE, schedule=schedule, rounds=rounds) for word in words]
        return f"{PEERS / words[0]}, {rounds} rounds", run([python, PEERS / words[0], *words[1:]])


def machine():
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        text = ""
    model = re.search(r"^model name\s*: (.*)$", text, re.M)
    return f"{os.cpu_count()} cores{' of ' + model[1].strip() if model else ''}"


def section(name, command, text):
    """Returns a section of the file: heading, command, date, machine, and the output unchanged."""
    lines = "\n".join(line.rstrip() for line in text.strip("\n").splitlines())
    today = f"{date.today():%-d %B %Y}"
    return f"## {name}\n\n`{command}`, {today}, {machine()}:\n\n```text\n{lines}\n```\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", help=f"runs, separated by commas: {','.join(NAMES)}; default: all")
    parser.add_argument("--rounds", type=int, default=3, help="rounds of the comparisons with other programs")
    options = parser.parse_args()
    selected = options.only.split(",") if options.only else NAMES
    unknown = [name for name in selected if name not in NAMES]
    if unknown:
        parser.error(f"unknown run {', '.join(unknown)}; allowed: {', '.join(NAMES)}")
    old = re.split(r"^(?=## )", TABLE.read_text(), flags=re.M) if TABLE.exists() else []
    sections = {part[3:].splitlines()[0]: part for part in old if part.startswith("## ")}
    left_out = []
    for name in selected:
        try:
            output = printed(name, options.rounds)
        except subprocess.CalledProcessError as error:
            print(f"{error.stdout or ''}*** LEFT OUT: {name}: {error} ***", file=sys.stderr)
            output = None
        if output is None:
            left_out.append(name)
            continue
        # The file is written after each run, because a later run may fail.
        sections[name] = section(name, *output)
        new = TABLE.with_suffix(".new")
        new.write_text("\n".join(sections[name].strip() + "\n" for name in NAMES if name in sections))
        new.replace(TABLE)
    if left_out:
        sys.exit(f"left out: {', '.join(left_out)}")


main()
