"""Provisional two-panel models (Lu 2024) of V2 mini, VisorSat and OneWeb: least squares on public photometry.

Geometry on a spherical Earth. Slingshot rows hold Sun, satellite and azimuth; MMT-9 rows hold time, distance and phase, from which the
body-frame angles follow with a circular orbit of the shell's radius, up to the mirror image, which the model does not tell apart. Every
track (MMT-9) or degree of the Sun's altitude (Slingshot) weighs the same however many points it has, up to the square root. Held-out
numbers leave out a fifth of the tracks at a time.

    venv/bin/pip install numpy scipy astropy
    venv/bin/python tests/reference/fit_provisional_models.py DATA_FOLDER

Prints coefficients and figures; the model files in src/photometry/models carry them. With `shipped` after the folder it fits nothing and
prints number, mean, RMS and core of the residuals about the shipped files, which tests/model_validation.rs is held against.
"""
import csv
import gzip
import json
import pathlib
import sys

import numpy as np
from astropy.coordinates import EarthLocation, get_sun
from astropy.time import Time
from scipy.optimize import least_squares, nnls

M_SUN = -26.76
D2 = 1e12
EARTH_KM = 6378.137


def overlap(reach, flat, slope, height):
    """Integral of clamp(reach - slope v, 0, flat) over 0..height."""
    slope = np.maximum(slope, 1e-12)
    full = np.clip((reach - flat) / slope, 0, height)
    end = np.clip(reach / slope, full, height)
    last = np.maximum(reach - slope * end, 0)
    return flat * full + 0.5 * (flat + last) * (end - full)


def basis(shape, ds, a, do):
    """Geometry of the five terms: cosines times area times what is not blocked, and cosines of the mirror angles."""
    l_sail, w_sail, l_base, w_base = shape
    sun = np.stack([np.cos(ds), 0 * ds, np.sin(ds)])
    obs = np.stack([np.cos(do) * np.cos(a), np.cos(do) * np.sin(a), np.sin(do)])
    narrow = min(w_sail, w_base)

    def cast(d):
        on = (d[2] < 0) & (d[0] > 0)
        h = np.where(on, np.minimum(l_base * -d[2] / np.where(on, d[0], 1), l_sail), 0)
        return h, np.where(on, np.abs(d[1] / np.where(on, d[2], 1)), 0)

    hs, _ = cast(sun)
    hv, shear = cast(obs)
    view = overlap(0.5 * (w_sail + w_base), narrow, shear, hv)
    both = overlap(0.5 * (narrow + w_base), narrow, shear, np.minimum(hs, hv))
    area = l_sail * w_sail
    bf, bf_sun = (narrow * hs + view - both) / area, narrow * hs / area
    ci, co = sun[0], obs[0]
    sail = np.maximum(ci, 0) * np.maximum(co, 0) * area * (1 - bf)
    back = np.maximum(ci, 0) * np.maximum(-co, 0) * area * (1 - bf_sun)
    bi, bo = -sun[2], -obs[2]
    base = np.maximum(bi, 0) * np.maximum(bo, 0) * l_base * w_base
    dot = (sun * obs).sum(0)
    return sail, back, base, np.maximum(2 * ci * co - dot, 0), np.maximum(2 * bi * bo - dot, 0)


def columns(g, n_sail, n_base):
    sail, back, base, ms, mb = g
    return np.stack([
        (n_sail + 2) / (2 * np.pi) * ms**n_sail * sail, sail / np.pi, back / np.pi,
        (n_base + 2) / (2 * np.pi) * mb**n_base * base, base / np.pi,
    ])


def magnitude(g, p):
    b = np.asarray(p[:5]) @ columns(g, p[5], p[6])
    return -2.5 * np.log10(np.maximum(b, 1e-9) / D2) + M_SUN


def fit(g, m, w):
    """Multi-start over the exponents with the linear coefficients solved inside, then all seven together with a robust loss."""
    flux = 10 ** (-0.4 * (m - M_SUN)) * D2
    best = None
    for n_sail in (2, 10, 40):
        for n_base in (5, 20, 60):
            c, _ = nnls((columns(g, n_sail, n_base) / flux * w).T, w)
            start = np.clip([*c, n_sail, n_base], [1e-5] * 5 + [0.5, 0.5], [0.99] * 5 + [199, 199])
            got = least_squares(lambda p: w * (m - magnitude(g, p)), start, bounds=([0] * 5 + [0.5, 0.5], [1] * 5 + [200, 200]),
                                x_scale=[0.01] * 5 + [5, 10], loss="soft_l1", f_scale=0.5)
            if best is None or got.cost < best.cost:
                best = got
    return best.x


def report(name, shape, m, ds, a, do, group):
    g = basis(shape, ds, a, do)
    lit = sum(x for x in g[:3]) > 1e-6
    g = tuple(x[lit] for x in g)
    m, group = m[lit], group[lit]
    _, place, count = np.unique(group, return_inverse=True, return_counts=True)
    w = count[place] ** -0.25
    w /= np.sqrt(np.mean(w**2))
    p = fit(g, m, w)
    r = m - magnitude(g, p)
    rng = np.random.default_rng(1)
    fold = rng.permutation(len(count))[place] % 5
    held = np.empty_like(m)
    phase = np.degrees(np.arccos(np.clip(np.cos(ds) * np.cos(do) * np.cos(a) + np.sin(ds) * np.sin(do), -1, 1)))[lit]
    poly = np.empty_like(m)
    for k in range(5):
        inside = fold != k
        held[~inside] = m[~inside] - magnitude(tuple(x[~inside] for x in g), fit(tuple(x[inside] for x in g), m[inside], w[inside]))
        q = np.polyfit(phase[inside], m[inside], 2, w=w[inside])
        poly[~inside] = m[~inside] - np.polyval(q, phase[~inside])
    mad = lambda x: 1.4826 * np.median(np.abs(x - np.median(x)))
    print(f"{name}: n {len(m)} of {len(lit)}, groups {len(count)}")
    print("  c1..c5 n_sail n_base", " ".join(f"{x:.5g}" for x in p))
    print(f"  in sample: rms {np.sqrt(np.mean(r**2)):.3f} mad {mad(r):.3f} mean {r.mean():+.3f}; "
          f"held out: rms {np.sqrt(np.mean(held**2)):.3f} mad {mad(held):.3f}; "
          f"quadratic in phase held out: rms {np.sqrt(np.mean(poly**2)):.3f}")
    for label, x in (("sun", np.degrees(ds[lit])), ("observer", np.degrees(do[lit])), ("phase", phase)):
        print(f"  {label} latitude or angle, 0.5 to 99.5 %: {np.percentile(x, 0.5):.0f} {np.percentile(x, 99.5):.0f}")


def slingshot(data):
    rows = list(csv.DictReader(open(f"{data}/photometry/slingshot_v2/Observations_in_field.csv")))
    col = lambda k: np.array([float(r[k]) for r in rows])
    sun, alt, h, m, az = np.radians(col("sun altitude")), np.radians(col("sat altitude")), col("sat height") / 1e3, col("measured_ab"), np.radians(col("az diff"))
    site = np.array([6371.0, 0, 0])[:, None]
    sight = np.stack([np.sin(alt), np.cos(alt) * np.cos(az), np.cos(alt) * np.sin(az)])
    d = -site[0] * sight[0] + np.sqrt((site[0] * sight[0]) ** 2 + (6371 + h) ** 2 - 6371**2)
    sat = site + d * sight
    s = np.stack([np.sin(sun), np.cos(sun), 0 * sun])
    z = sat / np.linalg.norm(sat, axis=0)
    ds, do = np.arcsin((s * z).sum(0)), np.arcsin((-sight * z).sum(0))
    a = np.arccos(np.clip(((s * -sight).sum(0) - np.sin(ds) * np.sin(do)) / np.cos(ds) / np.cos(do), -1, 1))
    return m - 5 * np.log10(d / 1000), ds, a, do, np.round(np.degrees(sun))


def mmt(data, file, radius_km):
    rows = [r for r in csv.DictReader(gzip.open(f"{data}/derived/{file}", "rt")) if r["Filter"] == "Clear" and r["Penumbra"] == "0"]
    col = lambda k: np.array([float(r[k]) for r in rows])
    t = Time([r["Date"] for r in rows])
    site = EarthLocation.from_geodetic(41.431472, 43.649861, 2030)
    rho = site.get_gcrs(t).cartesian.xyz.to_value("km")
    s = get_sun(t).cartesian.xyz
    s = (s / np.linalg.norm(s, axis=0)).value
    d, phi, mag = col("Distance"), np.radians(col("Phase")), col("Mag")
    # sin d_obs = -(R^2 + d^2 - rho^2)/(2 R d), sin d_sun = (rho . s - d cos phi)/R
    sin_o = -(radius_km**2 + d**2 - (rho**2).sum(0)) / (2 * radius_km * d)
    sin_s = ((rho * s).sum(0) - d * np.cos(phi)) / radius_km
    do, ds = np.arcsin(np.clip(sin_o, -1, 1)), np.arcsin(np.clip(sin_s, -1, 1))
    cos_a = (np.cos(phi) - np.sin(ds) * np.sin(do)) / (np.cos(ds) * np.cos(do))
    keep = (np.abs(cos_a) < 1.05) & (do > np.radians(-85)) & (np.abs(sin_o) < 1)
    a = np.arccos(np.clip(cos_a, -1, 1))
    return tuple(x[keep] for x in (mag - 5 * np.log10(d / 1000), ds, a, do, np.array([r["Track"] for r in rows])))


def shipped(name, shape, m, ds, a, do, group):
    """Residuals about the coefficients of the shipped file."""
    models = pathlib.Path(__file__).parents[2] / "src/photometry/models"
    c = json.load(open(models / f"{name}.json"))["coefficients"]
    g = basis(shape, ds, a, do)
    lit = sum(x for x in g[:3]) > 1e-6
    r = (m - magnitude(g, [c[k] for k in ("c1", "c2", "c3", "c4", "c5", "n_sail", "n_base")]))[lit]
    core = 1.4826 * np.median(np.abs(r - np.median(r)))
    print(f"{name}: n {len(r)} mean {r.mean():+.3f} rms {np.sqrt(np.mean(r**2)):.3f} core {core:.3f}")


if __name__ == "__main__":
    data = sys.argv[1]
    answer = shipped if sys.argv[2:] == ["shipped"] else report
    answer("v2mini-panels", (12.8, 8.2, 2.7, 4.1), *slingshot(data))
    answer("visorsat-panels", (8.1, 2.8, 1.3, 2.8), *mmt(data, "mmt9_starlink_visorsat.csv.gz", EARTH_KM + 550))
    answer("oneweb-panels", (3.0, 1.6, 1.0, 1.0), *mmt(data, "mmt9_oneweb.csv.gz", EARTH_KM + 1200))
