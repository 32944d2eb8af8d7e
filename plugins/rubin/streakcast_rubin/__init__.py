"""Satellite avoidance for the scheduler of the Vera C. Rubin Observatory."""

from .annotate import annotate, visit_columns
from .mask import StreakMaskBasisFunction
from .queue_manager import StreakQueueManager
from .reward import StreakRewardBasisFunction

__all__ = ["StreakMaskBasisFunction", "StreakQueueManager", "StreakRewardBasisFunction", "annotate", "visit_columns"]
