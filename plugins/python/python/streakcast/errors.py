"""Exceptions and warnings other than `StreakcastError` (invalid request) and `SetupError` (invalid model arguments)."""

from ._core import SetupError


class ChangedFileError(SetupError):
    """A file used by a model has changed since the model was pickled."""


class StreakcastWarning(UserWarning):
    """Limitation of a result: old element sets, rejected records, synthetic satellites. Issued once per model; those about
    a frame, for each call."""
