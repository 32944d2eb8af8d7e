"""Satellites for the scheduler of the Vera C. Rubin Observatory: visits that no streak crosses."""

from .mask import StreakMaskBasisFunction
from .queue_manager import StreakQueueManager

__all__ = ["StreakMaskBasisFunction", "StreakQueueManager"]
