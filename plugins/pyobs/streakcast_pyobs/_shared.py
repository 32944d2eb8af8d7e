"""What constraint and merit share: settings, one hook for all that say the same, questions off the event loop."""

from __future__ import annotations

import asyncio
import json
import logging
import threading
from collections import OrderedDict
from concurrent.futures import ThreadPoolExecutor
from math import isfinite
from time import monotonic
from typing import TYPE_CHECKING, Any, Self, Union

import numpy as np
import numpy.typing as npt
from astropy.coordinates import SkyCoord
from pydantic import BaseModel, Field, ValidationInfo, model_validator
from pyobs.utils.time import Time
from streakcast import StreakModel
from streakcast.hosts import Hook
from streakcast_astroplan.blocks import Exposures, Rules, icrs_deg, unix_s
from streakcast_astroplan.memory import ClearStarts

if TYPE_CHECKING:
    from pyobs.robotic import Task
    from pyobs.robotic.scheduler import DataProvider

#: The host's clock is looked at no more often than this, seconds: that costs as much as the question.
CLOCK_LOOK_S = 10.0
#: Worth of what satellites cannot be looked at for.
CLEAR = 1.0
#: Models that are kept; an observatory has one or two, and one of an edited configuration now and then.
KEPT_HOSTS = 32
#: A model that cannot be made is tried again after so long, seconds.
AGAIN_S = 60.0


class Host:
    """A hook, and what it has seen of pyobs.

    Parameters
    ----------
    hook : Hook
        The model with its counters.
    """

    def __init__(self, hook: Hook) -> None:
        self.hook = hook
        self.memory = ClearStarts()
        self._observer: Any = None
        self._next_look_s = 0.0

    def see(self, data: DataProvider) -> None:
        """Site and clock of the host; pyobs plans ahead, so the clock is what it calls now."""

        def place() -> Any:
            observer = data.observer
            location = None if observer is self._observer else observer.location
            self._observer = observer
            return location

        self.hook.see_site(place)
        if monotonic() >= self._next_look_s:
            self._next_look_s = monotonic() + CLOCK_LOOK_S
            self.hook.see_clock(Time.now)


# One model and one set of counters for all constraints and merits of the same model: pyobs makes new ones with each list of tasks, copies
# them, compares them and sends them to other processes, so they hold nothing but their settings. The one used longest ago comes first.
_hosts: OrderedDict[str, Host] = OrderedDict()
_hosts_lock = threading.Lock()
# Until when (monotonic) a model that could not be made is not tried again.
_broken: dict[str, float] = {}
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
        return self._host().hook

    def _host(self) -> Host:
        key = json.dumps(self.model, sort_keys=True, default=str)
        with _hosts_lock:
            host = _hosts.get(key)
            if host is None:
                log.info("reading satellites")
                host = _hosts[key] = Host(Hook(StreakModel(**self.model), "pyobs"))
                while len(_hosts) > KEPT_HOSTS:
                    _hosts.popitem(last=False)
            _hosts.move_to_end(key)
        return host

    def host_or_none(self) -> Union[Host, None]:
        """What answers at night; `None` where the model cannot be made: settings came into a process whose files are missing."""
        key = json.dumps(self.model, sort_keys=True, default=str)
        if monotonic() < _broken.get(key, 0.0):
            return None
        try:
            host = self._host()
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            if key not in _broken:
                log.warning("satellites are not looked at: %s: %s (said once; tried again every %.0f s)", type(error).__name__, error, AGAIN_S)
            if len(_broken) > KEPT_HOSTS:
                _broken.clear()
            _broken[key] = monotonic() + AGAIN_S
            return None
        _broken.pop(key, None)
        return host

    async def share_of_task(self, time: Time, task: Task, data: DataProvider) -> float:
        """Worth of a task that begins then, [0, 1]; 1 where satellites cannot be looked at."""
        host = self.host_or_none()
        if host is None:
            return CLEAR
        host.see(data)
        hook = host.hook
        target = task.target
        if target is None:
            hook.note("target", "a task without a target is taken as clear", kind="no target")
            return CLEAR
        try:
            coordinates = target.coordinates(time)
            duration_s = _duration_s(task, time)
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            hook.note("target", f"a task's target or duration cannot be told: {type(error).__name__}: {error}", kind="target")
            return CLEAR
        rules = self.rules()

        def question(model: StreakModel) -> float:
            ra_deg, dec_deg = (float(angle) for angle in icrs_deg(coordinates))
            if not (isfinite(ra_deg) and isfinite(dec_deg)):
                hook.note("target", "a target without coordinates is taken as clear", kind="coordinates")
                return CLEAR
            return host.memory.worth_of_block(model, rules, ra_deg, dec_deg, float(unix_s(time)), duration_s)

        return await asyncio.get_running_loop().run_in_executor(_worker, hook.ask, question, CLEAR)

    async def shares_of(self, time: Time, coordinates: SkyCoord, data: DataProvider) -> npt.NDArray[np.float64]:
        """Worth of one block at each of many places: ``(n,)``. Without a task it is one of ``n_exposures`` (1 unless said)."""
        host, everywhere = self.host_or_none(), np.full(len(coordinates), CLEAR)
        if host is None:
            return everywhere
        host.see(data)
        hook, rules = host.hook, self.rules()

        def question(model: StreakModel) -> npt.NDArray[np.float64]:
            ra_deg, dec_deg = icrs_deg(coordinates)
            known = np.isfinite(ra_deg) & np.isfinite(dec_deg)
            if not known.all():
                hook.note("target", "a target without coordinates is taken as clear", kind="coordinates")
            shares = everywhere.copy()
            if known.any():
                shares[known] = rules.worth_of_block(model, ra_deg[known], dec_deg[known], float(unix_s(time)), 0.0)
            return shares

        return await asyncio.get_running_loop().run_in_executor(_worker, hook.ask, question, everywhere)


def _duration_s(task: Task, time: Time) -> float:
    """How long pyobs will give a task, seconds: what its script estimates, else its ``duration``."""
    return float(task.estimate_duration(time=time)) if task.script else float(task.duration)
