"""What a scheduler's hook needs beside a model: our errors and changed files never stop a night."""

from __future__ import annotations

import logging
import math
import threading
import time as clock
import weakref
from collections import Counter
from typing import Any, Callable, TypeVar, Union

from ._hook_state import HookState, Lent, distance_km, signature
from ._mailbox import Mailbox, Reported
from ._state import heard_by
from ._times import TimeLike, to_tai
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
#: Files that could not be read are tried again after `watch_s`, then after twice as long each time, up to this, seconds.
RETRY_MOST_S = 1800.0
#: Before another process begins new files are waited for so long, seconds.
PATIENCE_S = 10.0
#: Of so many hooks in other processes counts are read, those heard of last; and of all that are held here.
LENT_MOST = 32
#: New files with a smaller share of the satellites that were there before are taken for broken.
LEAST_SHARE = 0.5

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
        model answers from then on; as long as they are missing, half written or broken, the old one stays, and they are tried again
        after ``watch_s``, then after twice as long each time, at least every half an hour.

    Attributes
    ----------
    counts : collections.Counter
        ``asked``, ``failed``, ``reloaded``, ``kept_old`` (changed files not taken, each time), ``warned`` (what the model warns of: old
        element sets, records left out), ``site`` and ``clock`` (too far off, or not to be looked at), and what the host adds.
    """

    def __init__(self, model: StreakModel, name: str, *, watch_s: float = 60.0) -> None:
        if not isinstance(model, StreakModel):
            raise TypeError(f"model is a {type(model).__name__}; allowed: a streakcast.StreakModel")
        if not (math.isfinite(watch_s) and watch_s > 0.0):
            raise ValueError(f"watch_s = {watch_s}; allowed: seconds above 0")
        self._state = HookState(model, name, watch_s, Counter())

    # Hosts copy their schedulers and ask the copies: all of one process are one hook, with one model, one count and one memory of what was said.
    def __copy__(self) -> "Hook":
        copy = type(self).__new__(type(self))
        copy._state = self._state
        return copy

    def __deepcopy__(self, memo: dict[int, Any]) -> "Hook":
        return self.__copy__()

    def __reduce__(self) -> tuple[Any, ...]:
        state = self._state
        return (_hook_of, (type(self), state.model, state.name, state.watch_s, dict(self.counts), state.mailbox))

    def __repr__(self) -> str:
        return f"Hook({self._state.name!r}, {dict(self.counts)})"

    @property
    def model(self) -> StreakModel:
        """The model in use."""
        return self._state.model

    @property
    def counts(self) -> "Counter[str]":
        """What happened how often; copies in one process, and hooks made by `for_process`, count together."""
        if self._state.lent:
            self._collect()
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
        self._state.counts["asked"] += 1
        try:
            with heard_by(self._warned):
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
        self._state.counts[counter] += 1
        kind = counter + ":" + (kind or message[: next((i for i, one in enumerate(message) if one.isdigit()), None)])
        with self._state.lock:
            new = kind not in self._state.said
            self._state.said.add(kind)
        if new:
            if self._state.mailbox is not None and level >= logging.WARNING:
                self._state.mailbox.say(message)
            self.logger.log(level, "%s (said once; counted as '%s')", message, counter)

    def see_site(self, location: Any) -> None:
        """Holds the host's site against the model's; more than 1 km apart is noted as ``site``, and so is a site that cannot be looked at.

        Parameters
        ----------
        location : `~astropy.coordinates.EarthLocation` or triple, or callable
            The site, or ``(latitude, longitude, height)`` in degrees, degrees east and metres; or a function that looks it up in the
            host, so that an error there is caught here; `None` from that function: nothing to hold.
        """
        try:
            site = self._state.model.site
            if site is None:
                return
            place = location() if callable(location) else location
            if place is None and callable(location):
                return
            if hasattr(place, "geodetic"):
                longitude, latitude, height = place.geodetic
                place = (latitude.to_value("deg"), longitude.to_value("deg"), height.to_value("m"))
            here = (float(place[0]), float(place[1]), float(place[2]))
            apart_km = distance_km(here, site[1:])
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            self.note("site", f"the host's site cannot be looked at: {type(error).__name__}: {error}", kind="unseen")
            return
        if not apart_km <= SITE_TOLERANCE_KM:
            there = f"{site.latitude_deg:.4f}, {site.longitude_deg:.4f} ({site.name})"
            message = (
                f"the host stands at {here[0]:.4f}, {here[1]:.4f}, the satellite model at {there}: {apart_km:.1f} km apart; "
                "answers are the model's"
            )
            self.note("site", message, kind="site")

    def see_clock(self, now: Union[TimeLike, Callable[[], TimeLike]], scale: Union[str, None] = None) -> None:
        """Holds the host's "now" against this computer's clock; more than a second apart is noted as ``clock``, and so is no time at all.

        Simulated nights (ten minutes and more away) pass.

        Parameters
        ----------
        now : time or callable
            What the host takes for now, or a function that asks it; `None` from that function: nothing to hold.
        scale : {"utc", "tai", "tt"}, optional
            Scale of a bare number; the model's ``mjd_scale`` where not said.
        """
        try:
            moment = now() if callable(now) else now
            if moment is None:
                return
            jd1, jd2 = to_tai(moment, self._state.model.mjd_scale if scale is None else scale, "now")
            days, seconds = divmod(clock.time(), _DAY_S)
            here1, here2 = to_tai(_UNIX_EPOCH_JD - 2_400_000.5 + days, "utc", "now")
            off_s = (float(jd1) - float(here1) + float(jd2) - float(here2)) * _DAY_S - seconds
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            self.note("clock", f"the host's time cannot be looked at: {type(error).__name__}: {error}", kind="unseen")
            return
        if CLOCK_TOLERANCE_S < abs(off_s) < SIMULATED_S:
            hint = "; that is TAI read as UTC or the other way round" if 36.0 < abs(off_s) < 38.0 else ""
            message = f"the host's time is {off_s:+.1f} s off this computer's clock{hint}; a satellite crosses a field within seconds"
            self.note("clock", message, kind="clock")

    def settle(self, most_s: Union[float, None] = None) -> None:
        """Waits until files that are being read in the background are read, or for some seconds at most."""
        reading = self._state.reading
        if reading is not None:
            reading.join(most_s)

    # Other processes -------------------------------------------------------------------------------------------------

    def for_process(self) -> "Hook":
        """A hook for another process that is about to begin, forked or spawned: with new files taken, and counted here.

        What it counts there is read here through shared memory, by ``counts`` and by the next call of this, also where that process was
        killed; of what it would have logged, the first line. At least the 32 hooks heard of last are read. New element files that it
        finds itself stay its own. It holds the model as it is now: ask for one for each process.

        Returns
        -------
        Hook
        """
        self._collect()
        state = self._state
        try:
            # A process that begins before the next look, or while files are read, would have the old ones.
            state.next_look_s = 0.0
            self._watch()
            self.settle(PATIENCE_S)
            mailbox = Mailbox()
            with state.lock:
                model, seen = state.model, state.taken()
            lent = type(self).__new__(type(self))
            lent._state = HookState(model, state.name, state.watch_s, Reported({}, mailbox), mailbox, seen=seen)
        except Exception as error:  # noqa: BLE001 - a hook never stops its host
            self.note("failed", f"another process cannot be followed: {type(error).__name__}: {error}")
            return self.__copy__()
        with state.lock:
            state.lent.append(Lent(weakref.ref(lent._state), mailbox))
        return lent

    def _collect(self) -> None:
        """Takes over what hooks in other processes counted since the last time."""
        state, told = self._state, []
        with state.lock:
            for lent in list(state.lent):
                counts = lent.mailbox.counts()
                if counts != lent.taken:
                    for name, count in counts.items():
                        state.counts[name] += count - lent.taken.get(name, 0)
                    lent.taken = counts
                    # Those heard of last stand last.
                    state.lent.remove(lent)
                    state.lent.append(lent)
                words = lent.mailbox.words()
                if words and "process:" + words not in state.said:
                    state.said.add("process:" + words)
                    told.append(words)
            # Nothing says here whether a process still runs: `Process` forgets its arguments when it starts.
            silent = state.lent[:-LENT_MOST]
            state.lent = [one for one in silent if one.state() is not None] + state.lent[len(silent) :]
        for words in told:
            self.logger.warning("in a process of its own: %s (said once)", words)

    # New files -------------------------------------------------------------------------------------------------------

    def _watch(self) -> None:
        """Looks at the files where it is time to."""
        state = self._state
        if clock.monotonic() < state.next_look_s:
            return
        with state.lock:
            if clock.monotonic() < state.next_look_s or (state.reading is not None and state.reading.is_alive()):
                return
            state.next_look_s = clock.monotonic() + state.watch_s
        now = signature(state.model.files)
        if now == state.seen and clock.monotonic() < state.again_at_s:
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
        if now != state.seen:
            state.wait_s = 0.0
        with state.lock:
            state.seen = now
            state.reading = threading.Thread(target=self._read, name="streakcast-reload", daemon=True)
            state.reading.start()

    def _read(self) -> None:
        state = self._state
        try:
            with heard_by(self._warned):
                old = state.model
                new = old.reloaded()
                moment = _UNIX_EPOCH_JD - 2_400_000.5 + clock.time() / _DAY_S
                before, after = (model.satellites(moment, scale="utc") for model in (old, new))
            if after >= LEAST_SHARE * before:
                state.model, state.again_at_s = new, math.inf
                self.note("reloaded", f"new element files taken: {after} satellites", level=logging.INFO, kind=str(new.key()))
                return
            self.note("kept_old", f"the new files hold {after} satellites, {before} before; going on with these", kind="shrunk")
        except Exception as error:  # noqa: BLE001 - the old model is as good as it was
            self.note("kept_old", f"the new files cannot be read, going on with the old satellites: {error}")
        # Half-written files may become whole without a new time of change, and a file server comes back.
        state.wait_s = min(max(2.0 * state.wait_s, state.watch_s), max(RETRY_MOST_S, state.watch_s))
        state.again_at_s = clock.monotonic() + state.wait_s

    def _warned(self, message: str) -> None:
        """What the model warns of. Numbers differ from night to night; what is warned of is the words."""
        self.note("warned", message, kind="".join(letter for letter in message if not letter.isdigit())[:80])


def _hook_of(
    kind: type[Hook], model: StreakModel, name: str, watch_s: float, counts: dict[str, int], mailbox: Union[Mailbox, None] = None
) -> Hook:
    hook = kind.__new__(kind)
    counter: "Counter[str]" = Counter(counts) if mailbox is None else Reported(counts, mailbox)
    try:
        hook._state = HookState(model, name, watch_s, counter, mailbox)
    except Exception:  # noqa: BLE001 - a hook never stops its host
        # Files changed since, or are missing or half written just now: they are read by the first question that finds them whole.
        model = type(model)._of_state({**model._state, "files": None})
        hook._state = HookState(model, name, watch_s, counter, mailbox, seen={})
    return hook
