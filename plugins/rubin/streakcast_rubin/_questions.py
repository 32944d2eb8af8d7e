"""What the hooks ask a model about visits: radians and MJD of the host become degrees and a time with a scale."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from streakcast import StreakModel
from streakcast.hosts import Hook

from ._arrays import BoolArray, FloatArray, IntArray, Visits
from ._mount import Openings

#: A satellite of this magnitude weighs one; each magnitude brighter 2.5 times as much.
REFERENCE_MAG = 7.0
#: Between these the weight of light is kept: what is fainter is still a streak, what is brighter ruins no more than the frame.
LEAST_WEIGHT, MOST_WEIGHT = 1e-3, 1e3
#: What is less likely does not break a limit.
LEAST_PROBABILITY = 0.5
SCALES = ("utc", "tai", "tt")
DAMAGES = ("pixels", "light")
BLOCKINGS = ("any", "avoid")


class Rules(NamedTuple):
    """What counts, and how."""

    scale: str
    jitter_s: float
    #: One of `DAMAGES`.
    damage: str
    #: One of `BLOCKINGS`.
    blocking: str
    #: A magnitude, magnitudes by band, or `None`.
    limit_mag: Any


class Verdicts(NamedTuple):
    """What satellites would do to visits."""

    #: Whether a visit should not be taken now.
    blocked: BoolArray
    #: What it would lose, in the unit that was asked for.
    damage: FloatArray
    n_streaks: IntArray
    brightest_mag: FloatArray


def scale_of(model: StreakModel, mjd_scale: str | None) -> str:
    """The scale of the host's MJD: the word of the caller, or of the model; there is no default.

    Raises
    ------
    ValueError
        Nobody said it, or it is none that we know.
    """
    scale = mjd_scale if mjd_scale is not None else model.mjd_scale
    if scale is None:
        raise ValueError(
            "mjd_scale is not said: give 'utc' (the simulator's MJD) or 'tai' (an observatory's); "
            "read in the wrong scale a visit is 37 s off"
        )
    if scale not in SCALES:
        raise ValueError(f"mjd_scale '{scale}'; allowed: {', '.join(SCALES)}")
    return scale


def weight_of_light(brightest_mag: FloatArray) -> FloatArray:
    """How much a satellite's light weighs against one of 7 mag.

    w = 10^(-0.4 (m - 7)), kept in [0.001, 1000]; 1 where no magnitude is known.
    """
    weight = 10.0 ** (-0.4 * (np.asarray(brightest_mag, dtype=float) - REFERENCE_MAG))
    return np.asarray(np.where(np.isfinite(weight), np.clip(weight, LEAST_WEIGHT, MOST_WEIGHT), 1.0), dtype=float)


def see(hook: Hook, conditions: Any, scale: str) -> None:
    """Holds the host's site and clock against ours."""

    def place() -> tuple[float, float, float]:
        site = conditions.site
        return site.latitude, site.longitude, site.height

    hook.see_site(place)
    hook.see_clock(lambda: float(np.max(conditions.mjd)), scale)


def limit_of(limit_mag: Any, band: str | None) -> float | None:
    """The limit of a band; `None` where none is said for it: there every lit satellite counts, as where there is no limit at all."""
    limit = limit_mag.get(band, limit_mag.get("default")) if isinstance(limit_mag, dict) else limit_mag
    return None if limit is None else float(limit)


def pointings(visits: Visits) -> tuple[tuple[FloatArray, FloatArray], FloatArray, list[str]]:
    """Where the host's visits point, in degrees: right ascension and declination, and the rotation of the sky; and their bands."""
    target = (np.degrees(visits["RA"]), np.degrees(visits["dec"]))
    return target, np.degrees(np.nan_to_num(visits["rotSkyPos"])), [str(one) for one in visits["band"]]


def judge(model: StreakModel, visits: Visits, openings: Openings, rules: Rules) -> Verdicts:
    """Asks for all visits at once what crosses them, from `jitter_s` before their opening to as long after their closing."""
    target, rotation, bands = pointings(visits)
    start = openings.start_mjd - rules.jitter_s / 86_400.0
    length_s = openings.length_s + 2.0 * rules.jitter_s
    if rules.blocking == "avoid" and rules.limit_mag is None:
        # The policy's own limits: of loss and probability too, which take what may only just come by into account.
        answer = model.assess(target, start, length_s, rotation=rotation, band=bands, scale=rules.scale)
        lost = np.where(np.isfinite(answer.lost_fraction), answer.lost_fraction, np.nan_to_num(answer.streak_length_deg))
        blocked, n_streaks, brightest_mag = answer.avoid, answer.n_streaks, answer.brightest_mag
    else:
        passes = model.passes(target, start, length_s, rotation=rotation, scale=rules.scale, output="dict")
        which = np.asarray(passes["exposure_id"], dtype=np.int64)
        magnitude = np.asarray(passes["magnitude_peak"], dtype=float)
        share, length_deg = (np.asarray(passes[one], dtype=float) for one in ("lost_pixel_fraction", "streak_length_deg"))
        n_streaks = np.bincount(which, minlength=visits.size)
        # Where no telescope tells a share, the length of the streaks stands for it.
        lost = np.bincount(which, weights=np.where(np.isfinite(share), share, length_deg), minlength=visits.size)
        brightest_mag = np.full(visits.size, np.inf)
        np.fmin.at(brightest_mag, which, magnitude)
        brightest_mag[np.isinf(brightest_mag)] = np.nan
        blocked = n_streaks > 0
        if rules.blocking == "avoid":
            limit = np.array([limit_of(rules.limit_mag, bands[one]) for one in which], dtype=float)
            # As the model's own limits: brighter, and at least as likely as not.
            bright = (magnitude < limit) & (np.asarray(passes["probability"], dtype=float) >= LEAST_PROBABILITY)
            blocked = np.bincount(which, weights=bright | np.isnan(limit), minlength=visits.size) > 0
    if rules.damage == "light":
        lost = lost * weight_of_light(brightest_mag)
    return Verdicts(np.asarray(blocked, dtype=bool), np.asarray(lost, dtype=float), n_streaks, brightest_mag)
