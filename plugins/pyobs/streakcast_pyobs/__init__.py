"""Satellite streaks for pyobs: `SatelliteConstraint` and `SatelliteMerit`, used by ``class:`` in YAML."""

from .constraint import SatelliteConstraint
from .merit import SatelliteMerit

__all__ = ["SatelliteConstraint", "SatelliteMerit"]
__version__ = "0.1.0"
