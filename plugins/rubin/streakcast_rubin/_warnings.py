"""What the model warns of (old element sets, records left out) goes into the hook's log and counters."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Iterator

from streakcast import StreakcastWarning
from streakcast.hosts import Hook


@contextlib.contextmanager
def told(hook: Hook) -> Iterator[None]:
    """Notes the model's warnings as ``warned``; a model says each of them once. Warnings of others go on as they were."""
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        yield
    for one in heard:
        if issubclass(one.category, StreakcastWarning):
            # Numbers differ from night to night; what is warned of is the words.
            kind = "".join(letter for letter in str(one.message) if not letter.isdigit())[:80]
            hook.note("warned", str(one.message), kind=kind)
        else:
            warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)
