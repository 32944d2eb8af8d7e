"""What constraint and merit share: settings, one hook for all that say the same, questions off the event loop."""

from __future__ import annotations

import asyncio
import json
import logging
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, Self, Union

import numpy as np
import numpy.typing as npt
from astropy.coordinates import SkyCoord
from pydantic import BaseModel, Field, ValidationInfo, model_validator
from pyobs.utils.time import Time
from streakcast import StreakModel
from streakcast.hosts import Hook
from streakcast_astroplan.blocks import Exposures, Rules, icrs_deg, unix_s

if TYPE_CHECKING:
    from pyobs.robotic import Task
    from pyobs.robotic.scheduler import DataProvider

# One model and one set of counters for all constraints and merits of the same model: pyobs makes new ones with each list of tasks, copies
# them, compares them and sends them to other processes, so they hold nothing but their settings.
_hooks: dict[str, Hook] = {}
_hooks_lock = threading.Lock()
# Waking a sleeping worker costs a tenth of a millisecond; a question of a night may take tens.
_worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="streakcast")

log = logging.getLogger("streakcast.pyobs")


class Settings(BaseModel):
    """Settings of `SatelliteConstraint` and `SatelliteMerit`, in YAML's units."""

    #: Arguments of `~streakcast.StreakModel`: ``elements``, ``fov``, ``limit_mag``, ...; without a site it is that of pyobs's observer.
    model: dict[str, Any]
    #: Length of one exposure, seconds; without it a task is exposed from its beginning to its end.
    exposure_s: Union[float, None] = Field(default=None, gt=0.0, le=86_400.0)
    #: From the closing of the shutter to its next opening, seconds.
    readout_s: float = Field(default=0.0, ge=0.0, le=86_400.0)
    #: Exposures of a task; as many as fit into its duration where not said.
    n_exposures: Union[int, None] = Field(default=None, ge=1, le=100_000)
    #: Satellites that count: every lit one (``any``), or those that break a limit of magnitude of the model (``avoid``).
    blocking: str = "any"
    #: Kept clear before the shutter opens and after it closes, seconds.
    margin_s: float = Field(default=1.0, ge=0.0, le=3600.0)

    @model_validator(mode="after")
    def _say_now_what_cannot_work(self, info: ValidationInfo) -> Self:
        """Opens the model: what is missing or impossible stops pyobs at its start, not a night later."""
        places = ("site", "mpc", "lat", "observer_elements", "observer_norad", "config")
        observer = (info.context or {}).get("observer")
        if observer is not None and not any(place in self.model for place in places):
            longitude, latitude, height = observer.location.geodetic
            site = {
                "name": str(observer.name or "observer"),
                "latitude_deg": float(latitude.deg),
                "longitude_deg": float(longitude.deg),
                "height_m": float(height.to_value("m")),
            }
            self.model = {**self.model, "site": site}
        self.rules().check(self.hook().model)
        return self

    def rules(self) -> Rules:
        """What is asked of exposures."""
        return Rules(Exposures(self.exposure_s, self.readout_s, self.n_exposures), blocking=self.blocking, margin_s=self.margin_s)

    def hook(self) -> Hook:
        """The model with its counters, shared by all settings of the same model."""
        key = json.dumps(self.model, sort_keys=True, default=str)
        hook = _hooks.get(key)
        if hook is None:
            with _hooks_lock:
                hook = _hooks.get(key)
                if hook is None:
                    log.info("reading satellites")
                    hook = _hooks[key] = Hook(StreakModel(**self.model), "pyobs")
        return hook

    async def share_of_task(self, time: Time, task: Task, data: DataProvider, otherwise: float) -> float:
        """Worth of a task that begins then, [0, 1]; `otherwise` where satellites cannot be looked at."""
        hook = self.hook()
        self._see(hook, data)
        target = task.target
        if target is None:
            hook.note("target", "a task without a target is taken as clear", kind="no target")
            return otherwise
        try:
            coordinates = target.coordinates(time)
            duration_s = _duration_s(task, time)
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            hook.note("target", f"a task's target or duration cannot be told: {type(error).__name__}: {error}", kind="target")
            return otherwise
        shares = await self._ask(hook, time, SkyCoord(coordinates), duration_s, np.array([otherwise]))
        return float(shares[0])

    async def shares_of(self, time: Time, coordinates: SkyCoord, data: DataProvider, otherwise: float) -> npt.NDArray[np.float64]:
        """Worth of one block at each of many places: ``(n,)``. Without a task it is one of ``n_exposures`` (1 unless said)."""
        hook = self.hook()
        self._see(hook, data)
        return await self._ask(hook, time, coordinates, 0.0, np.full(len(coordinates), otherwise))

    async def _ask(
        self, hook: Hook, time: Time, coordinates: SkyCoord, block_s: float, otherwise: npt.NDArray[np.float64]
    ) -> npt.NDArray[np.float64]:
        rules = self.rules()

        def question(model: StreakModel) -> npt.NDArray[np.float64]:
            ra_deg, dec_deg = (np.atleast_1d(angle) for angle in icrs_deg(coordinates))
            known = np.isfinite(ra_deg) & np.isfinite(dec_deg)
            if not known.all():
                hook.note("target", "targets without coordinates are taken as clear", kind="coordinates")
            shares = otherwise.copy()
            if known.any():
                shares[known] = rules.worth_of_block(model, ra_deg[known], dec_deg[known], float(unix_s(time)), block_s)
            return shares

        return await asyncio.get_running_loop().run_in_executor(_worker, hook.ask, question, otherwise)

    @staticmethod
    def _see(hook: Hook, data: DataProvider) -> None:
        """Site and clock of the host; pyobs plans ahead, so the clock is what it calls now."""
        try:
            hook.see_site(data.observer.location)
            hook.see_clock(Time.now())
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            hook.note("failed", f"site and clock are not looked at: {type(error).__name__}: {error}")


def _duration_s(task: Task, time: Time) -> float:
    """How long pyobs will give a task, seconds: what its script estimates, else its ``duration``."""
    return float(task.estimate_duration(time=time)) if task.script else float(task.duration)
