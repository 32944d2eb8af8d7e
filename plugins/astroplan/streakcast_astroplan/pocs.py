"""Satellite streaks as a constraint for POCS (PANOPTES Observatory Control System), configured by class name."""

from __future__ import annotations

from typing import Any, Union

import numpy as np
from astropy import units as u
from astropy.time import Time
from streakcast import StreakModel
from streakcast.hosts import Hook

from .blocks import Exposures, Rules, default_score, icrs_deg, unix_s

try:
    from panoptes.pocs.scheduler.constraint import BaseConstraint
except ImportError:

    class BaseConstraint:  # type: ignore[no-redef]
        """Used as base class if POCS is not installed."""

        def __init__(self, weight: float = 1.0, default_score: float = 0.0) -> None:
            self.name, self.weight, self._score = type(self).__name__, float(weight), default_score


#: Largest age of the present time when a field is scored, seconds. POCS reads the time once, and then scores all
#: fields.
DECISION_S = 20.0


class SatelliteStreaks(BaseConstraint):  # type: ignore[misc]
    """Constraint that scores a field by the cost of streaks in its next set of exposures, or by the fraction of clear ones.

    In the configuration::

        scheduler:
          constraints:
            - name: streakcast_astroplan.pocs.SatelliteStreaks
              options:
                weight: 1.0
                readout: 5
                model: {mpc: X05, elements: /var/elements/gp.csv, telescope: small, fov: 10deg}

    Parameters
    ----------
    model : dict or StreakModel
        Arguments of `~streakcast.StreakModel`. With a ``telescope`` the score is 1 less the cost of streaks as a fraction
        of the exposures, otherwise the fraction of clear exposures.
    readout : float
        Time from the closing of the shutter to its next opening, seconds; POCS does not include it.
    min_clear_share : float
        Fields with a smaller score are vetoed. The default 0 vetoes no field, because POCS stops
        observing if all fields are vetoed.
    blocking : {"any", "avoid"}, optional
        Satellites that block an exposure: all lit ones, or those that are brighter than the model's ``limit_mag``.
        The score is then the fraction of clear exposures, also with a telescope.
    **kwargs
        ``weight`` and other arguments of POCS constraints.
    """

    def __init__(
        self,
        model: Union[StreakModel, dict[str, Any]],
        readout: float = 0.0,
        min_clear_share: float = 0.0,
        blocking: Union[str, None] = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        if not 0.0 <= min_clear_share <= 1.0:
            raise ValueError(f"min_clear_share is {min_clear_share}; allowed: 0 to 1")
        self.readout_s, self.min_clear_share, self.blocking = float(readout), float(min_clear_share), blocking
        self.hook = Hook(model if isinstance(model, StreakModel) else StreakModel(**model), "pocs")
        # Invalid settings raise an error at construction.
        self._rules(self.hook.model, 1.0, 1).check(self.hook.model)

    def get_score(self, time: Time, observer: Any, observation: Any, **kwargs: Any) -> tuple[bool, float]:
        """Returns veto and weighted score of the next set of exposures of a field.

        Parameters
        ----------
        time : `~astropy.time.Time`
            Start of the set.
        observer : `~astroplan.Observer`
            Its location is compared with the model's site.
        observation : Observation
            ``field.coord``, ``exptime`` and ``exp_set_size`` are used. In ``dark`` observations the shutter stays
            closed.
        **kwargs
            Other arguments of POCS, which are not used.

        Returns
        -------
        veto : bool
        score : float
            0 to 1, times ``weight``.
        """
        if getattr(observation, "dark", False):
            return False, self.weight
        self.hook.check_clock(lambda: _time_to_compare(time))
        self.hook.check_site(lambda: observer.location)
        share = self.hook.evaluate(lambda model: self._share(model, time, observation), 1.0)
        return share < self.min_clear_share, share * self.weight

    def _share(self, model: StreakModel, time: Time, observation: Any) -> float:
        exposure_s, count = float(u.Quantity(observation.exptime, u.s).value), int(observation.exp_set_size)
        if exposure_s == 0.0:
            return 1.0
        ra_deg, dec_deg = (np.atleast_1d(angle) for angle in icrs_deg(observation.field.coord))
        rules = self._rules(model, exposure_s, count)
        return float(rules.worth_of_block(model, ra_deg, dec_deg, float(unix_s(time)), 0.0)[0])

    def _rules(self, model: StreakModel, exposure_s: float, count: int) -> Rules:
        score = "clear" if self.blocking is not None else default_score(model)
        return Rules(Exposures(exposure_s, self.readout_s, count), score, self.blocking)

    def __str__(self) -> str:
        return "Satellite streaks"


def _time_to_compare(time: Time) -> Union[Time, None]:
    """Returns the time to compare with the clock; `None` if it is the present time or slightly earlier."""
    age_s = float((Time.now() - time).to_value(u.s))
    return None if 0.0 <= age_s < DECISION_S else time
