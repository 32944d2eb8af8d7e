"""Satellite streaks as a constraint for astroplan.

`SatelliteStreakConstraint` is an astroplan constraint; `clear_windows` and `streak_table` return tables. The modules
``pocs`` and ``m4opt`` provide the constraint to POCS and M4OPT.
"""

from .constraint import SatelliteStreakConstraint
from .tables import clear_windows, streak_table

__all__ = ["SatelliteStreakConstraint", "clear_windows", "streak_table"]
__version__ = "0.1.0"
