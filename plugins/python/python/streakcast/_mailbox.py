"""What a hook in another process counts, for the one that it came from: shared memory with a single writer, so that nobody waits."""

from __future__ import annotations

import ctypes
import itertools
from collections import Counter
from collections.abc import Mapping
from multiprocessing.context import get_spawning_popen
from multiprocessing.sharedctypes import RawArray
from typing import Any, Union

#: Counters that find room; no host has as many.
SLOTS = 48
NAME_BYTES = 32
WORDS_BYTES = 400


class _Slot(ctypes.Structure):
    _fields_ = (("count", ctypes.c_longlong), ("name", ctypes.c_char * NAME_BYTES))


class Mailbox:
    """Counters by name, and the first line that would have been logged. It goes along to processes that begin, and into no other pickle."""

    def __init__(self) -> None:
        self._slots: Any = RawArray(_Slot, SLOTS)
        self._words: Any = RawArray(ctypes.c_char, WORDS_BYTES)

    def __reduce__(self) -> tuple[Any, ...]:
        # Memory is handed on when a process begins, never later: what is pickled otherwise counts for itself.
        return (_nowhere, ()) if get_spawning_popen() is None else (_made_of, (self._slots, self._words))

    def put(self, name: str, count: int) -> None:
        """Writes how often something happened."""
        key = name.encode()[: NAME_BYTES - 1]
        for slot in self._slots:
            if slot.name in (key, b""):
                # The name last: who reads it finds the count.
                slot.count = count
                slot.name = key
                return

    def counts(self) -> dict[str, int]:
        """What was written."""
        # Slots are taken in turn: nothing stands behind an empty one.
        used = itertools.takewhile(lambda slot: slot.name, self._slots)
        return {slot.name.decode(errors="replace"): int(slot.count) for slot in used}

    def say(self, words: str) -> None:
        """Keeps a line, where none is kept yet."""
        if not self._words.value:
            self._words.value = words.encode()[: WORDS_BYTES - 1]

    def words(self) -> str:
        """The line; empty where there is none."""
        return str(self._words.value.decode(errors="replace"))


class Reported(Counter[str]):
    """Counts that go into a mailbox as they are made."""

    def __init__(self, counts: Mapping[str, int], mailbox: Mailbox) -> None:
        self._mailbox = mailbox
        super().__init__(counts)

    def __setitem__(self, name: str, count: int) -> None:
        super().__setitem__(name, count)
        self._mailbox.put(name, count)

    def update(self, *counts: Any, **more: int) -> None:
        """Adds counts one by one; `Counter` itself fills an empty one past `__setitem__`."""
        for name, count in Counter(*counts, **more).items():
            self[name] += count

    def copy(self) -> "Counter[str]":  # type: ignore[override]
        """A plain `Counter`: a copy goes into no mailbox."""
        return Counter(self)

    def __reduce__(self) -> tuple[Any, ...]:
        return (Counter, (dict(self),))


def _made_of(slots: Any, words: Any) -> Mailbox:
    mailbox = Mailbox.__new__(Mailbox)
    mailbox._slots, mailbox._words = slots, words
    return mailbox


def _nowhere() -> Union[Mailbox, None]:
    return None
