"""Verdicts on visits of rubin_scheduler: radians and MJD are converted to degrees and times with a scale."""

from __future__ import annotations

import warnings
from typing import Any

import erfa
import numpy as np
from astropy.time import Time
from streakcast import Site, StreakcastWarning, StreakModel
from streakcast.hosts import SIMULATED_NIGHT_S, Hook

from ._arrays import BoolArray, FloatArray, Visits

SCALES = ("utc", "tai", "tt")
#: Difference of the Sun's altitude, degrees, above which the times are in another scale; the Sun moves by up to 0.15 deg
#: in 37 s. The difference between UT1 and UTC, and the aberration of light, are 0.01 deg.
SUN_TOLERANCE_DEG = 0.05
#: Years 1957 and 2099 (MJD).
FIRST_MJD, LAST_MJD = 35_839.0, 88_068.0
#: Number of visits whose altitude of the Sun is compared.
MOST_COMPARED = 50


def scale_of(model: StreakModel, mjd_scale: str | None) -> str:
    """Returns the scale of the scheduler's MJD, given by the caller or by the model. There is no default.

    Raises
    ------
    ValueError
        If the scale is missing or unknown.
    TypeError
        If the model is no `StreakModel`.
    """
    if not isinstance(model, StreakModel):
        raise TypeError(f"model is of the type {type(model).__name__}; allowed: a StreakModel")
    scale = mjd_scale if mjd_scale is not None else model.mjd_scale
    if scale is None:
        raise ValueError(
            "missing mjd_scale; specify 'utc' (the simulator's MJD) or 'tai' (an observatory's); "
            "in the wrong scale visits are 37 s off"
        )
    if scale not in SCALES:
        raise ValueError(f"mjd_scale is '{scale}'; allowed: {', '.join(SCALES)}")
    return scale


class ConditionsCheck:
    """Compares site and times of the scheduler with the model, the clock of this computer and the altitude of the Sun, once
    for each time of the conditions, which are as old as the queue."""

    def __init__(self, hook: Hook, scale: str) -> None:
        self._hook, self._scale = hook, scale
        self._sun_is_checked = False
        self._checked_mjd: Any = None

    def __call__(self, conditions: Any) -> None:
        mjd = getattr(conditions, "mjd", None)
        if mjd is not None and np.array_equal(mjd, self._checked_mjd):
            return
        # The scheduler may change its array.
        self._checked_mjd = None if mjd is None else np.copy(mjd)
        self._hook.check_clock(lambda: float(np.max(conditions.mjd)), self._scale)

        def location() -> tuple[float, float, float]:
            site = conditions.site
            return site.latitude, site.longitude, site.height

        self._hook.check_site(location)
        if not self._sun_is_checked:
            try:
                self._check_sun(conditions)
            except Exception as error:  # noqa: BLE001 - a hook never stops its host
                self._sun_is_checked = True
                self._hook.note("clock", f"the altitude of the Sun cannot be read: {type(error).__name__}: {error}", kind="sun")

    def _check_sun(self, conditions: Any) -> None:
        """Compares the altitude of the Sun with that at the time of the conditions, in simulations. At an observatory the
        clock is compared, which is more reliable."""
        site, given_rad = self._hook.model.site, getattr(conditions, "sun_alt", None)
        mjd = float(np.max(conditions.mjd))
        if site is None or given_rad is None or abs(mjd - Time.now().utc.mjd) < SIMULATED_NIGHT_S / 86_400.0:
            return
        off_deg, message = compare_sun(np.array([mjd]), np.degrees([np.max(given_rad)]), self._scale, site, "the scheduler")
        if not off_deg > 2.0 * SUN_TOLERANCE_DEG:
            # Around midnight the altitude changes slowly. The next conditions are compared.
            return
        self._sun_is_checked = True
        if message is not None:
            self._hook.note("clock", message, kind="sun")


def warn_of_sun(visits: Visits, scale: str, site: Site | None) -> None:
    """Issues a warning if the altitudes of the Sun in a table of visits contradict the scale of its times."""
    if site is None or "sunAlt" not in (visits.dtype.names or ()):
        return
    # Columns that were not filled contain zeros.
    known = np.flatnonzero(is_date(visits["mjd"]) & np.isfinite(visits["sunAlt"]) & (visits["sunAlt"] != 0.0))
    if known.size:
        some = known[:: max(1, known.size // MOST_COMPARED)]
        _, message = compare_sun(visits["mjd"][some], np.degrees(visits["sunAlt"][some]), scale, site, "the visits")
        if message is not None:
            warnings.warn(message, StreakcastWarning, stacklevel=3)


def compare_sun(
    mjd: FloatArray, given_deg: FloatArray, scale: str, site: Site, origin: str
) -> tuple[float, str | None]:
    """Returns the median difference of the given altitudes of the Sun from those in the scale with the largest one,
    degrees, and a message if they contradict the given scale."""
    off_deg = {one: float(np.median(np.abs(sun_altitude_deg(mjd, one, site) - given_deg))) for one in SCALES}
    if off_deg[scale] <= SUN_TOLERANCE_DEG:
        return max(off_deg.values()), None
    best = min(off_deg, key=lambda one: off_deg[one])
    if off_deg[best] <= SUN_TOLERANCE_DEG:
        hint = f"mjd_scale='{best}' agrees; in the wrong scale visits are 37 s off, and no result is valid"
    else:
        hint = "the site, the times or the unit of the altitudes (radians) differ, and no result may be valid"
    return max(off_deg.values()), (
        f"the Sun of {origin} is at {given_deg[0]:.2f} deg, {off_deg[scale]:.2f} deg from its altitude at {site.name} at the "
        f"given MJD in {scale}; {hint}"
    )


def is_date(mjd: FloatArray) -> BoolArray:
    """Returns which MJD are dates of surveys: those for which the Sun's altitude is computed."""
    return np.asarray((mjd > FIRST_MJD) & (mjd < LAST_MJD))


def sun_altitude_deg(mjd: FloatArray, scale: str, site: Site) -> FloatArray:
    """Returns the geometric altitudes of the Sun, degrees, ``(n,)``, with errors of 0.01 deg."""
    with warnings.catch_warnings():
        # Leap seconds after the next years are not known.
        warnings.simplefilter("ignore", erfa.ErfaWarning)
        time = Time(mjd, format="mjd", scale=scale)
        utc, tt = time.utc, time.tt
    sun = -erfa.epv00(tt.jd1, tt.jd2)[0]["p"]
    at_site = np.einsum("...ij,...j->...i", erfa.c2t06a(tt.jd1, tt.jd2, utc.jd1, utc.jd2, 0.0, 0.0), sun)
    latitude, longitude = np.radians([site.latitude_deg, site.longitude_deg])
    zenith = np.array([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)])
    return np.asarray(np.degrees(np.arcsin(at_site @ zenith / np.linalg.norm(sun, axis=-1))))


def pointings(visits: Visits) -> tuple[tuple[FloatArray, FloatArray], FloatArray, list[str]]:
    """Returns right ascension and declination, sky rotation (degrees) and bands of visits."""
    target, rotation = (np.degrees(visits["RA"]), np.degrees(visits["dec"])), np.degrees(visits["rotSkyPos"])
    rotation[np.isnan(rotation)] = 0.0
    return target, rotation, [str(one) for one in visits["band"]]
