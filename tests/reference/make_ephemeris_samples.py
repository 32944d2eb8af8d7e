"""Writes ephemerides of an invented satellite in three formats, with exact positions between their states.

Run from the root of the project:  python tests/reference/make_ephemeris_samples.py
Requires astropy, numpy and scipy (requirements.txt). Writes tests/data/ephemerides.

An orbit at 550 km is integrated numerically (DOP853, central force and J2) in GCRS. States every minute are written in
three frames and time systems. The golden positions are those of the integration at other times, so that reading, frames
and interpolation are tested with an independent computation.
"""

import gzip
import pathlib

import erfa
import numpy as np
from astropy import units as u
from astropy.coordinates import GCRS, ITRS, CartesianDifferential, CartesianRepresentation
from astropy.time import Time, TimeDelta
from astropy.utils import iers
from scipy.integrate import solve_ivp

FOLDER = pathlib.Path("tests/data/ephemerides")
START = Time("2024-08-14T00:00:00", scale="utc")
STEP_S, COUNT = 60.0, 91
GM_KM3_S2, RADIUS_KM, J2 = 398600.4418, 6378.137, 1.08262668e-3


def acceleration(_, state):
    """Returns the acceleration by the central force and J2, with the pole along the z axis of GCRS."""
    x, y, z = state[:3]
    r2 = x * x + y * y + z * z
    factor = 1.5 * J2 * (RADIUS_KM**2 / r2)
    bulge = np.array([1 - 5 * z * z / r2, 1 - 5 * z * z / r2, 3 - 5 * z * z / r2]) * factor
    return np.concatenate([state[3:], -GM_KM3_S2 / r2**1.5 * state[:3] * (1 + bulge)])


def covariance(time_s):
    """Returns the lower triangle of a covariance in UVW: radial 20 m, along 0.1 to 2 km, normal 50 m, correlated."""
    sigma = np.array([0.02, 0.1 + 1.9 * time_s / 5400.0, 0.05, 1e-5, 2e-5, 1e-5])
    correlation = np.eye(6)
    correlation[0, 1] = correlation[1, 0] = -0.4
    correlation[3, 1] = correlation[1, 3] = -0.3
    return (correlation * np.outer(sigma, sigma))[np.tril_indices(6)]


def main():
    iers.conf.auto_download = False
    FOLDER.mkdir(parents=True, exist_ok=True)
    a, inclination = 6928.0, np.radians(53.0)
    speed = np.sqrt(GM_KM3_S2 / a)
    first = np.array([a, 0, 0, 0, speed * np.cos(inclination), speed * np.sin(inclination)])
    times_s = STEP_S * np.arange(COUNT)
    golden_s = np.array([7.3, 31.0, 89.5, 90.0, 1234.5, 2700.0, 4321.9, 5310.25, 5399.0])
    every = np.union1d(times_s, golden_s)
    options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-10, "t_eval": every}
    solution = solve_ivp(acceleration, (0, every[-1]), first, **options).y.T
    at = {time_s: state for time_s, state in zip(every, solution)}
    states = np.array([at[time_s] for time_s in times_s])
    epochs = START + TimeDelta(times_s, format="sec")

    # Modified ITC: mean equator and equinox of J2000 (the frame bias of erfa), UTC.
    bias = erfa.bp06(2451545.0, 0.0)[0]
    lines = [
        "created:2024-08-13 23:30:00 UTC",
        f"ephemeris_start:2024-08-14 00:00:00 UTC ephemeris_stop:{epochs[-1].strftime('%Y-%m-%d %H:%M:%S')} UTC step_size:60",
        "ephemeris_source:invented",
        "UVW",
    ]
    for epoch, time_s, state in zip(epochs, times_s, states):
        position, velocity = bias @ state[:3], bias @ state[3:]
        numbers = " ".join(f"{value:.10f}" for value in (*position, *velocity))
        lines.append(f"{epoch.strftime('%Y%j%H%M%S')}.000 {numbers}")
        terms = [f"{term:.10e}" for term in covariance(time_s)]
        lines.extend(" ".join(terms[row : row + 7]) for row in (0, 7, 14))
    text = "\n".join(lines) + "\n"
    name = "MEME_90001_INVENTED-1_2270000_Operational_1407628800_UNCLASSIFIED.txt.gz"
    (FOLDER / name).write_bytes(gzip.compress(text.encode(), mtime=0))

    # OEM as KVN: GCRF, TAI, two covariances in orbit axes.
    tai = epochs.tai
    meta = f"""CCSDS_OEM_VERS = 2.0
COMMENT An invented satellite, by make_ephemeris_samples.py.
CREATION_DATE = 2024-08-13T23:30:00
ORIGINATOR = STREAKCAST

META_START
OBJECT_NAME = INVENTED-1
OBJECT_ID = 2026-001-A
CENTER_NAME = EARTH
REF_FRAME = GCRF
TIME_SYSTEM = TAI
START_TIME = {tai[0].isot}
STOP_TIME = {tai[-1].isot}
INTERPOLATION = HERMITE
INTERPOLATION_DEGREE = 7
META_STOP
"""
    body = [
        f"{epoch.isot} " + " ".join(f"{value:.9f}" for value in state) for epoch, state in zip(tai, states)
    ]
    body.append("\nCOVARIANCE_START")
    for index in (0, COUNT - 1):
        body.append(f"EPOCH = {tai[index].isot}\nCOV_REF_FRAME = RTN")
        terms = [f"{term:.10e}" for term in covariance(times_s[index])]
        body.extend(" ".join(terms[row * (row + 1) // 2 : (row + 1) * (row + 2) // 2]) for row in range(6))
    body.append("COVARIANCE_STOP")
    (FOLDER / "invented.oem").write_text(meta + "\n" + "\n".join(body) + "\n")

    # OEM as XML: Earth-fixed, UTC, no covariance. Only every second state is written, to test longer steps.
    gcrs = GCRS(
        CartesianRepresentation(*states[:, :3].T * u.km, differentials=CartesianDifferential(*states[:, 3:].T * u.km / u.s)),
        obstime=epochs,
    )
    itrs = gcrs.transform_to(ITRS(obstime=epochs))
    position = itrs.cartesian.without_differentials().xyz.to_value(u.km).T
    velocity = itrs.cartesian.differentials["s"].d_xyz.to_value(u.km / u.s).T
    vectors = []
    for epoch, r, v in list(zip(epochs, position, velocity))[::2]:
        tags = zip(("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT"), (*r, *v))
        vectors.append(
            f"<stateVector><EPOCH>{epoch.isot}</EPOCH>" + "".join(f"<{t}>{x:.9f}</{t}>" for t, x in tags) + "</stateVector>"
        )
    xml = f"""<?xml version="1.0" encoding="UTF-8"?>
<oem id="CCSDS_OEM_VERS" version="2.0">
<header><CREATION_DATE>2024-08-13T23:30:00</CREATION_DATE><ORIGINATOR>STREAKCAST</ORIGINATOR></header>
<body><segment>
<metadata><OBJECT_NAME>INVENTED-1</OBJECT_NAME><OBJECT_ID>2026-001A</OBJECT_ID><CENTER_NAME>EARTH</CENTER_NAME>
<REF_FRAME>ITRF2014</REF_FRAME><TIME_SYSTEM>UTC</TIME_SYSTEM>
<START_TIME>{epochs[0].isot}</START_TIME><STOP_TIME>{epochs[-1].isot}</STOP_TIME></metadata>
<data>
""" + "\n".join(vectors) + "\n</data>\n</segment></body>\n</oem>\n"
    (FOLDER / "invented_itrf.xml").write_text(xml)

    golden = [
        "# Positions in GCRS by numerical integration, and sigmas by the formulas of make_ephemeris_samples.py",
        f"# (scipy DOP853, erfa {erfa.__version__}); start 2024-08-14T00:00:00 UTC.",
        "time_s,x_km,y_km,z_km,along_sigma_km",
    ]
    for time_s in golden_s:
        # The variance is interpolated linearly between the states.
        before, after = STEP_S * np.floor(time_s / STEP_S), STEP_S * np.floor(time_s / STEP_S) + STEP_S
        share = (time_s - before) / STEP_S
        variance = (1 - share) * covariance(before)[2] + share * covariance(after)[2]
        x, y, z = at[time_s][:3]
        golden.append(f"{time_s},{x:.9f},{y:.9f},{z:.9f},{np.sqrt(variance):.9f}")
    (FOLDER / "golden.csv").write_text("\n".join(golden) + "\n")


if __name__ == "__main__":
    main()
