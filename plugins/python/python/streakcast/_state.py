"""What a model is made of, and how it comes back: files, pickles, copies."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import threading
import warnings
import weakref
from collections.abc import Iterator
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, Callable, Union

import numpy as np

from . import _core
from ._setup import ENGINE_KEYS, SKY_KEYS, document
from ._times import TimeLike, to_tai
from .errors import ChangedFileError, StreakcastWarning

if TYPE_CHECKING:
    from typing_extensions import Self

# Skies of this process, shared by models made of the same files: copies and unpickled models cost nothing.
_skies: "weakref.WeakValueDictionary[tuple[Any, ...], _core.Skies]" = weakref.WeakValueDictionary()
_skies_lock = threading.Lock()
# Who hears of what a model warns, instead of Python's filters. Of this thread and task alone, which `warnings.catch_warnings` is not.
_listener: "ContextVar[Union[Callable[[str], None], None]]" = ContextVar("streakcast_listener", default=None)


def _after_fork() -> None:
    """A thread that read while this process was forked is not there in the child, and would hold the lock for ever."""
    global _skies_lock
    _skies_lock = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


@contextlib.contextmanager
def heard_by(listener: Callable[[str], None]) -> Iterator[None]:
    """Hands what models warn of in here to a function; warnings of others go on as they were."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


def _warn(message: str, stacklevel: int) -> None:
    listener = _listener.get()
    if listener is not None:
        listener(message)
    else:
        warnings.warn(message, StreakcastWarning, stacklevel=stacklevel + 1)


class ModelState:
    """Arguments, and the satellites read by them: on first use after unpickling, and shared by copies."""

    def _begin(self, state: dict[str, Any]) -> None:
        self._state = state
        self._lock = threading.Lock()
        self._opened: Union[tuple[_core.Skies, _core.Engine], None] = None
        self._told: set[str] = set()

    def _open(self) -> tuple[_core.Skies, _core.Engine]:
        """Satellites and engine; read on first use after unpickling."""
        opened = self._opened
        if opened is None:
            with self._lock:
                if self._opened is None:
                    self._opened = self._made()
                opened = self._opened
        return opened

    def _made(self) -> tuple[_core.Skies, _core.Engine]:
        state = self._state
        text, config = json.dumps(state["setup"]), state["config"]
        hashes = {path: _sha256(path) for path in _files(text, config)}
        known = state["files"]
        if known is not None and known != hashes:
            changed = ", ".join(path for path, digest in hashes.items() if known.get(path) != digest)
            message = f"changed since this model was pickled: {changed}; make the model anew, or call reloaded()"
            if state["on_changed_file"] == "error":
                raise ChangedFileError(message)
            _warn(message, stacklevel=4)
        sky_text = json.dumps({key: value for key, value in state["setup"].items() if key in SKY_KEYS}, sort_keys=True)
        key = (sky_text, config, state["epoch"], tuple(hashes.items()))
        with _skies_lock:
            skies = _skies.get(key)
            if skies is None:
                skies = _core.Skies(text, config, state["epoch"])
                for name, digest in skies.element_files():
                    if hashes.get(name, digest) != digest:
                        raise ChangedFileError(f"{name} changed while it was read; try again when it is whole")
                _skies[key] = skies
        engine = _core.Engine(skies, text, config)
        self._state = {**state, "files": hashes}
        return skies, engine

    @classmethod
    def _of_state(cls, state: dict[str, Any]) -> "Self":
        model = cls.__new__(cls)
        model._begin(state)
        return model

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self)._of_state, (self._state,))

    def __copy__(self) -> "Self":
        copy = self._of_state(self._state)
        copy._opened = self._opened
        return copy

    def __deepcopy__(self, memo: dict[int, Any]) -> "Self":
        return self.__copy__()

    def __repr__(self) -> str:
        said = ", ".join(f"{key}={value!r}" for key, value in self._state["setup"].items())
        return f"StreakModel({said})"

    def with_options(self, **changes: Any) -> "Self":
        """The same satellites with another field, telescope, policy or band; they are shared, not read again.

        Parameters
        ----------
        **changes
            ``fov, field, telescope, limit_mag, policy, band, mag_system, extinction, min_probability, max_delay, mjd_scale``, ...;
            ``None`` takes one away.

        Returns
        -------
        StreakModel
        """
        skies, _ = self._open()
        for key in changes:
            if key != "mjd_scale" and key not in ENGINE_KEYS:
                raise TypeError(f"with_options has no argument '{key}'; make a new StreakModel for other satellites or sites")
        setup = {**self._state["setup"], **document(changes)}
        for key, value in changes.items():
            if value is None:
                setup.pop("time_scale" if key == "mjd_scale" else key, None)
        model = self._of_state({**self._state, "setup": setup, "files": None})
        config = self._state["config"]
        model._opened = (skies, _core.Engine(skies, json.dumps(setup), config))
        known = self._state["files"]
        files = _files(json.dumps(setup), config)
        model._state["files"] = {path: known.get(path) or _sha256(path) for path in files}
        return model

    @property
    def files(self) -> dict[str, Union[str, None]]:
        """Paths of all files that this model was made of, with the SHA-256 of each."""
        self._open()
        return dict(self._state["files"])

    @property
    def mjd_scale(self) -> Union[str, None]:
        """The scale of bare numbers of time."""
        return self._open()[1].time_scale

    def _scale(self, scale: Union[str, None]) -> Union[str, None]:
        return self.mjd_scale if scale is None else scale

    def _moment(self, time: TimeLike, scale: Union[str, None]) -> tuple[float, float]:
        jd1, jd2 = to_tai(time, self._scale(scale))
        if np.shape(jd1) != ():
            raise ValueError(f"time has the shape {np.shape(jd1)}; allowed: one moment")
        return float(jd1), float(jd2)

    def changed_files(self) -> list[str]:
        """Files whose content is not what this model was made of: missing, half written, or new.

        Returns
        -------
        list of str
        """
        self._open()
        return [path for path, digest in self._state["files"].items() if _sha256(path) != digest]

    def reloaded(self) -> "Self":
        """A model of the same arguments from the files as they are now. This one stays as it is, and good.

        Returns
        -------
        StreakModel

        Raises
        ------
        SetupError
            Where a file is missing or broken: who asks goes on with the old model.
        """
        model = self._of_state({**self._state, "files": None})
        model._open()
        return model

    def key(self) -> str:
        """What an answer depends on besides the question, in one text: arguments and hashes of all files.

        Returns
        -------
        str
        """
        self._open()
        return json.dumps([self._state[part] for part in ("setup", "config", "epoch", "files")], sort_keys=True)

    def _tell(self, skies: _core.Skies, told: list[str]) -> None:
        """Each warning once a model."""
        for message in [*skies.news(), *told]:
            if message not in self._told:
                self._told.add(message)
                _warn(message, stacklevel=3)


def _files(setup: str, config: Union[str, None]) -> list[str]:
    """All files that a setup names."""
    return sorted(os.fspath(path) for path in _core.setup_files(setup, config))


def _sha256(path: str) -> Union[str, None]:
    """Hash of a file's content; `None` where it cannot be read (whoever needs it says why)."""
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as file:
            while chunk := file.read(1 << 20):
                digest.update(chunk)
    except OSError:
        return None
    return digest.hexdigest()
