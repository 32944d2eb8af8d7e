"""Integration of a model into a scheduler: errors of streakcast and changed files do not stop the scheduler."""

from __future__ import annotations

import logging
import math
import threading
import time as clock
import weakref
from collections import Counter
from functools import lru_cache
from typing import Callable, TypeVar

from ._core import UnknownPositionsError
from ._hook_state import HookState, RemoteHook, distance_km, signature
from ._mailbox import Mailbox, Reported
from ._quantities import is_of, scalar
from ._times import to_tai
from ._warnings import handle_warnings
from .model import StreakModel
from .typing import FloatArray, FloatLike, PlaceLike, TimeLike

Answer = TypeVar("Answer")

#: Accepted distance between the site of the host and that of the model, km: half the width of a survey field at the
#: nearest satellites.
SITE_TOLERANCE_KM = 1.0
#: Accepted difference between the clocks of the host and of this computer, seconds. A satellite moves by half a degree
#: in this time.
CLOCK_TOLERANCE_S = 1.0
#: Difference between the clocks, seconds, above which the host is taken to simulate a night.
SIMULATED_NIGHT_S = 600.0
#: Time without changes after which a new file is read, seconds.
SETTLED_S = 2.0
#: Longest delay before unreadable files are read again, seconds. The first delay is `watch_s`; it is doubled each time.
MAX_RETRY_S = 1800.0
#: Longest wait for new files before another process is started, seconds.
MAX_WAIT_S = 10.0
#: Number of hooks in other processes whose counters are read. The least recently active ones are dropped, except those
#: that are still referenced here.
MAX_REMOTE_HOOKS = 32
#: New files are rejected if they contain less than this fraction of the previous number of satellites.
MIN_SATELLITE_SHARE = 0.5

_UNIX_EPOCH_MJD = 40_587.0
_DAY_S = 86_400.0


class Hook:
    """Adapter between a host and a model: returns a fallback after errors, counts events, and logs each problem once.

    Parameters
    ----------
    model : StreakModel
        Model to use. It is created by the caller, so that invalid arguments are errors at construction.
    name : str
        Name of the host; the logger is ``streakcast.<name>``.
    watch_s : float or `~astropy.units.Quantity`
        Interval between checks of the files of the model, seconds. New files are read in the background, and the new
        model is then used. While files are missing, incomplete or invalid, the old model is used, and files are read
        again after ``watch_s``, with a delay that is doubled each time, up to half an hour.

    Attributes
    ----------
    counts : collections.Counter
        ``asked`` (calls of `evaluate`), ``failed``, ``unknown`` (elements too old to predict positions), ``reloaded``, ``kept_old`` (changed files that were rejected),
        ``warned`` (warnings of the model: old element sets, rejected records), ``site`` and ``clock`` (different or not
        readable), and counters of the host.
    """

    def __init__(self, model: StreakModel, name: str, *, watch_s: FloatLike = 60.0) -> None:
        if not isinstance(model, StreakModel):
            raise TypeError(f"model is a {type(model).__name__}; allowed: a streakcast.StreakModel")
        interval_s = scalar(watch_s, "s", "watch_s")
        if not (math.isfinite(interval_s) and interval_s > 0.0):
            raise ValueError(f"watch_s is {interval_s}; allowed: seconds above 0")
        self._state = HookState(model, name, interval_s, Counter())

    # Hosts copy their schedulers and use the copies. All copies in a process therefore use the same model, counters and
    # logged messages.
    def __copy__(self) -> "Hook":
        copy = type(self).__new__(type(self))
        copy._state = self._state
        return copy

    def __deepcopy__(self, memo: dict[int, object]) -> "Hook":
        return self.__copy__()

    def __reduce__(self) -> tuple[object, ...]:
        state = self._state
        return (_hook_of, (type(self), state.model, state.name, state.watch_s, dict(self.counts), state.mailbox))

    def __repr__(self) -> str:
        return f"Hook({self._state.name!r}, {dict(self.counts)})"

    @property
    def model(self) -> StreakModel:
        """Model in use."""
        return self._state.model

    @property
    def counts(self) -> "Counter[str]":
        """Counts of events, common to copies in one process and to hooks made by `for_process`."""
        if self._state.remote_hooks:
            self._collect()
        return self._state.counts

    @property
    def logger(self) -> logging.Logger:
        """Logger for problems: ``streakcast.<name>``."""
        return logging.getLogger(f"streakcast.{self._state.name}")

    def evaluate(self, function: Callable[[StreakModel], Answer], fallback: Answer) -> Answer:
        """Returns the result of a function of the model, or a fallback if the function raises an exception.

        Parameters
        ----------
        function : callable
            Function with the model as argument.
        fallback : object
            Value that is returned if the function raises an exception.

        Returns
        -------
        object
        """
        self._state.counts["asked"] += 1
        try:
            with handle_warnings(self._warned):
                self._watch()
                return function(self._state.model)
        except UnknownPositionsError as error:
            self.note("unknown", f"satellites are ignored: {error}")
            return fallback
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            self.note("failed", f"satellites are ignored: {type(error).__name__}: {error}")
            return fallback

    def note(self, counter: str, message: str, *, kind: str | None = None, level: int = logging.WARNING) -> None:
        """Counts an event, and logs each kind of message once.

        Parameters
        ----------
        counter : str
            Name of the counter.
        message : str
            Log message.
        kind : str, optional
            Messages of the same kind are logged once; default: the message up to its first digit.
        level : int
            Level of the log line.
        """
        self._state.counts[counter] += 1
        kind = counter + ":" + (kind or message[: next((i for i, one in enumerate(message) if one.isdigit()), None)])
        with self._state.lock:
            is_new = kind not in self._state.logged_kinds
            self._state.logged_kinds.add(kind)
        if is_new:
            if self._state.mailbox is not None and level >= logging.WARNING:
                self._state.mailbox.keep_message(message)
            self.logger.log(level, "%s (logged once; counted as '%s')", message, counter)

    def check_site(self, location: PlaceLike | Callable[[], PlaceLike | None]) -> None:
        """Compares the site of the host with that of the model.

        Increases the counter ``site`` if they differ by more than 1 km, or if the site of the host cannot be read.

        Parameters
        ----------
        location : `~astropy.coordinates.EarthLocation` or triple, or callable
            Site, or ``(latitude, longitude, height)`` in degrees, degrees east and metres; or a function that reads it
            from the host, so that its exceptions are caught here. If the function returns `None`, nothing is compared.
        """
        try:
            site = self._state.model.site
            if site is None:
                return
            host_site = location() if callable(location) else location
            if host_site is None:
                if callable(location):
                    return
                raise TypeError("location is None")
            if is_of("astropy.coordinates", "EarthLocation", host_site):
                longitude, latitude, height = getattr(host_site, "geodetic")
                host_site = (latitude, longitude, height)
            latitude, longitude, height = host_site
            here = (scalar(latitude, "deg", "latitude"), scalar(longitude, "deg", "longitude"), scalar(height, "m", "height"))
            apart_km = distance_km(here, site[1:])
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            self.note("site", f"the host's site cannot be read: {type(error).__name__}: {error}", kind="unseen")
            return
        if not apart_km <= SITE_TOLERANCE_KM:
            there = f"{site.latitude_deg:.4f}, {site.longitude_deg:.4f} ({site.name})"
            message = (
                f"the host's site is {here[0]:.4f}, {here[1]:.4f}, the satellite model's {there}: {apart_km:.1f} km apart; "
                "the model's site is used"
            )
            self.note("site", message, kind="site")

    def check_clock(self, now: TimeLike | Callable[[], TimeLike | None], scale: str | None = None) -> None:
        """Compares the time of the host with the clock of this computer.

        Increases the counter ``clock`` if they differ by more than 1 s, or if the time of the host cannot be read.
        Simulated nights, with differences of ten minutes or more, are accepted.

        Parameters
        ----------
        now : time or callable
            Present time of the host, or a function that returns it. If the function returns `None`, nothing is
            compared.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number; default: the model's ``mjd_scale``.
        """
        try:
            host_now = now() if callable(now) else now
            if host_now is None:
                return
            jd1, jd2 = to_tai(host_now, self._state.model.mjd_scale if scale is None else scale, "now")
            days, seconds = divmod(clock.time(), _DAY_S)
            here1, here2 = _start_of_day(days)
            off_s = (float(jd1) - float(here1) + float(jd2) - float(here2)) * _DAY_S - seconds
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            self.note("clock", f"the host's time cannot be read: {type(error).__name__}: {error}", kind="unseen")
            return
        if CLOCK_TOLERANCE_S < abs(off_s) < SIMULATED_NIGHT_S:
            hint = "; TAI was probably read as UTC or the other way round" if 36.0 < abs(off_s) < 38.0 else ""
            message = f"the host's time is {off_s:+.1f} s off this computer's clock{hint}; a satellite crosses a field within seconds"
            self.note("clock", message, kind="clock")

    def settle(self, most_s: FloatLike | None = None) -> None:
        """Waits until the files that are being read in the background have been read, at most ``most_s`` seconds."""
        reading = self._state.reading
        if reading is not None:
            reading.join(None if most_s is None else scalar(most_s, "s", "most_s"))

    # Other processes -------------------------------------------------------------------------------------------------

    def for_process(self) -> "Hook":
        """Returns a hook for another process that is about to start (forked or spawned). Changed files are read first.

        Its counters and its first log message are read in shared memory, by ``counts`` and by the next call of this
        method, also if that process was killed. At least the 32 most recently active hooks are read. New element files
        that the other process reads do not affect this hook. The hook contains the current model: call this method for
        each process.

        Returns
        -------
        Hook
        """
        self._collect()
        state = self._state
        try:
            # Files are checked now, because a process that starts before the next check, or while files are read, would
            # use the old files.
            state.next_check_s = 0.0
            self._watch()
            self.settle(MAX_WAIT_S)
            mailbox = Mailbox()
            with state.lock:
                model, seen = state.model, state.loaded_signature()
            remote = type(self).__new__(type(self))
            remote._state = HookState(model, state.name, state.watch_s, Reported({}, mailbox), mailbox, seen=seen)
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            self.note("failed", f"the counters of another process cannot be read: {type(error).__name__}: {error}")
            return self.__copy__()
        with state.lock:
            state.remote_hooks.append(RemoteHook(weakref.ref(remote._state), mailbox))
        return remote

    def _collect(self) -> None:
        """Adds the counts of hooks in other processes since the last call."""
        state, messages = self._state, []
        with state.lock:
            for remote in list(state.remote_hooks):
                counts = remote.mailbox.counts()
                if counts != remote.collected:
                    for name, count in counts.items():
                        state.counts[name] += count - remote.collected.get(name, 0)
                    remote.collected = counts
                    # The most recently active hooks are last in the list.
                    state.remote_hooks.remove(remote)
                    state.remote_hooks.append(remote)
                message = remote.mailbox.message()
                if message and "process:" + message not in state.logged_kinds:
                    state.logged_kinds.add("process:" + message)
                    messages.append(message)
            # It is not known here whether a process still runs: `Process` deletes its arguments when it starts.
            inactive = state.remote_hooks[:-MAX_REMOTE_HOOKS]
            state.remote_hooks = [one for one in inactive if one.state() is not None] + state.remote_hooks[len(inactive) :]
        for message in messages:
            self.logger.warning("in another process: %s (logged once)", message)

    # New files -------------------------------------------------------------------------------------------------------

    def _watch(self) -> None:
        """Checks the files if the interval between checks has passed."""
        state = self._state
        if clock.monotonic() < state.next_check_s:
            return
        with state.lock:
            if clock.monotonic() < state.next_check_s or (state.reading is not None and state.reading.is_alive()):
                return
            state.next_check_s = clock.monotonic() + state.watch_s
        now = signature(state.model.files)
        if now == state.seen and clock.monotonic() < state.retry_at_s:
            return
        missing = [path for path, stat in now.items() if stat is None]
        if missing:
            self.note("kept_old", f"{missing[0]} is missing; the satellites read before stay in use", kind=f"missing {missing[0]}")
            return
        # If the modification time is in the future (from the clock of another computer), the age is unknown.
        if any(stat is not None and 0.0 <= clock.time() - stat[0] / 1e9 < SETTLED_S for stat in now.values()):
            # The file may not be written completely.
            state.next_check_s = clock.monotonic() + min(state.watch_s, SETTLED_S)
            return
        if now != state.seen:
            state.retry_delay_s = 0.0
        with state.lock:
            state.seen = now
            state.reading = threading.Thread(target=self._read, name="streakcast-reload", daemon=True)
            state.reading.start()

    def _read(self) -> None:
        state = self._state
        try:
            with handle_warnings(self._warned):
                old = state.model
                new = old.reloaded()
                moment = _UNIX_EPOCH_MJD + clock.time() / _DAY_S
                before, after = (model.satellites(moment, scale="utc") for model in (old, new))
            if after >= MIN_SATELLITE_SHARE * before:
                state.model, state.retry_at_s = new, math.inf
                self.note("reloaded", f"new element files read: {after} satellites", level=logging.INFO, kind=str(new.key()))
                return
            self.note("kept_old", f"the new files contain {after} satellites, {before} before; the old ones stay in use", kind="shrunk")
        except Exception as error:  # noqa: BLE001 - the old model remains usable
            self.note("kept_old", f"the new files cannot be read, the old satellites stay in use: {error}")
        # Incomplete files may be completed without a new modification time, and a file server may recover.
        state.retry_delay_s = min(max(2.0 * state.retry_delay_s, state.watch_s), max(MAX_RETRY_S, state.watch_s))
        state.retry_at_s = clock.monotonic() + state.retry_delay_s

    def _warned(self, message: str) -> None:
        """Counts a warning of the model. Its kind is the text without digits, which differ from night to night."""
        self.note("warned", message, kind="".join(letter for letter in message if not letter.isdigit())[:80])


@lru_cache(maxsize=1)
def _start_of_day(days: float) -> tuple[FloatArray, FloatArray]:
    """Returns the start of a UTC day, given in days since 1970, as Julian date in TAI. A night of visits asks for one day."""
    return to_tai(_UNIX_EPOCH_MJD + days, "utc", "now")


def _hook_of(
    kind: type[Hook], model: StreakModel, name: str, watch_s: float, counts: dict[str, int], mailbox: Mailbox | None = None
) -> Hook:
    hook = kind.__new__(kind)
    counter: "Counter[str]" = Counter(counts) if mailbox is None else Reported(counts, mailbox)
    try:
        hook._state = HookState(model, name, watch_s, counter, mailbox)
    except Exception:  # noqa: BLE001 - a hook never stops its host
        # Files have changed, are missing or incomplete. They are read by the first call that finds them complete.
        model = type(model)._of_state({**model._state, "files": None})
        hook._state = HookState(model, name, watch_s, counter, mailbox, seen={})
    return hook
