"""What the hooks ask a model about visits: radians and MJD of the host become degrees and a time with a scale."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from streakcast import StreakModel

from ._arrays import BoolArray, FloatArray, IntArray, Visits
from ._mount import Openings

#: A satellite of this magnitude weighs one; each magnitude brighter 2.5 times as much.
REFERENCE_MAG = 7.0
#: Between these the weight of light is kept: what is fainter is still a streak, what is brighter ruins no more than the frame.
LEAST_WEIGHT, MOST_WEIGHT = 1e-3, 1e3
SCALES = ("utc", "tai", "tt")
DAMAGES = ("pixels", "light")
BLOCKINGS = ("any", "avoid")


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


def judge(model: StreakModel, visits: Visits, openings: Openings, scale: str, jitter_s: float, damage: str, blocking: str) -> Verdicts:
    """Asks for all visits at once whether anything crosses them, from `jitter_s` before their opening to as long after their closing."""
    answer = model.assess(
        (np.degrees(visits["RA"]), np.degrees(visits["dec"])),
        openings.start_mjd - jitter_s / 86_400.0,
        openings.length_s + 2.0 * jitter_s,
        rotation=np.degrees(np.nan_to_num(visits["rotSkyPos"])),
        band=[str(one) for one in visits["band"]],
        scale=scale,
    )
    lost = np.where(np.isfinite(answer.lost_fraction), answer.lost_fraction, np.nan_to_num(answer.streak_length_deg))
    if damage == "light":
        lost = lost * weight_of_light(answer.brightest_mag)
    blocked = answer.avoid if blocking == "avoid" else answer.crosses
    return Verdicts(np.asarray(blocked, dtype=bool), np.asarray(lost, dtype=float), answer.n_streaks, answer.brightest_mag)
