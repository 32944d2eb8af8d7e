"""`SatelliteConstraint`: tasks begin only when their exposures are clear."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import astroplan
import numpy as np
import numpy.typing as npt
from astropy.coordinates import SkyCoord
from pydantic import Field
from pyobs.robotic.scheduler.constraints import Constraint
from pyobs.utils.time import Time
from streakcast_astroplan import SatelliteStreakConstraint

from ._shared import Settings

if TYPE_CHECKING:
    from pyobs.robotic import Task
    from pyobs.robotic.scheduler import DataProvider


class SatelliteConstraint(Settings, Constraint):
    """True where enough of a task's exposures are clear of satellites.

    Among the constraints of a scheduler or a task::

        - class: streakcast_pyobs.SatelliteConstraint
          model: {elements: /var/elements/gp.csv, fov: 0.5deg, limit_mag: 8}
          exposure_s: 60
          readout_s: 5
          blocking: avoid

    A long task is nearly always crossed by something faint: veto the bright ones (``blocking: avoid`` with ``limit_mag``), or use
    `SatelliteMerit`. Whatever fails at night is answered with True, counted and logged once (``streakcast.pyobs``).
    """

    #: pyobs may ask cheap constraints first.
    cost: float = 50.0
    target_dependent: bool = True
    #: Share of the exposures that must be clear.
    min_clear_share: float = Field(default=1.0, gt=0.0, le=1.0)

    async def __call__(self, time: Time, task: Task, data: DataProvider) -> bool:
        """Whether a task may begin then.

        Parameters
        ----------
        time : Time
            Beginning of the task.
        task : Task
            Its target, and its duration.
        data : DataProvider
            Its observer's location is held against the model's site.

        Returns
        -------
        bool
            False also where the target is below the horizon.
        """
        return await self.share_of_task(time, task, data) >= self.min_clear_share

    async def filter_skycoord(self, time: Time, coords: SkyCoord, data: DataProvider) -> npt.NDArray[np.bool_]:
        """Which of many places would be clear: one exposure, or ``n_exposures`` of them, that begin then.

        Parameters
        ----------
        time : Time
            Beginning of the exposures.
        coords : SkyCoord, ``(n,)``
            The places. pyobs names no duration here: without ``exposure_s`` only the margins are looked at.
        data : DataProvider
            As above.

        Returns
        -------
        array of bool, ``(n,)``
        """
        return np.asarray(await self.shares_of(time, coords, data) >= self.min_clear_share, dtype=np.bool_)

    def to_astroplan(self) -> astroplan.Constraint:
        """The same for pyobs's ``AstroplanScheduler``: all cells of time of a block are clear, or with ``min_clear_share`` below 1 a score.

        That scheduler calls this in pyobs's own process before each schedule, and asks in a process of its own. New element files are
        taken here first (then the event loop waits for them, 10 s at most); what is counted there is found in ``hook().counts`` here.
        """
        host = self.host_or_none()
        if host is None:
            return _Open()
        return SatelliteStreakConstraint(
            host.hook.for_process(),
            self.exposure_s,
            readout=self.readout_s,
            n_exposures=self.n_exposures,
            boolean_constraint=self.min_clear_share == 1.0,
            blocking=self.blocking,
            margin=self.margin_s,
            # pyobs lays blocks over a grid of time.
            each="cell",
        )


class _Open(astroplan.Constraint):  # type: ignore[misc]
    """Lets everything through."""

    def compute_constraint(self, times: Any, observer: Any, targets: Any) -> npt.NDArray[np.bool_]:
        return np.ones(np.broadcast_shapes(times.shape, () if targets is None else targets.shape), dtype=bool)
