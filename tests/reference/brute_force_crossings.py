"""Computes crossings of fields by brute force: golden data for the crossing search.

Every object of `tle/active/active_2026-04-25.txt` is propagated through every exposure in steps of 1 s. For objects
that may have entered the field between two steps (they move by at most 6 km in half a step), steps of 0.05 s follow,
the smallest separation is refined by golden section, and entry and exit are found to 1e-6 s with SGP4. No index,
orbital planes or interpolation are used.

    STREAKCAST_DATA=... python tests/reference/brute_force_crossings.py tests/data/crossings_golden.csv
"""

import argparse
import datetime
import hashlib
import sys

import astropy
import numpy as np
import sgp4
from sgp4.api import WGS72, Satrec, SatrecArray

from sky_frames import (
    DATA, DAY_S, HEIGHT_M, LATITUDE_DEG, LONGITUDE_DEG,
    Frames, astrometric, jd_to_utc, radec_to_vector, separation, unit, utc_to_jd, vector_to_radec,
)  # fmt: skip

CATALOGUE = DATA / "tle/active/active_2026-04-25.txt"
DIAMETER_DEG = 3.5
RADIUS = np.radians(DIAMETER_DEG / 2)
# Largest speed of objects in bound orbits (11.2 km/s) relative to a site that rotates at 0.41 km/s.
FASTEST_KM_S = 12.0


def read_catalogue(path):
    """Reads satellites for SGP4 in AFSPC mode with WGS72, as in streakcast. Returns satellites and their ids."""
    lines = [line.rstrip() for line in path.read_text().splitlines()]
    satellites, ids = [], []
    for first, second in zip(lines, lines[1:]):
        if not (first.startswith("1 ") and second.startswith("2 ")):
            continue
        improved = Satrec.twoline2rv(first, second, WGS72)
        satellite = Satrec()
        epoch = improved.jdsatepoch - 2433281.5 + improved.jdsatepochF
        satellite.sgp4init(
            WGS72, "a", improved.satnum, epoch, improved.bstar, improved.ndot, improved.nddot,
            improved.ecco, improved.argpo, improved.inclo, improved.mo, improved.no_kozai, improved.nodeo,
        )  # fmt: skip
        # sgp4init takes a single number for the epoch; all digits of the file are restored here.
        satellite.jdsatepoch, satellite.jdsatepochF = improved.jdsatepoch, improved.jdsatepochF
        satellites.append(satellite)
        ids.append(improved.satnum)
    return satellites, np.array(ids)


def plan(frames, satellites):
    """Returns exposures (id, start, duration_s, ra_deg, dec_deg), start to 1 ms and angles to 1e-6 deg."""
    random = np.random.default_rng(20260425)
    rows = []

    def add(kind, start, duration, ra, dec):
        rows.append((f"{kind}-{len(rows):02d}", start, duration, round(ra % 360.0, 6) % 360.0, round(dec, 6)))

    def horizontal(kind, start, duration, altitude_deg, azimuth_deg):
        jd, fraction = utc_to_jd(start)
        _, itrs_to_gcrs, _ = frames.at(jd, fraction + duration / 2 / DAY_S)
        longitude, latitude = np.radians([LONGITUDE_DEG, LATITUDE_DEG])
        east = np.array([-np.sin(longitude), np.cos(longitude), 0.0])
        north = np.cross(frames.up_itrs, east)
        altitude, azimuth = np.radians([altitude_deg, azimuth_deg])
        local = np.cos(altitude) * (np.cos(azimuth) * north + np.sin(azimuth) * east) + np.sin(altitude) * frames.up_itrs
        add(kind, start, duration, *vector_to_radec(itrs_to_gcrs[0] @ local))

    def random_time():
        jd, fraction = utc_to_jd("2026-04-25T23:00:00Z")
        return jd_to_utc(jd, fraction + random.uniform(0.0, 11.5 / 24))

    for _ in range(20):  # uniform over the sky above 30 deg
        horizontal("random", random_time(), 30.0, np.degrees(np.arcsin(random.uniform(0.5, 1.0))), random.uniform(0, 360))
    for _ in range(8):  # low altitudes: satellites are far, slow and many
        horizontal("low", random_time(), 30.0, 20.0, random.uniform(0, 360))
    for dec in (-89.9, -89.2, -88.3, -90.0):  # the pole inside the field, on its edge and near it
        add("pole", random_time(), 60.0, random.uniform(0, 360), dec)
    for ra, dec in ((0.0, -30.0), (359.3, -45.0), (0.9, -28.0), (359.999999, -50.0), (0.4, -65.0), (358.9, -72.0), (0.0, -75.0)):
        add("wrap", f"2026-04-26T10:{random.integers(0, 59):02d}:{random.integers(0, 59):02d}.000Z", 240.0, ra, dec)
    # Geostationary belt: hour angle 0, declination with the parallax at latitude -30 deg (about +5 deg).
    for azimuth, altitude in ((0.0, 55.0), (330.0, 50.3), (25.0, 51.9)):
        horizontal("belt", random_time(), 300.0, altitude, azimuth)
    horizontal("zenith", random_time(), 30.0, 89.9, 10.0)
    horizontal("zenith", random_time(), 120.0, 88.5, 190.0)
    for _ in range(4):  # exposures of minutes, in the direction of most satellites
        horizontal("long", random_time(), 300.0, random.uniform(30, 60), random.uniform(100, 260))
    for _ in range(3):
        horizontal("short", random_time(), 1.0, 25.0, random.uniform(130, 230))
    for altitude in (12.0, 8.0):  # fields at the horizon
        horizontal("edge", random_time(), 30.0, altitude, random.uniform(130, 230))

    # Pointings at one satellite each, to include rare kinds of orbits and tracks along the edge of the field.
    age = lambda s: utc_to_jd("2026-04-26T04:00:00Z")[0] - s.jdsatepoch - s.jdsatepochF
    leo = lambda s: s.no_kozai > 2 * np.pi / 105 and s.ecco < 0.01
    kinds = {
        "eccentric": [s for s in satellites if s.ecco > 0.4],
        "inclined": [s for s in satellites if s.ecco > 0.02 and s.no_kozai > 2 * np.pi / 225],
        "navigation": [s for s in satellites if 2 * np.pi / 900 < s.no_kozai < 2 * np.pi / 600 and s.ecco < 0.1],
        "stale": [s for s in satellites if abs(age(s)) > 15],
        "lowest": [s for s in satellites if s.alta * 6378.135 < 400],
        "graze": [s for s in satellites if leo(s)],
        "miss": [s for s in satellites if leo(s)],
        "instant": [s for s in satellites if leo(s)],
    }
    number = {"inclined": 3, "lowest": 3, "graze": 5, "miss": 3, "instant": 2, "eccentric": 3, "navigation": 2, "stale": 3}
    for kind, members in kinds.items():
        done = 0
        while done < number[kind]:
            start, duration = random_time(), 0.0 if kind == "instant" else 20.0
            probe = Exposure(frames, start, duration, 0.0, 0.0)
            middle = duration / 2
            _, itrs_to_gcrs, _ = frames.at(probe.jd, probe.fraction + middle / DAY_S)
            _, up = frames.site(itrs_to_gcrs)
            sample = [members[i] for i in random.permutation(len(members))[:300]]
            vector = unit(probe.directions(SatrecArray(sample), np.array([middle, middle + 0.1])))
            high = np.flatnonzero(vector[:, 0] @ up[0] > np.sin(np.radians(25.0)))
            if not len(high):
                continue
            here, next_one = vector[high[0]]
            across = unit(np.cross(here, next_one))
            offset = random.uniform(-RADIUS, RADIUS) * 0.9
            if kind in ("graze", "miss"):
                inward = np.radians((10, 30, 100, 300, 3)[done] / 3600)
                offset = (RADIUS - inward if kind == "graze" else RADIUS + inward) * (1, -1)[done % 2]
            add(kind, start, duration, *vector_to_radec(np.cos(offset) * here + np.sin(offset) * across))
            done += 1
    return rows


class Exposure:
    """One exposure with its frames. Computes separations from the field centre."""

    def __init__(self, frames, start, duration, ra_deg, dec_deg):
        self.frames, self.duration = frames, duration
        self.jd, self.fraction = utc_to_jd(start)
        self.centre = radec_to_vector(ra_deg, dec_deg)

    def directions(self, satellites, seconds):
        """Returns ICRS astrometric vectors (n_satellite, n_time, 3), km; NaN where SGP4 fails."""
        fraction = self.fraction + seconds / DAY_S
        teme_to_gcrs, itrs_to_gcrs, earth = self.frames.at(self.jd, fraction)
        site, _ = self.frames.site(itrs_to_gcrs)
        error, r, v = satellites.sgp4(np.full_like(fraction, self.jd), fraction)
        r[error != 0] = np.nan
        r = np.einsum("tij,stj->sti", teme_to_gcrs, r)
        v = np.einsum("tij,stj->sti", teme_to_gcrs, v)
        return astrometric(r, v, site, earth)

    def separation(self, satellite, seconds):
        vector = self.directions(SatrecArray([satellite]), np.atleast_1d(np.asarray(seconds, dtype=float)))
        return separation(unit(vector[0]), self.centre)

    def candidates(self, satellites, step_s=1.0, chunk=61):
        """Returns the satellites that may be in the field at any time, by their speed alone."""
        n = max(int(np.ceil(self.duration / step_s)), 1) + 1
        grid = np.linspace(0.0, self.duration, n)
        half_step = self.duration / (n - 1) / 2
        keep, failed = np.zeros(len(satellites), bool), np.zeros(len(satellites), bool)
        for i in range(0, n, chunk):
            vector = self.directions(satellites, grid[i : i + chunk])
            distance = np.linalg.norm(vector, axis=-1)
            angle = separation(unit(vector), self.centre)
            slack = np.arcsin(np.minimum(FASTEST_KM_S * half_step / distance, 1.0)) + 1e-6
            keep |= (angle < RADIUS + slack).any(axis=1)
            failed |= np.isnan(angle).any(axis=1)
        return np.flatnonzero(keep | failed), int(failed.sum())

    def chords(self, satellite):
        """Returns the intervals inside the field, [(enter_s, exit_s)], and the smallest separation, radians."""
        n = max(int(np.ceil(self.duration / 0.05)), 1) + 1
        grid = np.linspace(0.0, self.duration, n)
        angle = self.separation(satellite, grid)
        if np.isnan(angle).any():
            return [], np.nan
        times, values = list(grid), list(angle)
        for i in range(1, n - 1):
            if angle[i] <= angle[i - 1] and angle[i] <= angle[i + 1] and angle[i] < RADIUS + np.radians(1.0):
                time = self.minimum(satellite, grid[i - 1], grid[i + 1])
                times.append(time)
                values.append(self.separation(satellite, time)[0])
        order = np.argsort(times, kind="stable")
        times, values = np.array(times)[order], np.array(values)[order]
        inside = values <= RADIUS
        chords, enter = [], 0.0 if inside[0] else None
        for i in range(1, len(times)):
            if inside[i] and not inside[i - 1]:
                enter = self.root(satellite, times[i - 1], times[i])
            elif inside[i - 1] and not inside[i]:
                chords.append((enter, self.root(satellite, times[i - 1], times[i])))
                enter = None
        if enter is not None:
            chords.append((enter, self.duration))
        return chords, values.min()

    def minimum(self, satellite, low, high):
        ratio = (np.sqrt(5.0) - 1.0) / 2.0
        while high - low > 1e-6:
            a, b = high - ratio * (high - low), low + ratio * (high - low)
            fa, fb = self.separation(satellite, [a, b])
            low, high = (low, b) if fa < fb else (a, high)
        return (low + high) / 2

    def root(self, satellite, low, high):
        inside_low = self.separation(satellite, low)[0] <= RADIUS
        while high - low > 1e-6:
            middle = (low + high) / 2
            if (self.separation(satellite, middle)[0] <= RADIUS) == inside_low:
                low = middle
            else:
                high = middle
        return (low + high) / 2


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output")
    output = parser.parse_args().output
    frames = Frames()
    satellites, ids = read_catalogue(CATALOGUE)
    array = SatrecArray(satellites)
    sha256 = hashlib.sha256(CATALOGUE.read_bytes()).hexdigest()
    lines, count, grazes, shortest = [], 0, [], []
    for name, start, duration, ra, dec in plan(frames, satellites):
        exposure = Exposure(frames, start, duration, ra, dec)
        candidates, failed = exposure.candidates(array)
        here = 0
        head = f"{name},{start},{duration:g},{ra:.6f},{dec:.6f}"
        for index in candidates:
            chords, least = exposure.chords(satellites[index])
            if np.isnan(least):
                continue
            grazes.append((abs(least - RADIUS), name, ids[index]))
            for enter, leave in chords:
                lines.append(f"{head},{ids[index]},{enter:.5f},{leave:.5f},{np.degrees(least):.7f}")
                shortest.append(leave - enter)
                here += 1
        if not here:
            lines.append(f"{head},,,,")
        count += here
        print(f"{name:12s} {start} {duration:5.0f} s  {len(candidates):4d} followed, {here:3d} cross, {failed} fail in SGP4", file=sys.stderr)
    grazes.sort()
    print("closest to the edge:", [(f"{np.degrees(g) * 3600:.1f} arcsec", n, int(i)) for g, n, i in grazes[:5]], file=sys.stderr)
    # Four objects are contained twice in the file and are excluded, because either record may be used by a catalogue.
    twice = {str(i) for i in ids if np.count_nonzero(ids == i) > 1}
    if any(line.split(",")[5] in twice for line in lines):
        sys.exit(f"one of {sorted(twice)}, which the catalogue holds twice, crosses: choose another seed")
    with open(output, "w") as file:
        file.write(
            f"# origin: tests/reference/brute_force_crossings.py, {datetime.date(2026, 11, 21)}; python-sgp4 {sgp4.__version__}"
            f" (AFSPC mode, WGS72), astropy {astropy.__version__} with ERFA (c2t06a, gmst82, pom00), finals2000A.all, DE421\n"
            f"# catalogue: tle/active/active_2026-04-25.txt, {len(ids)} objects, sha256 {sha256}\n"
            f"# site: latitude_deg {LATITUDE_DEG}, longitude_deg {LONGITUDE_DEG}, height_m {HEIGHT_M:g} (WGS84)"
            f"; field: circle, diameter_deg {DIAMETER_DEG}\n"
            "# directions: ICRS astrometric topocentric; seconds after start_utc; an exposure that nothing crosses has one row without norad_id;"
            " several rows of one pair are several chords; left out: what SGP4 refuses during the exposure (7 or 8 objects)\n"
            f"# {count} crossings; closest approach to the field's edge {np.degrees(grazes[0][0]) * 3600:.2f} arcsec;"
            f" shortest chord {min(s for s in shortest if s > 0):.4f} s\n"
            "exposure_id,start_utc,duration_s,ra_deg,dec_deg,norad_id,enter_s,exit_s,min_separation_deg\n"
        )
        file.write("\n".join(lines) + "\n")
    print(f"{count} crossings in {len({line.split(',')[0] for line in lines})} exposures", file=sys.stderr)


if __name__ == "__main__":
    main()
