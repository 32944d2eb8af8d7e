"""Brute-force computation of crossings without streakcast: python-sgp4, rotations of ERFA, steps of a second.

The element sets are those of the tested model. No candidate search, interpolation or photometry is used.
"""

from __future__ import annotations

import csv
import math
import tomllib
from copy import copy
from pathlib import Path

import almanac
import erfa
import numpy as np
from astropy.time import Time, TimeDelta
from sgp4 import omm
from sgp4.api import WGS72, Satrec, SatrecArray

EARTH_MU_KM3_S2 = 398600.8
EARTH_RADIUS_KM = 6378.137
#: Upper limit of the speed of satellites in low orbits relative to the site, km/s, to select candidates.
FASTEST_KM_S = 8.5
STEP_S = 1.0
#: Interval for which satellites above the horizon are selected, seconds.
SLOT_S = 180.0
#: Margin below the horizon in this selection, radians: the motion in half a slot plus half a minute at 7.8 km/s is
#: 0.14.
BELOW_RAD = 0.15
SHELLS = Path(__file__).resolve().parents[3] / "src" / "elements" / "shells.toml"


def write_walker(names: list[str], epoch: Time, path: Path) -> int:
    """Writes circular shells (numbers of shells.toml) as OMM in CSV. Returns the number of satellites."""
    keys = "OBJECT_NAME OBJECT_ID EPOCH MEAN_MOTION ECCENTRICITY INCLINATION RA_OF_ASC_NODE ARG_OF_PERICENTER MEAN_ANOMALY".split()
    keys += "EPHEMERIS_TYPE CLASSIFICATION_TYPE NORAD_CAT_ID ELEMENT_SET_NO REV_AT_EPOCH BSTAR MEAN_MOTION_DOT MEAN_MOTION_DDOT".split()
    filed = {one["name"]: one for one in tomllib.loads(SHELLS.read_text())["constellation"]}
    count = 0
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, keys)
        table.writeheader()
        for name in names:
            for shell in filed[name]["shell"]:
                planes, each = shell["planes"], shell["satellites_per_plane"]
                # n = (μ / a³)^½
                axis_km = EARTH_RADIUS_KM + shell["altitude_km"]
                motion = math.sqrt(EARTH_MU_KM3_S2 / axis_km**3) * 86_400.0 / math.tau
                for plane in range(planes):
                    node = shell.get("node_offset_deg", 0.0) + plane * shell.get("node_spread_deg", 360.0) / planes
                    for slot in range(each):
                        # In Walker's notation, adjacent planes are shifted by F steps of 360 / T.
                        anomaly = 360.0 * slot / each + 360.0 * shell.get("phasing", 1) * plane / (planes * each)
                        count += 1
                        row = (f"{name}-{count}", "2026-001A", epoch.utc.strftime("%Y-%m-%dT%H:%M:%S.%f"), f"{motion:.8f}", "0.0001000")
                        row += (f"{shell['inclination_deg']:.4f}", f"{node % 360.0:.4f}", "0.0000", f"{anomaly % 360.0:.4f}")
                        row += (0, "U", 100_000 + count, 999, 1, 0, 0, 0)
                        table.writerow(dict(zip(keys, row)))
    return count


def read_elements(path: Path) -> list[Satrec]:
    """Reads OMM in CSV, or TLE with or without names."""
    if path.suffix == ".csv":
        satellites = []
        with path.open(newline="") as file:
            for fields in csv.DictReader(file):
                satellite = Satrec()
                omm.initialize(satellite, fields)
                satellites.append(satellite)
        return satellites
    lines = path.read_text().splitlines()
    pairs = ((one, two) for one, two in zip(lines, lines[1:]) if one.startswith("1 ") and two.startswith("2 "))
    return [Satrec.twoline2rv(one, two, WGS72) for one, two in pairs]


class Truth:
    """True positions of satellites, computed from their element sets, optionally with along-track delays."""

    def __init__(self, satellites: list[Satrec]) -> None:
        self.satellites = satellites
        self.array = SatrecArray(satellites)
        self.late_s = np.zeros(len(satellites))
        self._slots: dict[int, tuple[np.ndarray, SatrecArray]] = {}
        location = almanac.location()
        self.site_itrs_km = np.array([location.x.to_value("km"), location.y.to_value("km"), location.z.to_value("km")])

    def delayed(self, along_track_sigma_s: float, seed: int) -> Truth:
        """Returns the same satellites, each with a random delay."""
        other = copy(self)
        other.late_s = np.random.default_rng(seed).normal(0.0, along_track_sigma_s, len(self.satellites))
        return other

    def _rotations(self, times: Time) -> tuple[np.ndarray, np.ndarray]:
        """Returns the rotation from TEME to GCRS, and the position of the site in GCRS, km, at each time."""
        ut1, tt = times.ut1, times.tt
        zero = np.zeros(times.size)
        to_itrs = erfa.c2t06a(tt.jd1, tt.jd2, ut1.jd1, ut1.jd2, zero, zero)
        # TEME to Earth-fixed: rotation by Greenwich mean sidereal time of 1982 (Vallado et al. 2006, AIAA 2006-6753,
        # app. C).
        sidereal = erfa.rz(erfa.gmst82(ut1.jd1, ut1.jd2), np.broadcast_to(np.eye(3), (times.size, 3, 3)))
        to_gcrs = np.swapaxes(to_itrs, -1, -2)
        return to_gcrs @ sidereal, to_gcrs @ self.site_itrs_km

    def _propagated(self, position: np.ndarray, velocity: np.ndarray, late_s: np.ndarray) -> np.ndarray:
        """Returns positions `late_s` later, by the series in f and g (Bate, Mueller & White 1971, section 5.4)."""
        u = EARTH_MU_KM3_S2 / np.linalg.norm(position, axis=-1, keepdims=True) ** 3
        s = late_s[..., None]
        return (1.0 - u * s**2 / 2.0) * position + (s - u * s**3 / 6.0) * velocity

    def _positions_gcrs_km(self, array: SatrecArray, late_s: np.ndarray, times: Time) -> tuple[np.ndarray, np.ndarray]:
        """Returns satellites in GCRS, (n_satellites, n_times, 3), and the site, (n_times, 3); NaN where SGP4 fails."""
        utc = times.utc
        error, position, velocity = array.sgp4(np.atleast_1d(utc.jd1), np.atleast_1d(utc.jd2))
        if np.any(late_s):
            position = self._propagated(position, velocity, np.broadcast_to(late_s[:, None], error.shape))
        position[error != 0] = np.nan
        rotation, site = self._rotations(times)
        return np.einsum("tij,stj->sti", rotation, position), site

    def _above(self, time: Time) -> tuple[np.ndarray, SatrecArray]:
        """Returns the satellites above the horizon, or slightly below it, in the slot that contains a time."""
        slot = int(time.mjd * 86_400.0 / SLOT_S)
        if slot not in self._slots:
            middle = Time([(slot + 0.5) * SLOT_S / 86_400.0], format="mjd", scale="utc")
            position, site = self._positions_gcrs_km(self.array, np.zeros(len(self.satellites)), middle)
            height_km = np.linalg.norm(position[:, 0], axis=-1)
            angle = np.arccos(np.clip(position[:, 0] @ site[0] / height_km / np.linalg.norm(site[0]), -1.0, 1.0))
            which = np.flatnonzero(angle < np.arccos(np.minimum(EARTH_RADIUS_KM / height_km, 1.0)) + BELOW_RAD)
            self._slots[slot] = (which, SatrecArray([self.satellites[one] for one in which]))
        return self._slots[slot]

    def crossings(
        self, ra_rad: np.ndarray, dec_rad: np.ndarray, starts: Time, lengths_s: np.ndarray, radius_deg: float
    ) -> list[dict[int, float]]:
        """Returns for each visit the lit satellites that cross the field, with the smallest separation in degrees."""
        found: list[dict[int, float]] = []
        centres = np.column_stack([np.cos(dec_rad) * np.cos(ra_rad), np.cos(dec_rad) * np.sin(ra_rad), np.sin(dec_rad)])
        middles = starts.utc + TimeDelta(lengths_s / 2.0, format="sec")
        for row, centre in enumerate(centres):
            which, array = self._above(middles[row])
            position, site = self._positions_gcrs_km(array, self.late_s[which], middles[row : row + 1])
            near = which[self._near_field(position[:, 0] - site, centre, lengths_s[row], radius_deg)]
            found.append(self._crossing(near, centre, starts[row], lengths_s[row], radius_deg) if near.size else {})
        return found

    def _near_field(self, seen_km: np.ndarray, centre: np.ndarray, length_s: float, radius_deg: float) -> np.ndarray:
        range_km = np.linalg.norm(seen_km, axis=-1)
        away = np.arccos(np.clip(seen_km @ centre / range_km, -1.0, 1.0))
        way_km = FASTEST_KM_S * (length_s / 2.0 + 1.0)
        reach = np.where(range_km > 1.5 * way_km, np.arcsin(np.minimum(way_km / range_km, 1.0)), np.pi)
        return np.flatnonzero(away < reach + math.radians(radius_deg))

    def _crossing(self, near: np.ndarray, centre: np.ndarray, start: Time, length_s: float, radius_deg: float) -> dict[int, float]:
        steps = max(int(math.ceil(length_s / STEP_S)), 1)
        times = start + TimeDelta(np.linspace(0.0, length_s, steps + 1), format="sec")
        position, site = self._positions_gcrs_km(SatrecArray([self.satellites[one] for one in near]), self.late_s[near], times)
        lit = self._lit(position, times)
        seen = position - site
        seen /= np.linalg.norm(seen, axis=-1, keepdims=True)
        # Distance of the field centre from the chord between successive seconds.
        one, two = seen[:, :-1], seen[:, 1:]
        chord = two - one
        along = np.clip(np.einsum("sti,sti->st", centre - one, chord) / np.einsum("sti,sti->st", chord, chord), 0.0, 1.0)
        closest = one + along[..., None] * chord
        cosine = np.einsum("sti,i->st", closest, centre) / np.linalg.norm(closest, axis=-1)
        away = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        away[~(lit[:, :-1] | lit[:, 1:])] = np.inf
        least = np.nanmin(np.where(np.isfinite(away), away, np.inf), axis=1)
        return {int(near[one]): float(least[one]) for one in np.flatnonzero(least < radius_deg)}

    def _lit(self, place_km: np.ndarray, times: Time) -> np.ndarray:
        """Returns True if any part of the Sun's disc is above the limb of a spherical Earth."""
        tdb = times.tdb
        sun = -erfa.epv00(tdb.jd1, tdb.jd2)[0]["p"]
        sun = sun / np.linalg.norm(sun, axis=-1, keepdims=True)
        range_km = np.linalg.norm(place_km, axis=-1)
        from_earth = np.arccos(np.clip(-np.einsum("sti,ti->st", place_km, sun) / range_km, -1.0, 1.0))
        return from_earth > np.arcsin(EARTH_RADIUS_KM / range_km) - math.radians(0.2666)



def streaked(truth: Truth, visits: np.ndarray, radius_deg: float = 1.75, scale: str = "utc") -> np.ndarray:
    """Returns for each visit whether it is crossed by a lit satellite while the shutter is open."""
    starts = Time(np.asarray(visits["mjd"]), format="mjd", scale=scale)
    found = truth.crossings(np.asarray(visits["RA"]), np.asarray(visits["dec"]), starts, np.asarray(visits["exptime"]), radius_deg)
    return np.array([bool(one) for one in found], dtype=bool)
