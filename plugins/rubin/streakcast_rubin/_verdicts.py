"""Verdicts on visits of rubin_scheduler: radians and MJD are converted to degrees and times with a scale."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from streakcast import StreakModel, UnknownPositionsError
from streakcast.hosts import Hook

from ._arrays import BoolArray, FloatArray, IntArray, Visits
from ._mount import Openings

#: Magnitude with weight 1; the weight increases by a factor of 2.5 per magnitude.
REFERENCE_MAG = 7.0
#: Range of the weight: fainter satellites still cause streaks, and brighter ones cannot affect more than the frame.
LEAST_WEIGHT, MOST_WEIGHT = 1e-3, 1e3
#: Smallest probability of a crossing brighter than a magnitude limit for which a visit is blocked.
LEAST_PROBABILITY = 0.5
SCALES = ("utc", "tai", "tt")
DAMAGES = ("pixels", "light")
BLOCKINGS = ("any", "avoid")


class Rules(NamedTuple):
    """Options of the verdicts."""

    scale: str
    jitter_s: float
    #: One of `DAMAGES`.
    damage: str
    #: One of `BLOCKINGS`.
    blocking: str
    #: A magnitude, magnitudes by band, or `None`.
    limit_mag: Any


class Verdicts(NamedTuple):
    """Effects of satellites on visits."""

    #: Whether a visit should not be dispatched now.
    blocked: BoolArray
    #: Damage, in the unit of `Rules.damage`.
    damage: FloatArray
    n_streaks: IntArray
    brightest_mag: FloatArray


def scale_of(model: StreakModel, mjd_scale: str | None) -> str:
    """Returns the scale of the scheduler's MJD, given by the caller or by the model. There is no default.

    Raises
    ------
    ValueError
        If the scale is missing or unknown.
    """
    scale = mjd_scale if mjd_scale is not None else model.mjd_scale
    if scale is None:
        raise ValueError(
            "missing mjd_scale; specify 'utc' (the simulator's MJD) or 'tai' (an observatory's); "
            "in the wrong scale visits are 37 s off"
        )
    if scale not in SCALES:
        raise ValueError(f"mjd_scale is '{scale}'; allowed: {', '.join(SCALES)}")
    return scale


def weight_of_light(brightest_mag: FloatArray) -> FloatArray:
    """Returns the weight of the brightness of a satellite relative to 7 mag.

    w = 10^(-0.4 (m - 7)), limited to [0.001, 1000]; 1 if the magnitude is unknown.
    """
    weight = 10.0 ** (-0.4 * (np.asarray(brightest_mag, dtype=float) - REFERENCE_MAG))
    return np.asarray(np.where(np.isfinite(weight), np.clip(weight, LEAST_WEIGHT, MOST_WEIGHT), 1.0), dtype=float)


def check_conditions(hook: Hook, conditions: Any, scale: str) -> None:
    """Compares site and clock of the scheduler with those of the model and of this computer."""

    def location() -> tuple[float, float, float]:
        site = conditions.site
        return site.latitude, site.longitude, site.height

    hook.check_site(location)
    hook.check_clock(lambda: float(np.max(conditions.mjd)), scale)


def limit_of(limit_mag: Any, band: str | None) -> float | None:
    """Returns the limit for a band; `None` if there is none, so that all lit satellites block."""
    limit = limit_mag.get(band, limit_mag.get("default")) if isinstance(limit_mag, dict) else limit_mag
    return None if limit is None else float(limit)


def limit_values(limit_mag: Any) -> tuple[float, ...]:
    """Returns the different limits of all bands."""
    if limit_mag is None:
        return ()
    values = limit_mag.values() if isinstance(limit_mag, dict) else [limit_mag]
    return tuple(sorted({float(one) for one in values}))


def pointings(visits: Visits) -> tuple[tuple[FloatArray, FloatArray], FloatArray, list[str]]:
    """Returns right ascension and declination, sky rotation (degrees) and bands of visits."""
    target = (np.degrees(visits["RA"]), np.degrees(visits["dec"]))
    return target, np.degrees(np.nan_to_num(visits["rotSkyPos"])), [str(one) for one in visits["band"]]


def judge(model: StreakModel, visits: Visits, openings: Openings, rules: Rules) -> Verdicts:
    """Computes the verdicts on all visits, from `jitter_s` before shutter opening until `jitter_s` after closing."""
    target, rotation, bands = pointings(visits)
    start = openings.start_mjd - rules.jitter_s / 86_400.0
    length_s = openings.length_s + 2.0 * rules.jitter_s
    if rules.blocking == "avoid" and rules.limit_mag is None:
        # All limits of the policy are applied, including those of loss and probability, which include near misses.
        assessment = model.assess(target, start, length_s, rotation=rotation, band=bands, scale=rules.scale)
        if (np.asarray(assessment.verdict) == "unknown").any():
            raise UnknownPositionsError("the elements are too old to predict positions")
        lost = np.where(np.isfinite(assessment.lost_fraction), assessment.lost_fraction, np.nan_to_num(assessment.streak_length_deg))
        blocked = np.asarray(assessment.avoid)
        n_streaks, brightest_mag = np.asarray(assessment.n_streaks), np.asarray(assessment.brightest_mag)
    else:
        limits = np.array([limit_of(rules.limit_mag, band) for band in bands], dtype=float)
        passes = model.passes(
            target, start, length_s, rotation=rotation, limit_mag=limits, scale=rules.scale, output="dict"
        )
        which = np.asarray(passes["exposure_id"], dtype=np.int64)
        magnitude = np.asarray(passes["magnitude_peak"], dtype=float)
        share, length_deg = (np.asarray(passes[one], dtype=float) for one in ("lost_pixel_fraction", "streak_length_deg"))
        n_streaks = np.bincount(which, minlength=visits.size)
        # Without a telescope, the length of the streaks is used instead of the lost fraction.
        lost = np.bincount(which, weights=np.where(np.isfinite(share), share, length_deg), minlength=visits.size)
        brightest_mag = np.full(visits.size, np.inf)
        np.fmin.at(brightest_mag, which, magnitude)
        brightest_mag[np.isinf(brightest_mag)] = np.nan
        blocked = n_streaks > 0
        if rules.blocking == "avoid":
            # As for the limits of the model: a crossing is brighter than the limit with a probability of at least 0.5.
            p_brighter = np.asarray(passes["p_brighter"], dtype=float)
            bright = np.asarray(passes["probability"], dtype=float) * p_brighter >= LEAST_PROBABILITY
            blocked = np.bincount(which, weights=bright | np.isnan(limits[which]), minlength=visits.size) > 0
    if rules.damage == "light":
        lost = lost * weight_of_light(brightest_mag)
    return Verdicts(np.asarray(blocked, dtype=bool), np.asarray(lost, dtype=float), n_streaks, brightest_mag)
