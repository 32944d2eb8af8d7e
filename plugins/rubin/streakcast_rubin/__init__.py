"""Satellite avoidance for the scheduler of the Vera C. Rubin Observatory."""

from .annotate import annotate, visit_columns
from .cost_map import StreakCostBasisFunction
from .queue_manager import StreakQueueManager
from .summary import survey_maps, survey_summary

__all__ = ["StreakCostBasisFunction", "StreakQueueManager", "annotate", "survey_maps", "survey_summary", "visit_columns"]
