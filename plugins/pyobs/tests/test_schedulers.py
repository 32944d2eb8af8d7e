"""Schedulers of pyobs, configured by YAML; schedules are checked by a brute-force computation without streakcast."""

import asyncio
import multiprocessing
import os
import statistics
import threading
import time

import pytest
import yaml
from astropy import units as u
from pyobs.object import get_object
from pyobs.robotic.scheduler import OnDemandScheduler
from pyobs.robotic.scheduler.astroplanscheduler import AstroplanScheduler
from pyobs.robotic.scheduler.constraints import Constraint
from pyobs.robotic.scheduler.merits import Merit

from brute_force import walker, write_tle
from conftest import FOV_DEG, LOCATION, SHELLS, START, TASK_S
from streakcast.hosts import Hook
from streakcast_pyobs import SatelliteConstraint, SatelliteMerit

WITHOUT = """
class: pyobs.robotic.scheduler.OnDemandScheduler
constraints:
  - type: Airmass
    max_airmass: 2.5
"""
WITH = """
  - class: streakcast_pyobs.SatelliteConstraint
    model: {{elements: {elements}, fov: {fov}}}
    exposure_s: 55
    readout_s: 5
"""


def scheduler_of(text, observer):
    scheduler = get_object(yaml.safe_load(text), observer=observer, location=LOCATION)
    assert isinstance(scheduler, OnDemandScheduler)
    return scheduler


def run(scheduler, tasks, hours, beside=None):
    async def everything():
        helper = asyncio.create_task(beside()) if beside else None
        observations = []
        async for one in scheduler.schedule(tasks, [], *hours):
            observations.append(one)
        if helper is not None:
            helper.cancel()
        return observations

    return asyncio.run(everything())


def streaked_targets(sky, observations):
    """Returns the observations with a streak in one of their exposures: five of 55 s, one per minute."""
    return [
        one.task.name
        for one in observations
        if any(sky.streaks(one.target.coord, one.start + number * 60 * u.s, 55.0, FOV_DEG / 2) for number in range(5))
    ]


def test_valid_no_choice_of_the_constrained_scheduler_has_a_streak_by_sgp4_and_astropy(observer, tasks, hours, settings, sky):
    # Wall-clock time, and processor time, which does not depend on other programs.
    wall_s, processor_s = [], []
    original = SatelliteConstraint.__call__

    async def timed(self, *arguments):
        wall_start, processor_start = time.perf_counter(), time.process_time()
        try:
            return await original(self, *arguments)
        finally:
            wall_s.append(time.perf_counter() - wall_start)
            processor_s.append(time.process_time() - processor_start)

    without = run(scheduler_of(WITHOUT, observer), tasks, hours)
    scheduler = scheduler_of(WITHOUT + WITH.format(**settings), observer)
    (constraint,) = [one for one in scheduler._global_constraints if isinstance(one, SatelliteConstraint)]
    SatelliteConstraint.__call__ = timed
    try:
        with_it = run(scheduler, tasks, hours)
    finally:
        SatelliteConstraint.__call__ = original
    print(f"\n{len(without)} observations without, {len(with_it)} with; {len(wall_s)} calls")
    for what, times in (("wall clock", wall_s), ("processor", processor_s)):
        print(f"{what}: median {1e3 * statistics.median(times):.2f} ms, max {1e3 * max(times):.2f} ms")
    assert len(streaked_targets(sky, without)) >= 3
    assert len(with_it) >= 0.6 * len(without) and streaked_targets(sky, with_it) == []
    counts = constraint.hook().counts
    assert counts["asked"] == len(wall_s) > 20 and counts["failed"] == counts["site"] == 0


def test_valid_a_merit_prefers_clear_tasks(observer, tasks, hours, settings, sky):
    merit = {"class": "streakcast_pyobs.SatelliteMerit", "model": settings, "exposure_s": 55, "readout_s": 5}
    without = run(scheduler_of(WITHOUT, observer), tasks, hours)
    for task in tasks:
        task.merits += [scheduler_of(WITHOUT, observer).pyobs_model_validate(Merit, dict(merit), by_alias=True)]
    with_it = run(scheduler_of(WITHOUT, observer), tasks, hours)
    before, after = len(streaked_targets(sky, without)) / len(without), len(streaked_targets(sky, with_it)) / len(with_it)
    print(f"\nstreaked: {100 * before:.0f} % of the observations without the merit, {100 * after:.0f} % with it")
    assert len(with_it) >= 0.9 * len(without) and after < 0.5 * before


def test_the_event_loop_does_not_stall(observer, tasks, hours, settings, monkeypatch):
    """The event loop runs during each computation: the patched `evaluate` waits for it, and fails in the loop's
    thread.
    """
    turns, is_running, original = [], threading.Event(), Hook.evaluate

    async def heartbeat():
        while True:
            await asyncio.sleep(0)
            turns.append(None)
            if len(turns) > 10:
                is_running.set()

    def waiting(self, function, fallback):
        turns.clear()
        is_running.clear()
        assert is_running.wait(120.0), "the event loop is blocked"
        return original(self, function, fallback)

    monkeypatch.setattr(Hook, "evaluate", waiting)

    async def evaluate():
        beat = asyncio.create_task(heartbeat())
        constraint = SatelliteConstraint.model_validate({"model": {**settings, "mpc": "X05"}, "exposure_s": 55})
        data = type("Data", (), {"observer": observer})()
        results = []
        # Task as long as a night.
        tasks[0].duration = 40_000.0
        for _ in range(20):
            results.append(await constraint(hours[0], tasks[0], data))
        beat.cancel()
        return results

    results = asyncio.run(evaluate())
    assert len(results) == 20 and not any(results)


def test_valid_the_astroplan_scheduler_of_pyobs_uses_the_constraint(observer, tasks, hours, settings, sky):
    constraint = {"class": "streakcast_pyobs.SatelliteConstraint", "model": settings}

    def scheduled(constraints):
        scheduler = AstroplanScheduler(twilight="nautical", observer=observer, location=LOCATION)
        for task in tasks[:8]:
            task.constraints = [Constraint.create(scheduler, dict(one)) for one in constraints]
        return run(scheduler, tasks[:8], (hours[0], hours[0] + 1 * u.hour))

    altitude = {"type": "Airmass", "max_airmass": 2.5}
    without, with_it = scheduled([altitude]), scheduled([altitude, constraint])
    hits = [[one for one in some if sky.streaks(one.target.coord, one.start, TASK_S, FOV_DEG / 2)] for some in (without, with_it)]
    print(f"\nAstroplanScheduler: {len(hits[0])} of {len(without)} blocks have a streak without, {len(hits[1])} of {len(with_it)} with")
    assert len(hits[0]) >= 2 and hits[1] == [] and len(with_it) >= 3
    # The scheduler runs in another process, whose counts are collected here.
    counts = tasks[0].constraints[1].hook().counts
    assert counts["asked"] >= 8 and counts["failed"] == counts["site"] == 0


def test_the_next_process_reads_new_files_and_reports_problems(observer, tasks, hours, tmp_path, log):
    path = tmp_path / "gp.tle"
    write_tle(path, walker(SHELLS[:1], START))
    old = time.time() - 120.0
    os.utime(path, (old, old))
    constraint = {"class": "streakcast_pyobs.SatelliteConstraint", "model": {"elements": str(path), "fov": "6deg"}}
    scheduler = AstroplanScheduler(twilight="nautical", observer=observer, location=LOCATION)
    for task in tasks[:3]:
        task.constraints = [Constraint.create(scheduler, dict(constraint))]
    hook = tasks[0].constraints[0].hook()
    hook._state.watch_s, hook._state.next_check_s = 1e-9, 0.0

    def satellites_in_process():
        """Returns the number of satellites of the model in another process."""
        results = multiprocessing.get_context("fork").Queue()
        remote = tasks[0].constraints[0].to_astroplan().hook
        process = multiprocessing.get_context("fork").Process(target=lambda: results.put(remote.model.satellites(START)))
        process.start()
        count = results.get(timeout=60.0)
        process.join()
        return count

    assert satellites_in_process() == 36 * 22
    write_tle(path, walker(SHELLS, START))
    os.utime(path, (old + 60.0, old + 60.0))
    assert satellites_in_process() == 36 * 22 + 36 * 40 and hook.counts["reloaded"] == 1
    # Sites of scheduler and model differ. Only the process of the scheduler can detect this.
    tasks[0].constraints[0].model["site"]["latitude_deg"] += 1.0
    run(scheduler, tasks[:1], (hours[0], hours[0] + 0.5 * u.hour))
    moved = tasks[0].constraints[0].hook()
    assert moved is not hook and moved.counts["site"] >= 1 and moved.counts["asked"] >= 1
    assert [one for one in log.records if "in another process" in one.message and "km apart" in one.message]
