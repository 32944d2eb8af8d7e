"""Position of the telescope, and predicted shutter openings of the next visits."""

from __future__ import annotations

from copy import deepcopy
from typing import Any, NamedTuple

import numpy as np
from rubin_scheduler.scheduler.model_observatory import KinemModel

from ._arrays import FloatArray

DAY_S = 86_400.0
#: Idle time after which the telescope is parked, days (as in rubin_scheduler).
PARKED_AFTER_DAY = 10.0 / 1440.0
#: Conditions that are older than the known time by more than this are outdated, days.
STALE_DAY = 1.0 / DAY_S

#: Largest age of a queue and thus of its conditions, days.
QUEUE_DAY = 0.25
#: Tolerance for times that are earlier than the previous one, days, because times are rounded.
TIME_TOLERANCE_DAY = 1.0 / DAY_S
QUARTER_TURNS_RAD = (-np.pi / 2.0, np.pi / 2.0, np.pi)


class Openings(NamedTuple):
    """Predicted shutter openings and durations of several visits."""

    #: Opening, days (MJD in the scale of the scheduler), ``(n,)``; NaN if the telescope cannot reach the visit.
    start_mjd: FloatArray
    #: Slew time from the current position, seconds, ``(n,)``.
    slew_s: FloatArray
    #: Time from shutter opening to closing, including readouts between snaps, seconds, ``(n,)``.
    length_s: FloatArray


class Mount:
    """Records completed visits, and computes slew times with the kinematic model of rubin_scheduler.

    The conditions passed to a queue manager may be as old as its queue (``sim_runner`` updates them when the queue is
    empty). Time and pointing are therefore those of the last visit if that is newer.

    Parameters
    ----------
    kinematics : KinemModel, optional
        Kinematic model with the speeds of the real mount; default: that of rubin_scheduler.
    """

    def __init__(self, kinematics: KinemModel | None = None) -> None:
        self.kinematics = KinemModel() if kinematics is None else deepcopy(kinematics)
        self.last: dict[str, float | str] | None = None
        self.host_mjd = -np.inf
        self.conditions_mjd = -np.inf

    def set_time(self, mjd: float) -> None:
        """Sets the current time as given by the scheduler."""
        now = float(mjd)
        if now < self.host_mjd - TIME_TOLERANCE_DAY:
            self._reset_to(now)
        self.host_mjd = now

    def _reset_to(self, now: float) -> None:
        """Discards later times and visits after a restart of the scheduler at an earlier time."""
        self.host_mjd = self.conditions_mjd = -np.inf
        if self.last is not None and float(self.last["free_mjd"]) > now + PARKED_AFTER_DAY:
            self.last = None

    def done(self, observation: Any) -> None:
        """Records a completed visit. ``SummitWrapper`` also reports requested visits, with duration 0, as completed."""
        one = np.ravel(observation)[0]
        start, length_s = float(one["mjd"]), float(one["visittime"])
        azimuth = float(one["cummTelAz"])
        if not length_s > 0.0:
            visit = np.ravel(np.asarray(observation))
            azimuth = 0.0 if self.last is None else float(self.last["azimuth"])
            if self.last is not None:
                start = max(start, float(self.last["free_mjd"]))
                self._place_at_last(start)
                slew_s = float(self._slew_times(start, visit)[0])
                start += (slew_s if np.isfinite(slew_s) else 0.0) / DAY_S
            length_s = float(self._lengths(visit)[0])
        self.last = {
            "ra": float(one["RA"]),
            "dec": float(one["dec"]),
            "rotation": float(one["rotSkyPos"]),
            "azimuth": azimuth,
            "band": str(one["band"]),
            "free_mjd": start + length_s / DAY_S,
        }

    def now(self, conditions: Any) -> float:
        """Returns the latest of: time of the conditions, time of the scheduler, end of the last visit (MJD)."""
        now = float(np.max(conditions.mjd))
        if now < self.conditions_mjd - TIME_TOLERANCE_DAY:
            self._reset_to(now)
        self.conditions_mjd = now
        candidates = [self.host_mjd] if self.last is None else [self.host_mjd, float(self.last["free_mjd"])]
        # Times that are later than the conditions by more than the age of a queue belong to another night, before a
        # restart of the scheduler at an earlier time.
        return max([now, *(one for one in candidates if one - now < QUEUE_DAY)])

    def openings(self, conditions: Any, visits: Any) -> Openings:
        """Returns the shutter openings of visits in one band for the case that each is dispatched now."""
        now = self.now(conditions)
        self._place(conditions, now)
        slew_s = self._slew_times(now, visits)
        return Openings(now + slew_s / DAY_S, slew_s, self._lengths(visits))

    def between(self, now: float, visits: Any) -> FloatArray:
        """Returns the slew times between all pairs of visits in one band without the rotator, seconds, ``(n, n)``, from
        the visit of the row to that of the column. The readout is the shortest."""
        model = self.kinematics
        altitude, azimuth, _ = model.radec2altaz(np.asarray(visits["RA"], dtype=float), np.asarray(visits["dec"], dtype=float), now)
        n = len(altitude)
        start, end = np.repeat(np.arange(n), n), np.tile(np.arange(n), n)
        kept, model.overhead = model.overhead, model.readtime
        try:
            # One call for all pairs: the function accepts arrays of one dimension.
            times_s = model.slew_times(
                None, None, now, bandname=None, alt_rad=altitude[end], az_rad=azimuth[end],
                starting_alt_rad=altitude[start], starting_az_rad=azimuth[start],
            )  # fmt: skip
        finally:
            model.overhead = kept
        return np.asarray(times_s, dtype=float).reshape(n, n)

    def _place(self, conditions: Any, now: float) -> None:
        """Sets the kinematic model to the position of the telescope."""
        model, last = self.kinematics, self.last
        if conditions.mounted_bands:
            model.mount_bands(list(conditions.mounted_bands))
        fresh = float(np.max(conditions.mjd)) >= now - STALE_DAY
        model.overhead = 0.0
        if last is not None and 0.0 <= now - float(last["free_mjd"]) < PARKED_AFTER_DAY:
            self._place_at_last(now)
        elif fresh and conditions.tel_ra is not None and np.all(np.isfinite(conditions.tel_ra)):
            model.parked = False
            model.current_ra_rad, model.current_dec_rad = np.ravel(conditions.tel_ra)[:1], np.ravel(conditions.tel_dec)[:1]
            model.current_rot_sky_pos_rad = None
            model.last_rot_tel_pos_rad = 0.0 if conditions.rot_tel_pos is None else float(np.max(conditions.rot_tel_pos))
            if conditions.cumulative_azimuth_rad is not None:
                model.cumulative_azimuth_rad = float(np.max(conditions.cumulative_azimuth_rad))
            if conditions.current_band:
                self._load(str(conditions.current_band))
        else:
            model.park()
            self._load(str(np.ravel(model.start_band)[0]))

    def _place_at_last(self, now: float) -> None:
        """Sets the kinematic model to the position of the last visit."""
        model, last = self.kinematics, self.last
        if last is None:
            return
        model.parked = False
        model.current_ra_rad, model.current_dec_rad = np.array([last["ra"]]), np.array([last["dec"]])
        model.current_rot_sky_pos_rad = np.array([last["rotation"]])
        model.cumulative_azimuth_rad = float(last["azimuth"])
        self._load(str(last["band"]))
        # The readout continues during the slew; the next exposure cannot start before it ends.
        model.overhead = max(0.0, model.readtime - (now - float(last["free_mjd"])) * DAY_S)

    def _load(self, band: str) -> None:
        """Sets the band of the kinematic model, which is stored in an array."""
        self.kinematics.current_band = np.array([band])

    def _slew_times(self, mjd: float, visits: Any) -> FloatArray:
        model = self.kinematics
        ra, dec = np.asarray(visits["RA"], dtype=float), np.asarray(visits["dec"], dtype=float)
        if not model.parked and str(visits["band"][0]) != str(model.current_band[0]):
            # The rotator moves during the filter exchange.
            return np.asarray(model.slew_times(ra, dec, mjd, bandname=None) + model.band_changetime, dtype=float)
        # Otherwise it moves during the slew. If an angle is out of range, rubin_scheduler uses the nearest quarter
        # turn in range.
        rotation = np.asarray(visits["rotSkyPos"], dtype=float)
        slew_s = np.asarray(model.slew_times(ra, dec, mjd, rot_sky_pos=rotation, bandname=None), dtype=float)
        unreached = ~np.isfinite(slew_s)
        if unreached.any():
            turns = [model.slew_times(ra, dec, mjd, rot_sky_pos=rotation + turn, bandname=None) for turn in QUARTER_TURNS_RAD]
            slew_s = np.where(unreached, np.fmin.reduce(turns), slew_s)
        unreached = ~np.isfinite(slew_s)
        if unreached.any():
            slew_s = np.where(unreached, model.slew_times(ra, dec, mjd, bandname=None), slew_s)
        return slew_s

    def _lengths(self, visits: Any) -> FloatArray:
        model = self.kinematics
        snaps = np.maximum(np.asarray(visits["nexp"], dtype=float), 1.0)
        return np.asarray(visits["exptime"] + snaps * model.shuttertime + (snaps - 1.0) * model.readtime, dtype=float)
