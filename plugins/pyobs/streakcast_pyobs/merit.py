"""`SatelliteMerit`: the clearer its exposures, the sooner a task is taken."""

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
    """The share of a task's exposures that are clear, or of its pixels that are left: 0 to 1.

    Among the merits of a task::

        - class: streakcast_pyobs.SatelliteMerit
          model: {elements: /var/elements/gp.csv, fov: 0.5deg}
          exposure_s: 60

    pyobs multiplies merits. Whatever fails at night is answered with 1, counted and logged once (``streakcast.pyobs``).
    """

    #: ``clear``: share of the exposures that are clear; ``pixels``: share of the pixels that are left (the model needs a ``telescope``).
    score: str = "clear"
    #: What a wholly spoilt task is worth; 0 would keep it from being taken at all.
    worst_merit: float = Field(default=0.01, ge=0.0, lt=1.0)

    def rules(self) -> Rules:
        """What is asked of exposures."""
        rules = super().rules()
        return Rules(rules.exposures, self.score, rules.blocking, rules.margin_s)

    async def __call__(self, time: Time, task: Task, data: DataProvider) -> float:
        """The merit of a task that begins then.

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
        float
            ``worst_merit`` to 1.
        """
        share = await self.share_of_task(time, task, data)
        return self.worst_merit + (1.0 - self.worst_merit) * share
