"""Writes noisy points of a known two-panel satellite, and results of SciPy and emcee for them.

    venv/bin/pip install numpy==2.4.3 scipy==1.17.1 emcee==3.1.6 astropy==7.2.0
    venv/bin/python tests/reference/make_fit_goldens.py tests/data/fit_golden.csv

Writes 1,200 points and, in the lines before them: the lowest cost reached by SciPy from a grid of starts (squares and
soft_l1) with its parameters; means and covariance of emcee's draws from the same likelihood; and autocorrelation times
that emcee computes for a chain from an integer recurrence. Takes some minutes. `--points N FILE` only writes N points,
for benchmarks.
"""
import datetime
import json
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from model_magnitudes import basis, columns, magnitude  # noqa: E402

SHAPE = (8.1, 2.8, 1.3, 2.8)
TRUTH = np.array([0.02, 0.004, 0.006, 0.35, 0.09, 6.0, 18.0])
LEAST, GREATEST = np.array([0] * 5 + [0.5, 0.5]), np.array([1] * 5 + [200.0, 200.0])


def points(n, rng):
    """Returns directions as observed by a ground station, and magnitudes with errors of 0.1 to 0.3 mag."""
    ds, a = np.radians(rng.uniform(-22, -8, 3 * n)), rng.uniform(0, np.pi, 3 * n)
    do = np.radians(-rng.uniform(25, 85, 3 * n))
    g = basis(SHAPE, ds, a, do)
    lit = np.flatnonzero(sum(x for x in g[:3]) > 1e-3)[:n]
    sigma = rng.uniform(0.1, 0.3, n)
    m = magnitude(tuple(x[lit] for x in g), TRUTH) + sigma * rng.standard_normal(n)
    # Values are rounded as in the file.
    return [np.round(x, 7) for x in (np.degrees(ds[lit]), np.degrees(a[lit]), np.degrees(do[lit]), m, sigma)]


def geometry(p):
    return basis(SHAPE, *(np.radians(x) for x in p[:3]))


def write(path, p, head):
    with open(path, "w") as f:
        for line in head:
            f.write(f"# {line}\n")
        f.write("sun_latitude_deg,observer_longitude_deg,observer_latitude_deg,standard_magnitude,sigma_mag\n")
        for row in zip(*p):
            f.write(",".join(f"{x:.7f}" for x in row) + "\n")


def jacobian(g, p):
    """Returns the derivatives of the magnitudes by the seven parameters."""
    c = columns(g, p[5], p[6])
    b = np.maximum(np.asarray(p[:5]) @ c, 1e-9)
    slope = lambda k, n, cosine: np.where(cosine > 0, p[k] * c[k] * (1 / (n + 2) + np.log(np.maximum(cosine, 1e-300))), 0)
    d = np.vstack([c, slope(0, p[5], g[3]), slope(3, p[6], g[4])])
    return (-2.5 / np.log(10) * d / b).T


def solve(g, m, s, loss, start):
    from scipy.optimize import least_squares
    return least_squares(lambda p: (m - magnitude(g, p)) / s, start, jac=lambda p: -jacobian(g, p) / s[:, None], bounds=(LEAST, GREATEST),
                         x_scale=[0.01] * 5 + [5, 10], loss=loss, ftol=1e-15, xtol=1e-15, gtol=1e-15)


def recurrence(n_step, n_walker):
    """Returns a chain x' = 0.9 x + u with u from a 31-bit congruential generator, which the test reproduces exactly."""
    state, x, out = 12345, np.zeros(n_walker), np.empty((n_step, n_walker))
    for t in range(n_step):
        for k in range(n_walker):
            state = (1103515245 * state + 12345) % 2**31
            x[k] = 0.9 * x[k] + state / 2**31 - 0.5
        out[t] = x
    return out


def golden(path):
    import emcee
    import scipy
    rng = np.random.default_rng(20260521)
    p = points(1200, rng)
    g, m, s = geometry(p), p[3], p[4]
    found = {}
    for loss in ("linear", "soft_l1"):
        starts = [[0.05, 0.01, 0.01, 0.2, 0.1, a, b] for a in (1.5, 6, 30) for b in (4, 18, 70)]
        best = min((solve(g, m, s, loss, x) for x in starts), key=lambda r: r.cost)
        found[loss] = best
    centre = found["linear"].x

    def log_probability(x):
        if np.any(x < LEAST) or np.any(x > GREATEST):
            return -np.inf
        return -0.5 * np.sum(((m - magnitude(g, x)) / s) ** 2)

    sampler = emcee.EnsembleSampler(32, 7, log_probability)
    np.random.seed(7)
    begin = np.clip(centre * (1 + 0.01 * np.random.randn(32, 7)), LEAST + 1e-9, GREATEST - 1e-9)
    sampler.run_mcmc(begin, 30000)
    flat = sampler.get_chain(discard=2000, flat=True)
    tau = emcee.autocorr.integrated_time(recurrence(20000, 4)[:, :, None], c=5)
    numbers = lambda x: json.dumps([float(v) for v in np.ravel(x)])
    head = [
        f"scipy {scipy.__version__}, emcee {emcee.__version__}, numpy {np.__version__}; tests/reference/make_fit_goldens.py; {datetime.date.today()}",
        f"truth {numbers(TRUTH)}",
        f"scipy_linear_cost {found['linear'].cost!r}",
        f"scipy_linear_x {numbers(found['linear'].x)}",
        f"scipy_soft_l1_cost {found['soft_l1'].cost!r}",
        f"emcee_mean {numbers(flat.mean(axis=0))}",
        f"emcee_covariance {numbers(np.cov(flat.T))}",
        f"emcee_tau {numbers(sampler.get_autocorr_time(discard=2000, quiet=True))}",
        f"emcee_recurrence_tau {numbers(tau)}",
    ]
    write(path, p, [line.replace("np.float64(", "").rstrip(")") if "cost" in line else line for line in head])


if __name__ == "__main__":
    if sys.argv[1] == "--points":
        write(sys.argv[3], points(int(sys.argv[2]), np.random.default_rng(1)), ["points for benchmarks"])
    else:
        golden(sys.argv[1])
