"""What can go wrong beside `StreakcastError` (a question without an answer) and `SetupError` (a model that cannot be made)."""

from ._core import SetupError


class ChangedFileError(SetupError):
    """A file that a model was made of has other content now than when the model was pickled."""


class StreakcastWarning(UserWarning):
    """What the user should know of an answer: old elements, rejected records, synthetic satellites. Each is told once a model."""
