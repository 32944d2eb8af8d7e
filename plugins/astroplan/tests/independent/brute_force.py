"""Brute-force computation of crossings without streakcast: python-sgp4 for orbits, astropy and ERFA for frames.

Every satellite is propagated in steps of `COARSE_S`. Satellites near the field are then followed in steps of `FINE_S`.
Refraction, light time (below 12 arcsec at 600 km) and the size of the penumbra are neglected. Their effects are below
`EDGE_DEG` and `SHADOW_KM`, and streaks within these distances of an edge are not counted.
"""

import erfa
import numpy as np
from astropy import units as u
from astropy.coordinates import get_sun
from astropy.time import Time
from sgp4.api import Satrec, SatrecArray

COARSE_S = 5.0
FINE_S = 0.1
#: A satellite at 400 km moves 1.1 deg/s overhead, which is 2.8 deg in half a coarse step; a margin is added for lower
#: satellites.
NEAR_DEG = 5.0
#: Effect of light time, diurnal aberration, interpolation between fine steps and UT1 - UTC, degrees.
EDGE_DEG = 0.02
#: Effect of flattening and refraction on the shadow of a sphere, km.
SHADOW_KM = 60.0
EARTH_KM = 6378.137


def walker(shells, epoch, first=70_000):
    """Returns simulated circular orbits as `Satrec`; shells are (height_km, inclination_deg, planes, per plane)."""
    satellites = []
    days = (epoch - Time("1949-12-31T00:00:00", scale="utc")).to_value("day")
    for height_km, inclination_deg, planes, each in shells:
        motion_rad_min = np.sqrt(398_600.8 / (6378.135 + height_km) ** 3) * 60.0
        for plane in range(planes):
            for slot in range(each):
                satellite = Satrec()
                node = 2.0 * np.pi * plane / planes
                anomaly = 2.0 * np.pi * (slot / each + plane / (planes * each))
                number = (first + len(satellites)) % 100_000
                satellite.sgp4init(
                    0, "i", number, days, 0.0, 0.0, 0.0, 1e-4, 0.0, np.radians(inclination_deg), anomaly, motion_rad_min, node
                )  # fmt: skip
                satellites.append(satellite)
    return satellites


def write_tle(path, satellites):
    """Writes satellites to an element file. Returns them as read from the file, with its digits."""
    from sgp4.exporter import export_tle

    lines, again = [], []
    for satellite in satellites:
        first, second = export_tle(satellite)
        lines += [f"WALKER-{satellite.satnum}", first, second]
        again.append(Satrec.twoline2rv(first, second, 0))
    path.write_text("\n".join(lines) + "\n")
    return again


class Sky:
    """Satellites over a site.

    Parameters
    ----------
    satellites : list of Satrec
    location : `~astropy.coordinates.EarthLocation`
    """

    def __init__(self, satellites, location):
        self.satellites = satellites
        self.all_satellites = SatrecArray(satellites)
        self.site_km = np.array([getattr(location, axis).to_value("km") for axis in "xyz"])

    def _frames(self, times):
        """Returns the rotations to ICRS from TEME and from the Earth-fixed frame, ``(n_times, 3, 3)``."""
        tt, ut1 = times.tt, times.utc  # UT1 = UTC to within a second: at most 0.4 km of the site, or 0.03 deg at 600 km
        earth = erfa.c2t06a(tt.jd1, tt.jd2, ut1.jd1, ut1.jd2, 0.0, 0.0)
        to_icrs = np.swapaxes(earth, -1, -2)
        # TEME to Earth-fixed: rotation by the mean sidereal time of 1982 about the pole (Vallado et al. 2006).
        angle = erfa.gmst82(ut1.jd1, ut1.jd2)
        turn = np.zeros((len(angle), 3, 3))
        turn[:, 0, 0] = turn[:, 1, 1] = np.cos(angle)
        turn[:, 0, 1], turn[:, 1, 0] = np.sin(angle), -np.sin(angle)
        turn[:, 2, 2] = 1.0
        return to_icrs @ turn, to_icrs

    def _separation_and_light(self, satellites, times, field, sun):
        """Returns separations from the field centre, degrees, and whether sunlit: ``(n_satellites, n_times)``."""
        from_teme, from_earth = self._frames(times)
        utc = times.utc
        error, teme_km, _ = satellites.sgp4(np.atleast_1d(utc.jd1), np.atleast_1d(utc.jd2))
        teme_km[error != 0] = np.nan
        position_km = np.einsum("tij,stj->sti", from_teme, teme_km)
        seen_km = position_km - (from_earth @ self.site_km)
        cosine = seen_km @ field / np.linalg.norm(seen_km, axis=-1)
        along = position_km @ sun
        across = np.linalg.norm(position_km - along[..., np.newaxis] * sun, axis=-1)
        lit = (along > 0.0) | (across > EARTH_KM + SHADOW_KM)
        separation = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        return np.nan_to_num(separation, nan=180.0), lit

    def contacts(self, target, start, span_s, radius_deg, edge_deg=EDGE_DEG):
        """Returns the time spans in which satellites are sunlit and inside the field by more than `edge_deg`.

        Parameters
        ----------
        target : `~astropy.coordinates.SkyCoord`
        start : `~astropy.time.Time`
        span_s, radius_deg : float

        Returns
        -------
        list of (number, enter_s, exit_s), seconds after the start
        """
        field = np.asarray(target.icrs.cartesian.xyz.value, dtype=float)
        # The Sun moves 0.04 deg/h.
        sun = get_sun(start + span_s / 2 * u.s).cartesian.xyz.value
        sun = sun / np.linalg.norm(sun)
        coarse_s = np.append(np.arange(0.0, span_s, COARSE_S), span_s)
        separation, _ = self._separation_and_light(self.all_satellites, start + coarse_s * u.s, field, sun)
        found = []
        for index in np.flatnonzero(separation.min(axis=1) < radius_deg + NEAR_DEG):
            near = np.flatnonzero(separation[index] < radius_deg + NEAR_DEG)
            # One interval for each approach.
            for interval in np.split(near, np.flatnonzero(np.diff(near) > 1) + 1):
                first_s, last_s = coarse_s[max(0, interval[0] - 1)], coarse_s[min(len(coarse_s) - 1, interval[-1] + 1)]
                fine_s = np.append(np.arange(first_s, last_s, FINE_S), last_s)
                close, lit = self._separation_and_light(SatrecArray([self.satellites[index]]), start + fine_s * u.s, field, sun)
                inside = np.flatnonzero((close[0] < radius_deg - edge_deg) & lit[0])
                for run in np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1):
                    if len(run):
                        found.append((self.satellites[index].satnum, fine_s[run[0]], fine_s[run[-1]]))
        return found

    def streaks(self, target, start, exposure_s, radius_deg):
        """Returns the numbers of satellites that certainly cross an exposure; parameters as for `contacts`."""
        return sorted({number for number, _, _ in self.contacts(target, start, exposure_s, radius_deg)})
