"""Compares a fit and posterior sampling of the two-panel form with SciPy and emcee, on the same 20,000 points.

    venv/bin/pip install -r tests/benches/peers/requirements-fit.txt
    cargo bench --bench fit --no-run
    venv/bin/python tests/benches/peers/fit.py [--rounds 3] [--threads 1]

Runs are interleaved because the speed of the machine varies. SciPy uses an analytic Jacobian and the same start; emcee
uses precomputed geometry, as streakcast does. Prints times, ratios, and whether both reach the same cost.
"""
import argparse
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")
import numpy as np  # noqa: E402

ROOT = pathlib.Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "tests/reference"))
import make_fit_goldens as peer  # noqa: E402
from model_magnitudes import magnitude  # noqa: E402

START = [0.05, 0.01, 0.01, 0.2, 0.1, 4.0, 12.0]


def streakcast(path, threads):
    out = subprocess.run(["cargo", "bench", "-q", "--bench", "fit", "--", path, "--steps", "200", "--threads", str(threads)], cwd=ROOT, check=True,
                         capture_output=True, text=True).stdout
    found = {}
    for line in out.splitlines():
        kind = "off" if "Off" in line else "earth"
        number = lambda pattern: float(re.search(pattern, line).group(1))
        found[kind] = (number(r"descent ([\d.]+) ms"), number(r"cost ([\d.]+)\);"), number(r"walkers ([\d.]+) ms"))
    return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    import emcee
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/points.csv"
        p = peer.points(20_000, np.random.default_rng(1))
        peer.write(path, p, ["points for benchmarks"])
        g, m, s = peer.geometry(p), p[3], p[4]

        def log_probability(x):
            if np.any(x < peer.LEAST) or np.any(x > peer.GREATEST):
                return -np.inf
            return -0.5 * np.sum(((m - magnitude(g, x)) / s) ** 2)

        rows = []
        for _ in range(options.rounds):
            mine = streakcast(path, options.threads)
            began = time.perf_counter()
            found = peer.solve(g, m, s, "linear", START)
            scipy_ms = (time.perf_counter() - began) * 1e3
            sampler = emcee.EnsembleSampler(32, 7, log_probability)
            begin = np.clip(found.x * (1 + 0.001 * np.random.default_rng(1).standard_normal((32, 7))), peer.LEAST + 1e-9, peer.GREATEST - 1e-9)
            sampler.run_mcmc(begin, 5)
            began = time.perf_counter()
            sampler.run_mcmc(None, 60)
            emcee_ms = (time.perf_counter() - began) * 1e3 / 60
            rows.append((*mine["off"], mine["earth"][2], scipy_ms, found.cost, emcee_ms))
            print("streakcast: descent %.3f ms (cost %.8f), step %.3f ms, with earthshine %.3f ms; scipy %.1f ms (cost %.8f, %d evaluations); "
                  "emcee %.2f ms a step" % (*rows[-1][:6], found.nfev, emcee_ms))
        column = lambda k: statistics.median(row[k] for row in rows)
        print("median ratios: least squares %.1f x SciPy, posterior %.1f x emcee; earthshine costs %.2f x; costs differ by %.1e"
              % (column(4) / column(0), column(6) / column(2), column(3) / column(2), abs(column(1) / column(5) - 1)))


if __name__ == "__main__":
    main()
