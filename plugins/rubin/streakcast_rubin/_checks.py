"""Checks of options at construction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

BANDS = ("u", "g", "r", "i", "z", "y", "default")


def at_least(name: str, value: float, least: float, most: float = math.inf) -> float:
    number = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    if not number or not least <= value <= most or value == math.inf:
        raise ValueError(f"{name} is {value!r}; allowed: a number from {least:g} {'upwards' if most == math.inf else f'to {most:g}'}")
    return value


def whole(name: str, value: Any, least: int) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise ValueError(f"{name} is {value!r}; allowed: a whole number from {least} upwards")
    return int(value)


def limits(limit_mag: Any) -> Any:
    """Checks a magnitude limit, or limits by band."""
    if limit_mag is None:
        return None
    if isinstance(limit_mag, Mapping):
        unknown = [band for band in limit_mag if band not in BANDS]
        if unknown:
            raise ValueError(f"limit_mag has the unknown band '{unknown[0]}'; allowed: {', '.join(BANDS)}")
        return {band: at_least(f"limit_mag['{band}']", one, -30.0, 40.0) for band, one in limit_mag.items()}
    return at_least("limit_mag", limit_mag, -30.0, 40.0)
