"""Schedules of astroplan without satellite streaks.

`SatelliteStreakConstraint` is a constraint like any other of astroplan; `clear_windows` and `streak_table` are tables. The modules
``pocs`` and ``m4opt`` hand the same answers to POCS and M4OPT, and need these installed only to stand among their own classes.
"""

from .constraint import SatelliteStreakConstraint
from .tables import clear_windows, streak_table

__all__ = ["SatelliteStreakConstraint", "clear_windows", "streak_table"]
__version__ = "0.1.0"
