"""Schedules of astroplan, checked by a brute-force computation without streakcast.

Tests marked `whole` make further schedules, and run with `plugins/test.sh --all`.
"""

import time

import pytest
from astroplan import (
    AltitudeConstraint,
    AtNightConstraint,
    MoonSeparationConstraint,
    ObservingBlock,
    PriorityScheduler,
    Schedule,
    SequentialScheduler,
    Transitioner,
)
from astropy import units as u

from conftest import FOV_DEG, START
from streakcast_astroplan import SatelliteStreakConstraint, streak_table

BLOCK = 4 * u.min
EXPOSURE = 40 * u.s
READOUT = 5 * u.s


class Timed(SatelliteStreakConstraint):
    """Constraint that measures its processor time, which does not depend on other programs."""

    spent_s = 0.0
    calls = 0

    def compute_constraint(self, times, observer, targets):
        begun = time.process_time()
        try:
            return super().compute_constraint(times, observer, targets)
        finally:
            self.spent_s += time.process_time() - begun
            self.calls += 1


def schedule_of(scheduler, observer, targets, constraint):
    blocks = [ObservingBlock(target, BLOCK, priority) for priority, target in enumerate(targets)]
    # Typical constraints of observers.
    constraints = [AltitudeConstraint(min=25 * u.deg), AtNightConstraint.twilight_nautical(), MoonSeparationConstraint(min=15 * u.deg)]
    if constraint is not None:
        constraints.append(constraint)
    transitioner = Transitioner(slew_rate=2 * u.deg / u.s)
    made = scheduler(constraints, observer, transitioner=transitioner, time_resolution=20 * u.s, gap_time=1 * u.min)
    begun = time.process_time()
    schedule = made(blocks, Schedule(START, START + 4 * u.hour))
    return schedule, time.process_time() - begun


@pytest.fixture(
    scope="module",
    params=[PriorityScheduler, pytest.param(SequentialScheduler, marks=pytest.mark.whole)],
    ids=lambda one: one.__name__,
)
def schedules(request, observer, targets, model):
    """Returns schedules without and with the constraint, and the time needed."""
    constraint = Timed(model, exposure=EXPOSURE, readout=READOUT)
    without, _ = schedule_of(request.param, observer, targets, None)
    with_it, total_s = schedule_of(request.param, observer, targets, constraint)
    share = constraint.spent_s / (total_s - constraint.spent_s)
    print(
        f"\n{request.param.__name__}: {len(without.observing_blocks)} blocks without, {len(with_it.observing_blocks)} with; "
        f"{constraint.calls} calls, {constraint.spent_s:.2f} s of {total_s:.2f} s: {100 * share:.1f} % of the scheduler's own time"
    )
    return request.param, without, with_it, constraint


def exposures_of(scheduler, block):
    """Returns the exposures of a block: the whole block for PriorityScheduler, single ones for SequentialScheduler."""
    length_s = (block.end_time - block.start_time).to_value(u.s)
    if scheduler is PriorityScheduler:
        return [(block.start_time, length_s)]
    step_s = (EXPOSURE + READOUT).to_value(u.s)
    count = int((length_s + READOUT.to_value(u.s) + 1e-3) / step_s)
    return [(block.start_time + number * step_s * u.s, EXPOSURE.to_value(u.s)) for number in range(count)]


def streaked_targets(sky, scheduler, schedule):
    return [
        block.target.name
        for block in schedule.observing_blocks
        if any(sky.streaks(block.target.coord, start, length_s, FOV_DEG / 2) for start, length_s in exposures_of(scheduler, block))
    ]


def test_valid_no_block_of_a_constrained_schedule_has_a_streak_by_sgp4_and_astropy(schedules, sky):
    scheduler, without, with_it, constraint = schedules
    assert len(streaked_targets(sky, scheduler, without)) >= 3
    assert streaked_targets(sky, scheduler, with_it) == []
    # Blocks are delayed, and not omitted.
    assert len(with_it.observing_blocks) >= 38
    assert constraint.hook.counts["asked"] == constraint.calls > 0
    assert constraint.hook.counts["failed"] == 0


def test_verif_the_streak_table_agrees(schedules, model, sky):
    scheduler, without, with_it, _ = schedules
    options = {} if scheduler is PriorityScheduler else {"exposure": EXPOSURE, "readout": READOUT}
    table = streak_table(model, without, **options)
    # Satellites at the edge of the field are ignored by the brute force.
    assert set(streaked_targets(sky, scheduler, without)) <= set(table["target"])
    length = EXPOSURE if options else BLOCK
    whole = (table["mid_utc"] > table["exposure_start"]) & (table["mid_utc"] < table["exposure_start"] + length) & (table["lit_fraction"] == 1.0)
    inside = table[whole & (table["min_separation_deg"] < (FOV_DEG / 2 - 0.1) * u.deg)]
    assert set(inside["target"]) <= set(streaked_targets(sky, scheduler, without))
    assert len(streak_table(model, with_it, **options)) == 0


@pytest.mark.whole
def test_scores_prefer_clear_blocks_and_lose_none(observer, targets, model, sky):
    constraint = SatelliteStreakConstraint(model, exposure=EXPOSURE, readout=READOUT, boolean_constraint=False)
    few = targets[:12]
    without, _ = schedule_of(PriorityScheduler, observer, few, None)
    with_it, _ = schedule_of(PriorityScheduler, observer, few, constraint)
    assert len(with_it.observing_blocks) == len(without.observing_blocks) == 12
    options = {"exposure": EXPOSURE, "readout": READOUT}
    before, after = (len(set(zip(*(streak_table(model, one, **options)[name] for name in ("block", "exposure"))))) for one in (without, with_it))
    print(f"\nstreaked exposures: {before} without, {after} with the score")
    assert after < before
