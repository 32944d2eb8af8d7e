"""Counters of a hook in another process, read by its parent process in shared memory (one writer, no locks)."""

from __future__ import annotations

import ctypes
import itertools
from collections import Counter
from collections.abc import Mapping
from multiprocessing.context import get_spawning_popen
from multiprocessing.sharedctypes import RawArray
from typing import Any

#: Largest number of counters. Hosts use fewer.
SLOTS = 48
NAME_BYTES = 32
MESSAGE_BYTES = 400


class _Slot(ctypes.Structure):
    _fields_ = (("count", ctypes.c_longlong), ("name", ctypes.c_char * NAME_BYTES))


class Mailbox:
    """Counters by name, and the first log message.

    It can be passed only to a process that is starting, and is not part of other pickles.
    """

    def __init__(self) -> None:
        self._slots: Any = RawArray(_Slot, SLOTS)
        self._message: Any = RawArray(ctypes.c_char, MESSAGE_BYTES)

    def __reduce__(self) -> tuple[Any, ...]:
        # Shared memory can only be passed while a process starts. Hooks that are pickled otherwise have their own
        # counts.
        return (_no_mailbox, ()) if get_spawning_popen() is None else (_restored, (self._slots, self._message))

    def put(self, name: str, count: int) -> None:
        """Writes a counter."""
        key = name.encode()[: NAME_BYTES - 1]
        for slot in self._slots:
            if slot.name in (key, b""):
                # The name is written last: if it can be read, the count is valid.
                slot.count = count
                slot.name = key
                return

    def counts(self) -> dict[str, int]:
        """Returns the counters."""
        # Slots are used in order: the first empty one is the end.
        used = itertools.takewhile(lambda slot: slot.name, self._slots)
        return {slot.name.decode(errors="replace"): int(slot.count) for slot in used}

    def keep_message(self, message: str) -> None:
        """Stores a message if none is stored yet."""
        if not self._message.value:
            self._message.value = message.encode()[: MESSAGE_BYTES - 1]

    def message(self) -> str:
        """Returns the stored message; empty if there is none."""
        return str(self._message.value.decode(errors="replace"))


class Reported(Counter[str]):
    """Counter whose changes are also written to a mailbox."""

    def __init__(self, counts: Mapping[str, int], mailbox: Mailbox) -> None:
        self._mailbox = mailbox
        super().__init__(counts)

    def __setitem__(self, name: str, count: int) -> None:
        super().__setitem__(name, count)
        self._mailbox.put(name, count)

    def update(self, *counts: Any, **more: int) -> None:
        """Adds counts one by one, because `Counter.update` does not use `__setitem__` if the counter is empty."""
        for name, count in Counter(*counts, **more).items():
            self[name] += count

    def copy(self) -> "Counter[str]":  # type: ignore[override]
        """Returns a `Counter` that is not connected to the mailbox."""
        return Counter(self)

    def __reduce__(self) -> tuple[Any, ...]:
        return (Counter, (dict(self),))


def _restored(slots: Any, message: Any) -> Mailbox:
    mailbox = Mailbox.__new__(Mailbox)
    mailbox._slots, mailbox._message = slots, message
    return mailbox


def _no_mailbox() -> Mailbox | None:
    return None
