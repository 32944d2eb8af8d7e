"""Common code of constraint and merit: settings, one hook per model, computations outside of the event loop."""

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

#: Shortest interval between checks of pyobs's site and clock, seconds. A check takes as long as a computation.
CLOCK_CHECK_S = 10.0
#: Rating if the crossings cannot be computed.
CLEAR = 1.0
#: Number of cached models. An observatory has one or two, and those of edited configurations.
CACHED_HOSTS = 32
#: Time before an invalid model is tried again, seconds.
RETRY_S = 60.0


class Host:
    """Hook with its cache, and checks of pyobs's site and clock.

    Parameters
    ----------
    hook : Hook
        Model with its counters.
    """

    def __init__(self, hook: Hook) -> None:
        self.hook = hook
        self.memory = ClearStarts()
        self._observer: Any = None
        self._next_check_s = 0.0

    def check_host(self, data: DataProvider) -> None:
        """Checks site and present time of pyobs. Planned times, which are later, are not checked."""

        def location_if_changed() -> Any:
            observer = data.observer
            location = None if observer is self._observer else observer.location
            self._observer = observer
            return location

        self.hook.check_site(location_if_changed)
        if monotonic() >= self._next_check_s:
            self._next_check_s = monotonic() + CLOCK_CHECK_S
            self.hook.check_clock(Time.now)


# Models and counters are common to all constraints and merits with the same model. pyobs creates constraints and merits
# for each list of tasks, copies and compares them, and sends them to other processes; they therefore contain only
# settings. The least recently used model is the first.
_hosts: OrderedDict[str, Host] = OrderedDict()
_hosts_lock = threading.Lock()
# Invalid models, with the (monotonic) time of the next attempt.
_broken: dict[str, float] = {}
# Starting a task in a worker thread takes 0.1 ms; a computation for a night may take tens of milliseconds.
_worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="streakcast")

log = logging.getLogger("streakcast.pyobs")


class Settings(BaseModel):
    """Settings of `SatelliteConstraint` and `SatelliteMerit`, in the units of the YAML file."""

    #: Arguments of `~streakcast.StreakModel`: ``elements``, ``fov``, ``limit_mag``, ... The default site is that of
    #: pyobs's observer.
    model: dict[str, Any]
    #: Duration of one exposure, seconds. Without it a task is one continuous exposure.
    exposure_s: Union[float, None] = Field(default=None, gt=0.0, le=86_400.0)
    #: Time from the closing of the shutter to its next opening, seconds.
    readout_s: float = Field(default=0.0, ge=0.0, le=86_400.0)
    #: Number of exposures of a task. Default: as many as fit into its duration.
    n_exposures: Union[int, None] = Field(default=None, ge=1, le=100_000)
    #: Satellites that block an exposure: all lit ones (``any``), or those that exceed a magnitude limit (``avoid``).
    blocking: Union[str, None] = None
    #: Time that must be clear before the shutter opens and after it closes, and whose streaks the cost includes, seconds.
    margin_s: float = Field(default=1.0, ge=0.0, le=3600.0)

    @model_validator(mode="after")
    def _load_model(self, info: ValidationInfo) -> Self:
        """Loads the model, so that invalid settings are reported when pyobs starts and not during the night."""
        site_keys = ("site", "mpc", "lat", "observer_elements", "observer_norad", "config")
        observer = (info.context or {}).get("observer")
        if observer is not None and not any(key in self.model for key in site_keys):
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
        """Returns the requirements for the exposures of a task."""
        return Rules(Exposures(self.exposure_s, self.readout_s, self.n_exposures), blocking=self.blocking, margin_s=self.margin_s)

    def hook(self) -> Hook:
        """Returns the hook with the model and its counters, which is common to all settings with the same model."""
        return self._host().hook

    def _host(self) -> Host:
        key = json.dumps(self.model, sort_keys=True, default=str)
        with _hosts_lock:
            host = _hosts.get(key)
            if host is None:
                log.info("reading satellites")
                host = _hosts[key] = Host(Hook(StreakModel(**self.model), "pyobs"))
                while len(_hosts) > CACHED_HOSTS:
                    _hosts.popitem(last=False)
            _hosts.move_to_end(key)
        return host

    def host_or_none(self) -> Union[Host, None]:
        """Returns the host; `None` if the model is invalid, for example in a process that cannot read its files."""
        key = json.dumps(self.model, sort_keys=True, default=str)
        if monotonic() < _broken.get(key, 0.0):
            return None
        try:
            host = self._host()
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            if key not in _broken:
                log.warning("satellites are ignored: %s: %s (logged once; retried every %.0f s)", type(error).__name__, error, RETRY_S)
            if len(_broken) > CACHED_HOSTS:
                _broken.clear()
            _broken[key] = monotonic() + RETRY_S
            return None
        _broken.pop(key, None)
        return host

    async def share_of_task(self, time: Time, task: Task, data: DataProvider) -> float:
        """Returns the rating of a task, [0, 1]; 1 if the crossings cannot be computed."""
        host = self.host_or_none()
        if host is None:
            return CLEAR
        host.check_host(data)
        hook = host.hook
        target = task.target
        if target is None:
            hook.note("target", "a task without a target is taken as clear", kind="no target")
            return CLEAR
        try:
            coordinates = target.coordinates(time)
            duration_s = _duration_s(task, time)
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            hook.note("target", f"a task's target or duration cannot be read: {type(error).__name__}: {error}", kind="target")
            return CLEAR
        rules = self.rules()

        def rating(model: StreakModel) -> float:
            ra_deg, dec_deg = (float(angle) for angle in icrs_deg(coordinates))
            if not (isfinite(ra_deg) and isfinite(dec_deg)):
                hook.note("target", "a target without coordinates is taken as clear", kind="coordinates")
                return CLEAR
            return host.memory.worth_of_block(model, rules, ra_deg, dec_deg, float(unix_s(time)), duration_s)

        return await asyncio.get_running_loop().run_in_executor(_worker, hook.evaluate, rating, CLEAR)

    async def shares_of(self, time: Time, coordinates: SkyCoord, data: DataProvider) -> npt.NDArray[np.float64]:
        """Returns the ratings of a block of ``n_exposures`` exposures (default 1) at many positions: ``(n,)``."""
        host, all_clear = self.host_or_none(), np.full(len(coordinates), CLEAR)
        if host is None:
            return all_clear
        host.check_host(data)
        hook, rules = host.hook, self.rules()

        def ratings(model: StreakModel) -> npt.NDArray[np.float64]:
            ra_deg, dec_deg = icrs_deg(coordinates)
            valid = np.isfinite(ra_deg) & np.isfinite(dec_deg)
            if not valid.all():
                hook.note("target", "a target without coordinates is taken as clear", kind="coordinates")
            shares = all_clear.copy()
            if valid.any():
                shares[valid] = rules.worth_of_block(model, ra_deg[valid], dec_deg[valid], float(unix_s(time)), 0.0)
            return shares

        return await asyncio.get_running_loop().run_in_executor(_worker, hook.evaluate, ratings, all_clear)


def _duration_s(task: Task, time: Time) -> float:
    """Returns the duration of a task, seconds: the estimate of its script, or else its ``duration``."""
    return float(task.estimate_duration(time=time)) if task.script else float(task.duration)
