"""Where the telescope stands and when it is free: what decides at which second the shutter of the next visit opens."""

from __future__ import annotations

from copy import deepcopy
from typing import Any, NamedTuple

import numpy as np
from rubin_scheduler.scheduler.model_observatory import KinemModel

from ._arrays import FloatArray

DAY_S = 86_400.0
#: A telescope that has done nothing for so long is parked, days: the host's own rule.
PARKED_AFTER_DAY = 10.0 / 1440.0
#: Conditions that are older than what we know ourselves by this much are stale, days.
STALE_DAY = 1.0 / DAY_S

#: Conditions are never older than the queue that was filled under them, days.
QUEUE_DAY = 0.25
#: As much earlier may a host name a time than before without having gone back, days: times are rounded.
BACK_DAY = 1.0 / DAY_S
QUARTER_TURNS_RAD = (-np.pi / 2.0, np.pi / 2.0, np.pi)


class Openings(NamedTuple):
    """When the shutter would open on each of several visits, and for how long."""

    #: Opening, days (MJD in the host's scale), ``(n,)``; NaN where the telescope cannot go.
    start_mjd: FloatArray
    #: Slew from where it stands, seconds, ``(n,)``.
    slew_s: FloatArray
    #: From the shutter's opening to its closing, readouts between snaps included, seconds, ``(n,)``.
    length_s: FloatArray


class Mount:
    """Follows the visits that were done, and asks the host's kinematic model how long the way to the next one is.

    The conditions that a queue manager is handed can be as old as its queue (``sim_runner`` renews them when the queue is empty),
    so the clock and the pointing come from the last visit where that is newer.

    Parameters
    ----------
    kinematics : KinemModel, optional
        The host's model with the speeds of the real mount; its defaults where left out.
    """

    def __init__(self, kinematics: KinemModel | None = None) -> None:
        self.kinematics = KinemModel() if kinematics is None else deepcopy(kinematics)
        self.last: dict[str, float | str] | None = None
        self.told_mjd = -np.inf
        self.conditions_mjd = -np.inf

    def tell(self, mjd: float) -> None:
        """The host named the time; its last word is the one that counts."""
        now = float(mjd)
        if now < self.told_mjd - BACK_DAY:
            self._went_back(now)
        self.told_mjd = now

    def _went_back(self, now: float) -> None:
        """The host began an earlier time anew: what it did later than that it has not done."""
        self.told_mjd = self.conditions_mjd = -np.inf
        if self.last is not None and float(self.last["free_mjd"]) > now + PARKED_AFTER_DAY:
            self.last = None

    def done(self, observation: Any) -> None:
        """A visit is complete, or is taken to be (``SummitWrapper`` hands back what it has only asked for, without its lengths)."""
        one = np.ravel(observation)[0]
        start, length_s = float(one["mjd"]), float(one["visittime"])
        azimuth = float(one["cummTelAz"])
        if not length_s > 0.0:
            visit = np.ravel(np.asarray(observation))
            azimuth = 0.0 if self.last is None else float(self.last["azimuth"])
            if self.last is not None:
                start = max(start, float(self.last["free_mjd"]))
                self._stand_at_last(start)
                slew_s = float(self._ways(start, visit)[0])
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
        """The latest of what is known: the conditions, the host's own word, the end of the last visit (MJD)."""
        now = float(np.max(conditions.mjd))
        if now < self.conditions_mjd - BACK_DAY:
            self._went_back(now)
        self.conditions_mjd = now
        known = [self.told_mjd] if self.last is None else [self.told_mjd, float(self.last["free_mjd"])]
        # What is further ahead than a queue can be old is of another night: the host went back in time.
        return max([now, *(one for one in known if one - now < QUEUE_DAY)])

    def openings(self, conditions: Any, visits: Any) -> Openings:
        """When the shutter would open on each of these visits of one band, were it dispatched now."""
        now = self.now(conditions)
        self._stand(conditions, now)
        slew_s = self._ways(now, visits)
        return Openings(now + slew_s / DAY_S, slew_s, self._lengths(visits))

    def _stand(self, conditions: Any, now: float) -> None:
        """Puts the model where the telescope is."""
        model, last = self.kinematics, self.last
        if conditions.mounted_bands:
            model.mount_bands(list(conditions.mounted_bands))
        fresh = float(np.max(conditions.mjd)) >= now - STALE_DAY
        model.overhead = 0.0
        if last is not None and 0.0 <= now - float(last["free_mjd"]) < PARKED_AFTER_DAY:
            self._stand_at_last(now)
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

    def _stand_at_last(self, now: float) -> None:
        """Puts the model where the last visit was."""
        model, last = self.kinematics, self.last
        if last is None:
            return
        model.parked = False
        model.current_ra_rad, model.current_dec_rad = np.array([last["ra"]]), np.array([last["dec"]])
        model.current_rot_sky_pos_rad = np.array([last["rotation"]])
        model.cumulative_azimuth_rad = float(last["azimuth"])
        self._load(str(last["band"]))
        # The readout goes on while the telescope slews; a slew is never shorter.
        model.overhead = max(0.0, model.readtime - (now - float(last["free_mjd"])) * DAY_S)

    def _load(self, band: str) -> None:
        """The host's model keeps its band in an array, and asks NumPy where it differs."""
        self.kinematics.current_band = np.array([band])

    def _ways(self, mjd: float, visits: Any) -> FloatArray:
        model = self.kinematics
        ra, dec = np.asarray(visits["RA"], dtype=float), np.asarray(visits["dec"], dtype=float)
        if not model.parked and str(visits["band"][0]) != str(model.current_band[0]):
            # The rotator turns while the filters are exchanged.
            return np.asarray(model.slew_times(ra, dec, mjd, bandname=None) + model.band_changetime, dtype=float)
        # Else it turns on the way. From an angle out of its reach the host goes on in quarter turns, to the nearest in reach.
        rotation = np.asarray(visits["rotSkyPos"], dtype=float)
        way_s = np.asarray(model.slew_times(ra, dec, mjd, rot_sky_pos=rotation, bandname=None), dtype=float)
        lost = ~np.isfinite(way_s)
        if lost.any():
            turns = [model.slew_times(ra, dec, mjd, rot_sky_pos=rotation + turn, bandname=None) for turn in QUARTER_TURNS_RAD]
            way_s = np.where(lost, np.fmin.reduce(turns), way_s)
        lost = ~np.isfinite(way_s)
        if lost.any():
            way_s = np.where(lost, model.slew_times(ra, dec, mjd, bandname=None), way_s)
        return way_s

    def _lengths(self, visits: Any) -> FloatArray:
        model = self.kinematics
        snaps = np.maximum(np.asarray(visits["nexp"], dtype=float), 1.0)
        return np.asarray(visits["exptime"] + snaps * model.shuttertime + (snaps - 1.0) * model.readtime, dtype=float)
