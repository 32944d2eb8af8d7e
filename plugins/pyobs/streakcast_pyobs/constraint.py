"""`SatelliteConstraint`: tasks start only if their exposures are clear of satellites."""

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
    """Constraint that enough exposures of a task are clear of satellites.

    In the constraints of a scheduler or a task::

        - class: streakcast_pyobs.SatelliteConstraint
          model: {elements: /var/elements/gp.csv, fov: 0.5deg, limit_mag: 8}
          exposure_s: 60
          readout_s: 5
          blocking: avoid

    A long task is nearly always crossed by a faint satellite: veto only bright ones (``blocking: avoid`` with
    ``limit_mag``), or use `SatelliteMerit`. After an error during the night the result is True; errors are counted and
    logged once (``streakcast.pyobs``).
    """

    #: Relative cost. pyobs may evaluate constraints with lower cost first.
    cost: float = 50.0
    target_dependent: bool = True
    #: Smallest fraction of exposures that must be clear.
    min_clear_share: float = Field(default=1.0, gt=0.0, le=1.0)

    async def __call__(self, time: Time, task: Task, data: DataProvider) -> bool:
        """Returns True if a task may start at a time.

        Parameters
        ----------
        time : Time
            Start of the task.
        task : Task
            Target and duration of the task are used.
        data : DataProvider
            Location of its observer is compared with the model's site.

        Returns
        -------
        bool
            False if too many exposures are not clear, or if the target is below the horizon.
        """
        return await self.share_of_task(time, task, data) >= self.min_clear_share

    async def filter_skycoord(self, time: Time, coords: SkyCoord, data: DataProvider) -> npt.NDArray[np.bool_]:
        """Returns for each position whether ``n_exposures`` exposures (default 1) that start at a time are clear.

        Parameters
        ----------
        time : Time
            Start of the exposures.
        coords : SkyCoord, ``(n,)``
            Positions. pyobs passes no duration here: without ``exposure_s`` only the margins are checked.
        data : DataProvider
            As above.

        Returns
        -------
        array of bool, ``(n,)``
        """
        return np.asarray(await self.shares_of(time, coords, data) >= self.min_clear_share, dtype=np.bool_)

    def to_astroplan(self) -> astroplan.Constraint:
        """Returns the constraint for pyobs's ``AstroplanScheduler``. With ``min_clear_share`` below 1 it is a score.

        The scheduler calls this in the main process of pyobs before each schedule, and evaluates the constraint in
        another process. New element files are read here first (the event loop waits for at most 10 s), and counts of
        the other process are added to ``hook().counts`` here.
        """
        host = self.host_or_none()
        if host is None:
            return _AlwaysClear()
        return SatelliteStreakConstraint(
            host.hook.for_process(),
            self.exposure_s,
            readout=self.readout_s,
            n_exposures=self.n_exposures,
            boolean_constraint=self.min_clear_share == 1.0,
            blocking=self.blocking,
            margin=self.margin_s,
            # pyobs schedules blocks on a grid of times.
            each="cell",
        )


class _AlwaysClear(astroplan.Constraint):  # type: ignore[misc]
    """Constraint that is always satisfied."""

    def compute_constraint(self, times: Any, observer: Any, targets: Any) -> npt.NDArray[np.bool_]:
        return np.ones(np.broadcast_shapes(times.shape, () if targets is None else targets.shape), dtype=bool)
