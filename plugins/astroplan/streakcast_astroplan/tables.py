"""Tables of clear windows of targets and of the streaks in a schedule."""

from __future__ import annotations

from typing import Any, Iterable, Sequence, Union

import numpy as np
from astroplan import FixedTarget, Observer, Schedule
from astroplan.target import get_skycoord
from astropy import units as u
from astropy.coordinates import SkyCoord
from astropy.table import Column, QTable
from astropy.time import Time
from streakcast import StreakModel
from streakcast.hosts import Hook

from .blocks import Exposures, icrs_deg, seconds, times_of, unix_s


def clear_windows(
    model: StreakModel,
    targets: Union[FixedTarget, SkyCoord, Sequence[FixedTarget]],
    time_range: Any,
    exposure: Any,
    *,
    observer: Union[Observer, None] = None,
    min_altitude: Any = 0.0 * u.deg,
    blocking: Union[str, None] = None,
) -> QTable:
    """Returns the intervals in which an exposure of each target can start and no satellite crosses it.

    Parameters
    ----------
    model : StreakModel
        Satellites, site, field of view and limits.
    targets : `~astroplan.FixedTarget`, list of them, or `~astropy.coordinates.SkyCoord`
        Targets.
    time_range : pair of `~astropy.time.Time`
        Earliest shutter opening and latest shutter closing, at most one day apart.
    exposure : `~astropy.units.Quantity` or float
        Duration of the exposure; seconds if it has no unit.
    observer : `~astroplan.Observer`, optional
        Its location is compared with the model's site. A distance above 1 km is logged.
    min_altitude : `~astropy.units.Quantity` or float
        Smallest altitude of the target while the shutter is open, degrees, without refraction.
    blocking : {"any", "avoid"}, optional
        Satellites that block an exposure: all lit ones, or those that exceed a magnitude limit of the model's policy.
        Default: that of the policy.

    Returns
    -------
    QTable, ``(n_windows,)``
        ``target`` (name, or index), ``first_start`` and ``last_start`` (`~astropy.time.Time`, UTC, both included),
        ``length`` (s) between them; ordered by target and time. A target without windows has no row.
    """
    if observer is not None:
        Hook(model, "astroplan").check_site(observer.location)
    coordinates = get_skycoord(targets)
    names = _names(targets, coordinates)
    ra_deg, dec_deg = (np.atleast_1d(angle) for angle in icrs_deg(coordinates))
    start, end = time_range
    found = model.windows(
        (ra_deg, dec_deg), start, end, seconds(exposure, "exposure"), min_altitude=min_altitude, blocking=blocking
    )
    table = QTable()
    table["target"] = Column([names[index] for index in found.target], dtype=str)
    table["first_start"] = found.first_start
    table["last_start"] = found.last_start
    table["length"] = found.length_s * u.s
    return table


def streak_table(
    model: StreakModel,
    blocks: Union[Schedule, Iterable[Any]],
    *,
    exposure: Any = None,
    readout: Any = 0.0,
    n_exposures: Union[int, None] = None,
    include_dark: bool = False,
) -> QTable:
    """Returns all satellites that cross the exposures of a schedule.

    Parameters
    ----------
    model : StreakModel
        Satellites, site, field of view and limits.
    blocks : `~astroplan.Schedule` or iterable of `~astroplan.ObservingBlock`
        The scheduled blocks; blocks without a start are omitted.
    exposure, readout, n_exposures
        Exposures in a block, as for `SatelliteStreakConstraint`. Blocks made by ``from_exposures`` use their own.
        Without these arguments a block is one exposure.
    include_dark : bool
        Whether to include crossings entirely inside the Earth's shadow.

    Returns
    -------
    QTable, ``(n_streaks,)``
        ``block`` (index in the schedule), ``target``, ``exposure`` (index in the block), ``exposure_start``, then the
        columns of `StreakModel.passes`: entry, exit, magnitude, length, width, probability.
    """
    default = Exposures(None if exposure is None else seconds(exposure, "exposure"), seconds(readout, "readout"), n_exposures)
    listed = list(blocks.observing_blocks if isinstance(blocks, Schedule) else blocks)
    scheduled = [block for block in listed if getattr(block, "target", None) is not None and block.start_time is not None]
    rows: list[tuple[int, str, int]] = []
    starts_s, lengths_s, ra_deg, dec_deg = [], [], [], []
    for index, block in enumerate(scheduled):
        offsets_s, length_s = _exposures_of(block, default).in_block(float((block.end_time - block.start_time).to_value(u.s)))
        ra, dec = icrs_deg(get_skycoord(block.target))
        for number, offset_s in enumerate(offsets_s):
            rows.append((index, str(block.target.name), number))
            starts_s.append(float(unix_s(block.start_time)) + offset_s)
            lengths_s.append(length_s)
            ra_deg.append(float(ra))
            dec_deg.append(float(dec))
    starts = times_of(np.array(starts_s))
    pointings = (np.array(ra_deg), np.array(dec_deg))
    table: QTable = model.passes(pointings, starts, np.array(lengths_s), include_dark=include_dark, output="qtable")
    which = np.asarray(table["exposure_id"], dtype=int)
    del table["exposure_id"]
    table.add_column(Time(starts[which], format="isot", precision=3), name="exposure_start", index=0)
    table.add_column(Column([rows[row][2] for row in which], dtype=int), name="exposure", index=0)
    table.add_column(Column([rows[row][1] for row in which], dtype=str), name="target", index=0)
    table.add_column(Column([rows[row][0] for row in which], dtype=int), name="block", index=0)
    return table


def _exposures_of(block: Any, default: Exposures) -> Exposures:
    if getattr(block, "time_per_exposure", None) is None:
        return default
    return Exposures(
        seconds(block.time_per_exposure, "time_per_exposure"), seconds(block.readout_time, "readout_time"), int(block.number_exposures)
    )


def _names(targets: Any, coordinates: SkyCoord) -> list[str]:
    if isinstance(targets, SkyCoord):
        return [str(index) for index in range(coordinates.size)]
    listed = [targets] if coordinates.isscalar else list(targets)
    return [str(getattr(target, "name", None) or index) for index, target in enumerate(listed)]
