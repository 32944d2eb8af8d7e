"""`SatelliteMerit`: preference for tasks with clear exposures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import Field
from pyobs.robotic.scheduler.merits import Merit
from pyobs.utils.time import Time
from streakcast_astroplan.blocks import Rules

from ._shared import Settings

if TYPE_CHECKING:
    from pyobs.robotic import Task
    from pyobs.robotic.scheduler import DataProvider


class SatelliteMerit(Settings, Merit):
    """Fraction of clear exposures of a task, or of pixels that are not lost: 0 to 1.

    In the merits of a task::

        - class: streakcast_pyobs.SatelliteMerit
          model: {elements: /var/elements/gp.csv, fov: 0.5deg}
          exposure_s: 60

    pyobs multiplies merits. After an error during the night the merit is 1; errors are counted and logged once
    (``streakcast.pyobs``).
    """

    #: ``clear``: fraction of clear exposures. ``pixels``: fraction of pixels that are not lost; the model needs a
    #: ``telescope``.
    score: str = "clear"
    #: Merit of a task without clear exposures. With 0 it would never be selected.
    worst_merit: float = Field(default=0.01, ge=0.0, lt=1.0)

    def rules(self) -> Rules:
        """Returns the requirements for the exposures of a task."""
        rules = super().rules()
        return Rules(rules.exposures, self.score, rules.blocking, rules.margin_s)

    async def __call__(self, time: Time, task: Task, data: DataProvider) -> float:
        """Returns the merit of a task at a time.

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
        float
            ``worst_merit`` to 1.
        """
        share = await self.share_of_task(time, task, data)
        return self.worst_merit + (1.0 - self.worst_merit) * share
