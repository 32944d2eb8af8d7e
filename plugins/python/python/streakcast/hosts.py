"""What a scheduler's hook needs beside a model: our errors and changed files never stop a night."""

from __future__ import annotations

import logging
import math
import os
import threading
import time as clock
from collections import Counter
from typing import Any, Callable, TypeVar, Union

from ._times import TimeLike, to_tai
from .errors import ChangedFileError
from .model import StreakModel

Answer = TypeVar("Answer")

#: A host's site may be as far from the model's, kilometres: half the width that a survey field has at the nearest satellites.
SITE_TOLERANCE_KM = 1.0
#: A host's clock may be as far from this computer's, seconds: a satellite crosses half a degree in that time.
CLOCK_TOLERANCE_S = 1.0
#: A host's "now" further than this from this computer's clock is a simulated night, not a wrong clock, seconds.
SIMULATED_S = 600.0
#: A file that is being replaced is left alone until it has not changed for so long, seconds.
SETTLED_S = 2.0
#: New files with a smaller share of the satellites that were there before are taken for broken.
LEAST_SHARE = 0.5

_EARTH_KM = 6371.0
_UNIX_EPOCH_JD = 2_440_587.5
_DAY_S = 86_400.0


class Hook:
    """Stands between a host and a model: answers when the model cannot, counts, and logs each kind of trouble once.

    Parameters
    ----------
    model : StreakModel
        What is asked. Made by the caller, so that what cannot work is said at construction, not at night.
    name : str
        The host; the logger is ``streakcast.<name>``.
    watch_s : float
        How often the model's files are looked at, seconds. Where they were replaced they are read in the background, and the new
        model answers from then on; as long as they are missing, half written or broken, the old one stays.

    Attributes
    ----------
    counts : collections.Counter
        ``asked``, ``failed``, ``reloaded``, ``kept_old`` (changed files not taken), ``site``, ``clock``, and what the host adds.
    """

    def __init__(self, model: StreakModel, name: str, *, watch_s: float = 60.0) -> None:
        if not isinstance(model, StreakModel):
            raise TypeError(f"model is a {type(model).__name__}; allowed: a streakcast.StreakModel")
        if not (math.isfinite(watch_s) and watch_s > 0.0):
            raise ValueError(f"watch_s = {watch_s}; allowed: seconds above 0")
        self._state = _State(model, name, watch_s, {})

    # Hosts copy their schedulers and ask the copies: all of one process are one hook, with one model, one count and one memory of what was said.
    def __copy__(self) -> "Hook":
        copy = type(self).__new__(type(self))
        copy._state = self._state
        return copy

    def __deepcopy__(self, memo: dict[int, Any]) -> "Hook":
        return self.__copy__()

    def __reduce__(self) -> tuple[Any, ...]:
        state = self._state
        return (_hook_of, (type(self), state.model, state.name, state.watch_s, dict(state.counts)))

    def __repr__(self) -> str:
        return f"Hook({self._state.name!r}, {dict(self.counts)})"

    @property
    def model(self) -> StreakModel:
        """The model in use."""
        return self._state.model

    @property
    def counts(self) -> "Counter[str]":
        """What happened how often; copies in one process count together."""
        return self._state.counts

    @property
    def logger(self) -> logging.Logger:
        """Where trouble is told: ``streakcast.<name>``."""
        return logging.getLogger(f"streakcast.{self._state.name}")

    def ask(self, question: Callable[[StreakModel], Answer], otherwise: Answer) -> Answer:
        """Asks the model; where that fails, whatever the reason, the host goes on with another answer.

        Parameters
        ----------
        question : callable
            Takes the model, gives the answer.
        otherwise : object
            The answer where the question fails.

        Returns
        -------
        object
        """
        self.counts["asked"] += 1
        try:
            self._watch()
            return question(self._state.model)
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            self.note("failed", f"satellites are not looked at: {type(error).__name__}: {error}")
            return otherwise

    def note(self, counter: str, message: str, *, kind: Union[str, None] = None, level: int = logging.WARNING) -> None:
        """Counts, and logs once a kind.

        Parameters
        ----------
        counter : str
            What is counted.
        message : str
            What is logged.
        kind : str, optional
            Messages of one kind are logged once; without it that is the message up to its first digit.
        level : int
            Level of the log line.
        """
        self.counts[counter] += 1
        kind = counter + ":" + (kind or message[: next((i for i, one in enumerate(message) if one.isdigit()), None)])
        with self._state.lock:
            new = kind not in self._state.said
            self._state.said.add(kind)
        if new:
            self.logger.log(level, "%s (said once; counted as '%s')", message, counter)

    def see_site(self, location: Any) -> None:
        """Holds the host's site against the model's; more than 1 km apart is noted as ``site``.

        Parameters
        ----------
        location : `~astropy.coordinates.EarthLocation` or triple
            The site, or ``(latitude, longitude, height)`` in degrees, degrees east and metres.
        """
        site = self._state.model.site
        if site is None:
            return
        if hasattr(location, "geodetic"):
            longitude, latitude, height = location.geodetic
            place = (latitude.to_value("deg"), longitude.to_value("deg"), height.to_value("m"))
        else:
            place = location
        apart_km = _distance_km((float(place[0]), float(place[1]), float(place[2])), site[1:])
        if not apart_km <= SITE_TOLERANCE_KM:
            here = f"{float(place[0]):.4f}, {float(place[1]):.4f}"
            there = f"{site.latitude_deg:.4f}, {site.longitude_deg:.4f} ({site.name})"
            message = f"the host stands at {here}, the satellite model at {there}: {apart_km:.1f} km apart; answers are the model's"
            self.note("site", message, kind="site")

    def see_clock(self, now: TimeLike, scale: Union[str, None] = None) -> None:
        """Holds the host's "now" against this computer's clock; more than a second apart is noted as ``clock``.

        Simulated nights (ten minutes and more away) pass.

        Parameters
        ----------
        now : time
            What the host takes for now.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number; the model's ``mjd_scale`` where not said.
        """
        jd1, jd2 = to_tai(now, self._state.model.mjd_scale if scale is None else scale, "now")
        days, seconds = divmod(clock.time(), _DAY_S)
        mjd = _UNIX_EPOCH_JD - 2_400_000.5 + days
        here1, here2 = to_tai(mjd, "utc", "now")
        off_s = (float(jd1) - float(here1) + float(jd2) - float(here2)) * _DAY_S - seconds
        if CLOCK_TOLERANCE_S < abs(off_s) < SIMULATED_S:
            hint = "; that is TAI read as UTC or the other way round" if 36.0 < abs(off_s) < 38.0 else ""
            message = f"the host's time is {off_s:+.1f} s off this computer's clock{hint}; a satellite crosses a field within seconds"
            self.note("clock", message, kind="clock")

    def settle(self) -> None:
        """Waits until files that are being read in the background are read."""
        reading = self._state.reading
        if reading is not None:
            reading.join()

    # New files -------------------------------------------------------------------------------------------------------

    def _watch(self) -> None:
        state = self._state
        if clock.monotonic() < state.next_look_s:
            return
        with state.lock:
            if clock.monotonic() < state.next_look_s or (state.reading is not None and state.reading.is_alive()):
                return
            state.next_look_s = clock.monotonic() + state.watch_s
        now = _signature(state.model.files)
        if now == state.seen:
            return
        missing = [path for path, stat in now.items() if stat is None]
        if missing:
            self.note("kept_old", f"{missing[0]} is missing; going on with the satellites read before", kind=f"missing {missing[0]}")
            return
        # A time in the future (another computer's clock) says nothing of how long ago it was.
        if any(stat is not None and 0.0 <= clock.time() - stat[0] / 1e9 < SETTLED_S for stat in now.values()):
            # Somebody may be writing it still.
            state.next_look_s = clock.monotonic() + min(state.watch_s, SETTLED_S)
            return
        state.seen = now
        state.reading = threading.Thread(target=self._read, name="streakcast-reload", daemon=True)
        state.reading.start()

    def _read(self) -> None:
        state = self._state
        try:
            old = state.model
            new = old.reloaded()
            moment = _UNIX_EPOCH_JD - 2_400_000.5 + clock.time() / _DAY_S
            before, after = (model.satellites(moment, scale="utc") for model in (old, new))
            if after < LEAST_SHARE * before:
                self.note("kept_old", f"the new files hold {after} satellites, {before} before; going on with these", kind="shrunk")
                return
            state.model = new
            self.note("reloaded", f"new element files taken: {after} satellites", level=logging.INFO, kind=str(new.key()))
        except Exception as error:  # noqa: BLE001 - the old model is as good as it was
            self.note("kept_old", f"the new files cannot be read, going on with the old satellites: {error}")


class _State:
    """What all copies of a hook share."""

    def __init__(self, model: StreakModel, name: str, watch_s: float, counts: dict[str, int]) -> None:
        self.model, self.name, self.watch_s = model, name, watch_s
        self.counts: Counter[str] = Counter(counts)
        self.lock = threading.Lock()
        self.said: set[str] = set()
        self.reading: Union[threading.Thread, None] = None
        self.next_look_s = clock.monotonic() + watch_s
        self.seen: dict[str, Union[tuple[int, int, int], None]] = {}
        # Files that were replaced since the model was made differ from this at the first look.
        if not model.changed_files():
            self.seen = _signature(model.files)


def _hook_of(kind: type[Hook], model: StreakModel, name: str, watch_s: float, counts: dict[str, int]) -> Hook:
    hook = kind.__new__(kind)
    try:
        hook._state = _State(model, name, watch_s, counts)
    except ChangedFileError:
        # Pickled before the day's elements came: a night goes on with the new ones.
        hook._state = _State(model.reloaded(), name, watch_s, counts)
    return hook


def _signature(files: dict[str, Any]) -> dict[str, Union[tuple[int, int, int], None]]:
    """Time of change (ns), size and inode of each file; `None` where there is none."""
    answer: dict[str, Union[tuple[int, int, int], None]] = {}
    for path in files:
        try:
            stat = os.stat(path)
            answer[path] = (stat.st_mtime_ns, stat.st_size, stat.st_ino)
        except OSError:
            answer[path] = None
    return answer


def _distance_km(one: tuple[float, float, float], other: tuple[float, float, float]) -> float:
    """Between two places, kilometres: the haversine on a sphere (0.5 % of the truth at most), and the heights."""
    (lat1, lon1), (lat2, lon2) = ([math.radians(angle) for angle in place[:2]] for place in (one, other))
    # hav(d) = hav(lat2 - lat1) + cos(lat1) cos(lat2) hav(lon2 - lon1)
    hav = math.sin((lat2 - lat1) / 2) ** 2 + math.cos(lat1) * math.cos(lat2) * math.sin((lon2 - lon1) / 2) ** 2
    along_km = 2.0 * _EARTH_KM * math.asin(min(1.0, math.sqrt(hav)))
    return math.hypot(along_km, (one[2] - other[2]) / 1000.0)

