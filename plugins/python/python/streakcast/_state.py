"""State of a model: arguments, loaded satellites, files, pickles and copies."""

from __future__ import annotations

import hashlib
import json
import os
import re
import threading
import weakref
from difflib import get_close_matches
from functools import lru_cache
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from . import _core
from ._setup import ENGINE_KEYS, SKY_KEYS, document, shortened
from ._times import to_tai
from ._warnings import warn
from .errors import ChangedFileError
from .typing import FieldOptions, Json, TimeLike

if TYPE_CHECKING:
    from typing_extensions import Self, Unpack

# Satellites that are loaded in this process. They are common to models made from the same files, so that copies and
# unpickled models need little time and memory.
_sky_caches: "weakref.WeakValueDictionary[tuple[object, ...], _core.SkyCache]" = weakref.WeakValueDictionary()
_sky_caches_lock = threading.Lock()


def _after_fork() -> None:
    """Replaces the lock in a forked child process, where it may be held by a thread that does not exist there."""
    global _sky_caches_lock
    _sky_caches_lock = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


class State(TypedDict):
    """Content of a pickled model."""

    #: Document of the arguments, as returned by `document`.
    setup: dict[str, Json]
    #: Path of the configuration file.
    config: str | None
    #: Two-part Julian date, TAI.
    epoch: tuple[float, float] | None
    on_changed_file: str
    #: SHA-256 of each file by path; `None` before the files are read.
    files: dict[str, str | None] | None


class ModelState:
    """Arguments and loaded satellites, common to copies. After unpickling, satellites are read on first use."""

    def _begin(self, state: State) -> None:
        self._state = state
        self._lock = threading.Lock()
        self._opened: tuple[_core.SkyCache, _core.Engine] | None = None
        self._issued_warnings: set[str] = set()

    def _open(self) -> tuple[_core.SkyCache, _core.Engine]:
        """Returns satellites and engine. After unpickling, they are read on first use."""
        opened = self._opened
        if opened is None:
            with self._lock:
                if self._opened is None:
                    self._opened = self._load()
                opened = self._opened
        return opened

    @property
    def _engine(self) -> _core.Engine:
        return self._open()[1]

    def _load(self) -> tuple[_core.SkyCache, _core.Engine]:
        state = self._state
        text, config = json.dumps(state["setup"]), state["config"]
        hashes = {path: _sha256(path) for path in _files(text, config)}
        pickled = state["files"]
        if pickled is not None and pickled != hashes:
            changed = ", ".join(path for path, digest in hashes.items() if pickled.get(path) != digest)
            message = f"changed since this model was pickled: {changed}; create a new model, or call reloaded()"
            if state["on_changed_file"] == "error":
                raise ChangedFileError(message)
            warn(message)
        sky_text = json.dumps({key: value for key, value in state["setup"].items() if key in SKY_KEYS}, sort_keys=True)
        key = (sky_text, config, state["epoch"], tuple(hashes.items()))
        with _sky_caches_lock:
            sky_cache = _sky_caches.get(key)
            if sky_cache is None:
                sky_cache = _core.SkyCache(text, config, state["epoch"])
                for name, digest in sky_cache.element_files():
                    if hashes.get(name, digest) != digest:
                        raise ChangedFileError(f"{name} changed while it was read; retry when writing has finished")
                _sky_caches[key] = sky_cache
        engine = _core.Engine(sky_cache, text, config)
        self._state = {**state, "files": hashes}
        return sky_cache, engine

    @classmethod
    def _of_state(cls, state: State) -> "Self":
        model = cls.__new__(cls)
        model._begin(state)
        return model

    def __reduce__(self) -> tuple[object, ...]:
        return (type(self)._of_state, (self._state,))

    def __copy__(self) -> "Self":
        copy = self._of_state(self._state)
        copy._opened = self._opened
        return copy

    def __deepcopy__(self, memo: dict[int, object]) -> "Self":
        return self.__copy__()

    def __repr__(self) -> str:
        arguments = ", ".join(f"{key}={value!r}" for key, value in self._state["setup"].items())
        return f"StreakModel({arguments})"

    def with_options(self, **changes: Unpack[FieldOptions]) -> "Self":
        """Returns a model with another field, telescope, policy or band and the same satellites.

        Parameters
        ----------
        **changes
            ``fov, field, telescope, bright_share, limit_mag, limit_surface_brightness, policy, band, mag_system,
            extinction, min_probability, max_delay, mjd_scale``, ...; ``None`` removes an option.

        Returns
        -------
        StreakModel
        """
        sky_cache, _ = self._open()
        for key in changes:
            if key != "mjd_scale" and key not in ENGINE_KEYS:
                reason = "create a new StreakModel for other satellites or sites"
                nearest = get_close_matches(key, sorted(ENGINE_KEYS), 1, 0.8)
                hint = f"did you mean {nearest[0]}?" if nearest and key not in SKY_KEYS else reason
                raise TypeError(f"with_options has no argument '{shortened(key)}'; {hint}")
        given = document(changes)
        # Options that answer the same question are replaced together: a telescope also has a field, a policy has limits.
        removed = {"time_scale" if key == "mjd_scale" else key for key in changes} | set(_core.replaced_keys(list(given)))
        setup = {key: value for key, value in self._state["setup"].items() if key not in removed} | given
        model = self._of_state({**self._state, "setup": setup, "files": None})
        config = self._state["config"]
        model._opened = (sky_cache, _core.Engine(sky_cache, json.dumps(setup), config))
        hashes = self.files
        files = _files(json.dumps(setup), config)
        model._state["files"] = {path: hashes.get(path) or _sha256(path) for path in files}
        return model

    @property
    def files(self) -> dict[str, str | None]:
        """Paths and SHA-256 of all files from which this model was made."""
        self._open()
        return dict(self._state["files"] or {})

    @property
    def mjd_scale(self) -> str | None:
        """Time scale of numbers given as times."""
        return self._engine.time_scale

    def _scale(self, scale: str | None) -> str | None:
        return self.mjd_scale if scale is None else scale

    def _moment(self, time: TimeLike, scale: str | None) -> tuple[float, float]:
        jd1, jd2 = to_tai(time, self._scale(scale))
        if np.shape(jd1) != ():
            raise ValueError(f"time has the shape {np.shape(jd1)}; allowed: one time")
        return float(jd1), float(jd2)

    def changed_files(self) -> list[str]:
        """Returns the files that have changed since this model was made: missing, incompletely written, or new.

        Returns
        -------
        list of str
        """
        return [path for path, digest in self.files.items() if _sha256(path) != digest]

    def reloaded(self) -> "Self":
        """Returns a new model with the same arguments, made from the current files. This model is not changed.

        Returns
        -------
        StreakModel

        Raises
        ------
        SetupError
            If a file is missing or invalid. The old model can still be used.
        """
        model = self._of_state({**self._state, "files": None})
        model._open()
        return model

    def key(self) -> str:
        """Returns a string that determines the results of all requests: arguments and hashes of all files.

        Returns
        -------
        str
        """
        self._open()
        state = self._state
        return json.dumps([state["setup"], state["config"], state["epoch"], state["files"]], sort_keys=True)

    def _warn_once(self, warnings_of_call: list[str]) -> None:
        """Issues each warning once per model. Those with other numbers of the same length, as of other nights, are counted
        in one call, and omitted in later calls."""
        similar: dict[str, list[str]] = {}
        for message in dict.fromkeys([*self._open()[0].news(), *warnings_of_call]):
            similar.setdefault(without_numbers(message), []).append(message)
        new = {form: messages for form, messages in similar.items() if form not in self._issued_warnings}
        self._issued_warnings.update(new)
        for first, *others in new.values():
            warn(f"{first} (and {len(others)} similar warnings, with other numbers or dates)" if others else first)


@lru_cache(maxsize=256)
def without_numbers(message: str) -> str:
    """Returns a message without dates, and with one mark for each digit before the decimal point of a number.

    Digits of names, as in ``starlink-gen1`` and ``STARLINK-1008``, are kept.
    """
    message = re.sub(r"\d{4}-\d\d-\d\d(T[\d:.]+Z?)?", "date", message)
    return re.sub(r"(?<![\w.-])(\d[\d,]*)(\.\d+)?", lambda number: "#" * len(number[1].replace(",", "")), message)


def _files(setup: str, config: str | None) -> list[str]:
    """Returns all files in a configuration document."""
    return sorted(os.fspath(path) for path in _core.setup_files(setup, config))


def _sha256(path: str) -> str | None:
    """Returns the hash of a file; `None` if it cannot be read (the error is reported when the file is used)."""
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as file:
            while chunk := file.read(1 << 20):
                digest.update(chunk)
    except OSError:
        return None
    return digest.hexdigest()
