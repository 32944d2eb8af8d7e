"""Satellite avoidance for the scheduler of the Vera C. Rubin Observatory."""

from .annotate import annotate, visit_columns
from .cost_map import StreakCostBasisFunction
from .queue_manager import StreakQueueManager

__all__ = ["StreakCostBasisFunction", "StreakQueueManager", "annotate", "visit_columns"]
