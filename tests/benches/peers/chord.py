"""Crossings of a circular field by satellites for Python propagators: chords between positions at a few times.

A propagator gives TEME positions of all objects at four times of an exposure. A satellite crosses if a great circle
between its lines of sight at successive times passes the centre of the field within its radius. Directions are ICRS
astrometric topocentric, as in streakcast (and in a plate solution): r_sat - r_site - (v_sat + v_Earth) tau, so that
aberration (20 arcsec at the edge of the field) causes no differences. Frames are computed with ERFA by
tests/reference/sky_frames.py, once per exposure.

The great circle neglects the curvature of the track within 10 s, up to about an arcminute for the nearest objects.
`compare.py` treats such grazing cases separately.
"""

import csv
import json
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "reference"))
from sky_frames import DAY_S, SPEED_OF_LIGHT_KM_S, Frames, radec_to_vector, utc_to_jd  # noqa: E402

SAMPLES = 4
EARTH_TURNS_RAD_S = 7.292115855e-5
# Half of the time between samples of 30 s, at the largest speed of an object in a bound orbit relative to the site.
FASTEST_KM_S = 11.7


def read_schedule(path, limit):
    with open(path) as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return rows[: limit or None]


def read_pairs(path):
    """Returns (name, line 1, line 2) of every record."""
    lines = Path(path).read_text().splitlines()
    return [(a, b) for a, b in zip(lines, lines[1:]) if a.startswith("1 ") and b.startswith("2 ")]


class Views:
    """Frames of all exposures, computed at once: field centre, site and the Earth's velocity in TEME."""

    def __init__(self, rows, frames):
        jd, fraction = np.array([utc_to_jd(row["start_utc"]) for row in rows]).T
        self.duration_s = np.array([float(row["duration_s"]) for row in rows])
        middle = fraction + self.duration_s / 2 / DAY_S
        teme_to_gcrs, itrs_to_gcrs, earth_km_s = frames.at(jd, middle)
        centre = np.array([radec_to_vector(float(row["ra_deg"]), float(row["dec_deg"])) for row in rows])
        self.jd, self.fraction = jd, fraction
        self.centre = np.einsum("nji,nj->ni", teme_to_gcrs, centre)
        self.earth_km_s = np.einsum("nji,nj->ni", teme_to_gcrs, earth_km_s)
        self.site_km = np.einsum("nji,njk,k->ni", teme_to_gcrs, itrs_to_gcrs, frames.site_itrs_km)

    def samples(self, i):
        """Seconds after the start, Julian date, fractions of a day, and the site at those times (n_time, 3)."""
        seconds = np.linspace(0.0, self.duration_s[i], SAMPLES)
        angle = EARTH_TURNS_RAD_S * (seconds - self.duration_s[i] / 2)
        x, y, z = self.site_km[i]
        cos, sin = np.cos(angle), np.sin(angle)
        site = np.stack([cos * x - sin * y, sin * x + cos * y, np.full(SAMPLES, z)], axis=1)
        return seconds, self.jd[i], self.fraction[i] + seconds / DAY_S, site


def crossing(position_km, velocity_km_s, site_km, seconds, centre, earth_km_s, radius_rad):
    """Returns the indices of the objects that cross the field.

    `position_km` (n_time, n_object, 3), `velocity_km_s` of the same shape, or None to derive it from the positions, and
    `site_km` (n_time, 3) are TEME. Objects with NaN positions do not cross.
    """
    # Candidates: closer to the line of sight than the field radius plus the path between two samples.
    along = position_km @ centre - (site_km @ centre)[:, None]
    square = (
        np.einsum("tni,tni->tn", position_km, position_km)
        - 2.0 * np.matmul(position_km, site_km[:, :, None])[:, :, 0]
        + np.einsum("ti,ti->t", site_km, site_km)[:, None]
    )
    reach = np.tan(radius_rad + 2e-4) * along + FASTEST_KM_S * (seconds[1] - seconds[0]) / 2
    near = np.flatnonzero(((along > 0) & (square - along**2 < reach**2)).any(axis=0))
    if not len(near):
        return near
    # Exact test of the candidates.
    position = position_km[:, near]
    if velocity_km_s is None:
        velocity = np.gradient(position, seconds, axis=0)
    else:
        velocity = velocity_km_s[:, near]
    line = position - site_km[:, None]
    tau = np.linalg.norm(line, axis=2, keepdims=True) / SPEED_OF_LIGHT_KM_S
    line = line - (velocity + earth_km_s) * tau
    line /= np.linalg.norm(line, axis=2, keepdims=True)
    first, second = line[:-1], line[1:]
    normal = np.cross(first, second)
    between = (np.cross(normal, first) @ centre >= 0) & (np.cross(second, normal) @ centre >= 0)
    off = np.arcsin(np.minimum(np.abs(normal @ centre) / np.linalg.norm(normal, axis=2), 1.0))
    ends = 2 * np.arcsin(np.minimum(np.linalg.norm(line - centre, axis=2) / 2, 1.0))
    least = np.minimum(np.where(between, off, np.inf), np.minimum(ends[:-1], ends[1:])).min(axis=0)
    return near[least <= radius_rad]


def run(name, load, propagate):
    """Measures a propagator and prints the result as JSON.

    `load(pairs)` prepares the objects and returns (state, ids). `propagate(state, jd, fractions)` returns positions
    (n_time, n_object, 3) and velocities or None. Imports are not included in the time.
    """
    elements, schedule, fov_deg, limit = sys.argv[1], sys.argv[2], float(sys.argv[3]), int(sys.argv[4])
    rows = read_schedule(schedule, limit)
    frames = Frames()  # reads finals2000A; not included in the time
    start = time.perf_counter()
    state, ids = load(read_pairs(elements))
    ready = time.perf_counter()
    views = Views(rows, frames)
    framed = time.perf_counter()
    crossings = []
    with np.errstate(invalid="ignore", divide="ignore"):
        for i, row in enumerate(rows):
            seconds, jd, fractions, site = views.samples(i)
            position, velocity = propagate(state, jd, fractions)
            found = crossing(position, velocity, site, seconds, views.centre[i], views.earth_km_s[i], np.radians(fov_deg / 2))
            crossings += [(row["exposure_id"], int(ids[k])) for k in found]
    end = time.perf_counter()
    timings = {"read_s": ready - start, "frames_s": framed - ready, "crossings_s": end - framed, "total_s": end - start}
    json.dump({"name": name, "exposures": len(rows), "timings": timings, "crossings": crossings}, sys.stdout)
