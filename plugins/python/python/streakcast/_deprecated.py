"""Methods of `StreakModel` with earlier names or results, kept until the next minor version."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from ._mask import MaskQueries
from .typing import FloatArrayLike, FloatLike, FloatOrArray, Output, Table, TargetLike, TextLike, TimeLike


Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def _warn(name: str, replacement: str) -> None:
    warnings.warn(f"{name} is deprecated; use {replacement}", DeprecationWarning, stacklevel=3)


def _renamed(name: str, method: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Returns a method under its earlier name."""

    @wraps(method)
    def call(*arguments: Arguments.args, **options: Arguments.kwargs) -> Result:
        _warn(name, method.__name__)
        current: Callable[..., Result] = getattr(arguments[0], method.__name__)
        return current(*arguments[1:], **options)

    call.__doc__ = f"Deprecated: use `{method.__name__}`. {method.__doc__}"
    return call


class DeprecatedQueries(MaskQueries):
    """Deprecated methods of `StreakModel`; each gives a `DeprecationWarning` that names its replacement."""

    flags = _renamed("flags", MaskQueries.flag)
    clear_windows = _renamed("clear_windows", MaskQueries.windows)

    def visible_passes(
        self,
        start: TimeLike,
        end: TimeLike,
        *,
        min_altitude: FloatLike = 10.0,
        lit_only: bool = True,
        scale: str | None = None,
        output: Output = "auto",
    ) -> Table:
        """Deprecated: use `forecast`. Returns its passes between two times, by day and by night.

        Parameters
        ----------
        start, end, min_altitude, scale, output
            As for `forecast`.
        lit_only : bool
            Whether passes in the Earth's shadow are omitted.

        Returns
        -------
        QTable or dict of arrays, ``(n_passes,)`` each
            ``forecast(start=start, end=end, max_sun_altitude=None, include_dark=not lit_only).passes``
        """
        _warn("visible_passes", "forecast(start=..., end=..., max_sun_altitude=None).passes")
        forecast = self.forecast(
            start=start, end=end, min_altitude=min_altitude, max_sun_altitude=None, include_dark=not lit_only, scale=scale,
            output=output,
        )  # fmt: skip
        return forecast.passes

    def next_clear_start(
        self,
        target: TargetLike,
        start: TimeLike,
        exposure: FloatArrayLike,
        *,
        rotation: FloatArrayLike | None = None,
        band: TextLike | None = None,
        scale: str | None = None,
    ) -> FloatOrArray:
        """Deprecated: use `next_start`, which returns times. Returns the delay of each exposure.

        Parameters
        ----------
        target, start, exposure, rotation, band, scale
            As for `next_start`.

        Returns
        -------
        float or array
            Delay, seconds; NaN if there is no start within the limit. The rule is ``clear``, or, for the policy's
            ``blocking="avoid"``, ``acceptable``.
        """
        _warn("next_clear_start", "next_start, or the delays in flag")
        name = {"any": "delay_s", "avoid": "acceptable_delay_s"}[self._engine.blocking]
        column, shape = self._starts(name, target, start, exposure, rotation, band, scale)
        assert column["kind"] == "real"
        return float(column["values"][0]) if shape == () else column["values"].reshape(shape)
