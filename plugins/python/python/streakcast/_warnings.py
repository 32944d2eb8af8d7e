"""Warnings of models, issued at the line of the caller or passed to a handler."""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from collections.abc import Iterable, Iterator
from contextvars import ContextVar
from types import FrameType
from typing import Callable

from .errors import StreakcastWarning

_PACKAGE = os.path.dirname(__file__) + os.sep
# Handler for the warnings of models, used instead of Python's warning filters. It applies to one thread or task, unlike
# `warnings.catch_warnings`.
_handler: ContextVar[Callable[[str], None] | None] = ContextVar("streakcast_warning_handler", default=None)


@contextlib.contextmanager
def handle_warnings(handler: Callable[[str], None]) -> Iterator[None]:
    """Passes the warnings of models inside the context to a function. Other warnings are not affected."""
    token = _handler.set(handler)
    try:
        yield
    finally:
        _handler.reset(token)


def warn(message: str) -> None:
    """Issues a warning at the line that calls this package, or passes it to the handler."""
    handler = _handler.get()
    if handler is not None:
        handler(message)
        return
    level, frame = 1, sys._getframe()
    while _is_of_package(frame) and frame.f_back is not None:
        level, frame = level + 1, frame.f_back
    warnings.warn(message, StreakcastWarning, stacklevel=level)


def warn_of_frames(messages: Iterable[str]) -> None:
    """Issues the warnings about the frames of one call, which are not omitted in later calls: frames in memory have the same
    name."""
    for message in dict.fromkeys(messages):
        warn(message)


def _is_of_package(frame: FrameType) -> bool:
    return frame.f_code.co_filename.startswith(_PACKAGE)
