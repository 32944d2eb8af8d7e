"""Stacker and metric for MAF of ``rubin_sim``, which read the view ``observations_streaks`` of an annotated database.

It requires ``rubin_sim``, and is not imported with the package.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._arrays import Visits

try:
    from rubin_sim.maf import BaseMetric, BaseStacker, MetricBundle
except ImportError as error:
    raise ImportError("streakcast_rubin.maf requires rubin_sim; install it with: pip install rubin-sim") from error

__all__ = ["StreakCoaddLossMetric", "StreakStacker"]


class StreakStacker(BaseStacker):
    """Adds the share of the open shutter that streaks cost, and the depth of the rest.

    ``streak_cost_fraction`` is C / t, with the cost C of the streaks (``streak_cost_s``) of a visit with t seconds of open
    shutter. ``fiveSigmaDepth_streaks`` is the five-sigma depth plus 1.25 log10(1 - C / t) mag, -inf if the whole visit is
    lost. Both are NaN for visits with the verdict ``unknown`` or ``invalid``.

    Parameters
    ----------
    cost_col, exp_time_col, m5_col : str
        Columns of the cost, of the time with open shutter, and of the depth.
    """

    cols_added = ["streak_cost_fraction", "fiveSigmaDepth_streaks"]

    def __init__(
        self, cost_col: str = "streak_cost_s", exp_time_col: str = "visitExposureTime", m5_col: str = "fiveSigmaDepth"
    ) -> None:
        self.cost_col, self.exp_time_col, self.m5_col = cost_col, exp_time_col, m5_col
        self.cols_req = [cost_col, exp_time_col, m5_col]
        self.cols_added_dtypes = [float, float]
        self.units = ["", "mag"]

    def _run(self, sim_data: Visits, cols_present: bool = False) -> Visits:
        if not cols_present:
            with np.errstate(divide="ignore", invalid="ignore"):
                lost = sim_data[self.cost_col].astype(float) / sim_data[self.exp_time_col]
                sim_data["streak_cost_fraction"] = lost
                sim_data["fiveSigmaDepth_streaks"] = sim_data[self.m5_col] + 1.25 * np.log10(np.maximum(1.0 - lost, 0.0))
        return sim_data


def _register() -> None:
    """Registers the columns of the stacker, so that a metric of one of them uses it without ``stacker_list``.

    MAF lists the stackers when its metrics are imported, and looks for columns of later ones in the database.
    """
    stacker = StreakStacker()
    for info in (BaseMetric.col_info, BaseMetric.col_registry.col_info, MetricBundle.col_info):
        info.source_dict.update(dict.fromkeys(stacker.cols_added, StreakStacker))
        info.unit_dict.update(zip(stacker.cols_added, stacker.units))


_register()


class StreakCoaddLossMetric(BaseMetric):
    """Loss in depth of the coadded visits of a slice: -1.25 log10(1 - sum of C / sum of t), mag.

    It is ``coadd_loss_mag`` of `survey_summary`. Visits with the verdict ``unknown`` or ``invalid`` do not count. Slices
    without other visits, and those of which all visits are lost, are masked.

    Parameters
    ----------
    cost_col, exp_time_col : str
        Columns of the cost of the streaks and of the time with open shutter, seconds.
    **kwargs
        As for ``BaseMetric``.
    """

    def __init__(self, cost_col: str = "streak_cost_s", exp_time_col: str = "visitExposureTime", **kwargs: Any) -> None:
        self.cost_col, self.exp_time_col = cost_col, exp_time_col
        super().__init__(col=[cost_col, exp_time_col], **{"metric_name": "Streak coadd loss", "units": "mag", **kwargs})

    def run(self, data_slice: Visits, slice_point: Any = None) -> Any:
        cost_s, exposure_s = (data_slice[name].astype(float) for name in (self.cost_col, self.exp_time_col))
        known = np.isfinite(cost_s) & np.isfinite(exposure_s)
        open_s = exposure_s[known].sum()
        if not cost_s[known].sum() < open_s:
            return self.badval
        return -1.25 * np.log10(1.0 - cost_s[known].sum() / open_s)
