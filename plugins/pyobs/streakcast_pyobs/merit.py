"""`SatelliteMerit`: preference for tasks with clear exposures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Union

from pydantic import Field
from pyobs.robotic.scheduler.merits import Merit
from pyobs.utils.time import Time
from streakcast_astroplan.blocks import Rules, default_score

from ._shared import Settings

if TYPE_CHECKING:
    from pyobs.robotic import Task
    from pyobs.robotic.scheduler import DataProvider


class SatelliteMerit(Settings, Merit):
    """1 less the cost of streaks as a fraction of the exposures of a task, or the fraction of clear exposures: 0 to 1.

    In the merits of a task::

        - class: streakcast_pyobs.SatelliteMerit
          model: {elements: /var/elements/gp.csv, telescope: small, fov: 0.5deg}
          exposure_s: 60

    pyobs multiplies merits. After an error during the night the merit is 1; errors are counted and logged once
    (``streakcast.pyobs``).
    """

    #: ``cost``: 1 less the cost of streaks as a fraction of the exposures; the model needs a ``telescope``. ``clear``:
    #: fraction of clear exposures. Default: ``cost`` if the model has a telescope and ``blocking`` is not given.
    score: Union[str, None] = None
    #: Merit of a task without clear exposures. With 0 it would never be selected.
    worst_merit: float = Field(default=0.01, ge=0.0, lt=1.0)

    def rules(self) -> Rules:
        """Returns the requirements for the exposures of a task."""
        rules = super().rules()
        score = self.score
        if score is None:
            score = "clear" if rules.blocking is not None else default_score(self.hook().model)
        return Rules(rules.exposures, score, rules.blocking, rules.margin_s)

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
