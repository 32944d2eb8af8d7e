"""Meaning of times, array shapes, scores, and errors for invalid arguments."""

import pickle
from copy import deepcopy

import numpy as np
import pytest
from astroplan import FixedTarget, ObservingBlock, is_observable, observability_table
from astropy import units as u
from astropy.coordinates import AltAz, SkyCoord
from astropy.time import Time

from conftest import FOV_DEG, LOCATION, START
from streakcast import StreakModel
from streakcast_astroplan import SatelliteStreakConstraint
from streakcast_astroplan.blocks import Exposures, Rules, unix_s
from streakcast_astroplan.memory import ClearStarts

RADIUS_DEG = FOV_DEG / 2
STEP_S = 20.0
#: Tolerated fraction of differences. The brute force ignores satellites within 0.02 deg of the edge, which are in the
#: field for less than 1 s.
GRAZING_FRACTION = 0.02


@pytest.fixture(scope="module")
def grid():
    return START + np.arange(180) * STEP_S * u.s


@pytest.fixture(scope="module")
def few(targets):
    return targets[:4]


@pytest.fixture(scope="module")
def contacts(sky, few):
    """Returns the time spans of satellites in each of four fields in the hour after START, by brute force."""
    return [sky.contacts(one.coord, START, 3700.0, RADIUS_DEG) for one in few]


def is_clear(contacts, starts_s, length_s):
    """Returns True where exposures with starts in seconds after START contain no contact: ``(n_targets, n_starts)``."""
    return np.array([[not any(a <= start + length_s and b >= start for _, a, b in one) for start in starts_s] for one in contacts])


def test_valid_cells_and_exposures_are_intervals(model, contacts, observer, grid, few):
    cell, longer = (SatelliteStreakConstraint(model, exposure, margin=0) for exposure in (None, 45 * u.s))
    found = np.array([constraint(observer, few, grid, grid_times_targets=True) for constraint in (cell, longer)])
    starts_s = np.arange(180) * STEP_S
    truth = np.array([is_clear(contacts, starts_s, length_s) for length_s in (STEP_S, 45.0)])
    # Every contact of the brute force is found.
    assert not (found & ~truth).any()
    assert (found != truth).mean() < GRAZING_FRACTION
    # Evaluation at single times would miss most contacts.
    instants = is_clear(contacts, starts_s, 0.0)
    assert (~instants).sum() < 0.5 * (~truth[0]).sum()
    assert (~truth[0]).sum() >= 10


def test_a_margin_is_kept_clear(model, observer, grid, few):
    without, with_margin = (SatelliteStreakConstraint(model, margin=margin)(observer, few, grid, grid_times_targets=True) for margin in (0.0, 30 * u.s))
    assert (without | ~with_margin).all() and with_margin.sum() < without.sum()
    # 30 s on both sides include the previous and the next cell.
    neighbours = without[:, :-2] & without[:, 1:-1] & without[:, 2:]
    assert not (with_margin[:, 1:-1] & ~neighbours).any()


def test_valid_three_times_are_a_block_with_its_exposures(model, contacts, observer, few):
    block_s, exposure_s, readout_s = 300.0, 20.0, 40.0
    constraint = SatelliteStreakConstraint(model, exposure_s, readout=readout_s, margin=0)
    continuous = SatelliteStreakConstraint(model, margin=0)
    results, truth, continuous_results = [], [], []
    for target, target_contacts in zip(few, contacts):
        for minute in range(0, 56, 4):
            start = START + minute * u.min
            result = constraint(observer, target, start + [0.0, block_s / 2, block_s] * u.s)
            assert result.shape == (3,) and len(set(result.tolist())) == 1
            results.append(bool(result[0]))
            continuous_results.append(bool(continuous(observer, target, start + [0.0, block_s / 2, block_s] * u.s)[0]))
            truth.append(bool(is_clear([target_contacts], 60.0 * (minute + np.arange(5)), exposure_s).all()))
    assert not any(result and not expected for result, expected in zip(results, truth))
    assert sum(result != expected for result, expected in zip(results, truth)) <= 2
    # Satellites that cross only during a readout do not block.
    assert sum(continuous_results) < sum(results) < len(results)


def test_the_score_of_a_block_is_the_fraction_of_clear_exposures(model, observer, few):
    score = SatelliteStreakConstraint(model, 20.0, readout=40.0, margin=0, boolean_constraint=False, worst_score=0.1)
    one = SatelliteStreakConstraint(model, 20.0, margin=0, each="exposure")
    found = []
    for target in few:
        for minute in range(0, 60, 5):
            start = START + minute * u.min
            product = np.prod(score(observer, target, start + [0.0, 150.0, 300.0] * u.s))
            clear = one(observer, target, start + np.arange(5) * 60 * u.s)
            assert product == pytest.approx(0.1 + 0.9 * clear.mean(), abs=1e-12)
            found.append(product)
    assert 0.1 <= min(found) < max(found) == pytest.approx(1.0)


def test_the_score_of_cost_agrees_with_the_model(elements, observer, few):
    model = StreakModel(site=LOCATION, elements=elements[0], telescope="rubin", fov=FOV_DEG * u.deg)
    # With a telescope the score is that of the cost.
    constraint = SatelliteStreakConstraint(model, 60.0, boolean_constraint=False, worst_score=1e-9)
    times = START + np.arange(60) * 60 * u.s
    scores = constraint(observer, few, times, grid_times_targets=True)
    coordinates = SkyCoord([one.coord for one in few])[:, np.newaxis]
    # With the default margin of 1 s.
    lost = model.assess(coordinates, times - 1 * u.s, 62.0).streak_cost_s / 62.0
    assert scores.shape == (4, 60) and (lost > 0).sum() >= 20
    assert np.allclose(1 - scores, lost, atol=2e-9)
    # It is an upper limit for exposures that begin up to a second earlier or later.
    for later_s in (-1.0, -0.4, 0.0, 0.7, 1.0):
        assert (model.assess(coordinates, times + later_s * u.s, 60.0).streak_cost_s / 60.0 <= lost + 1e-9).all()


def test_below_the_horizon_the_exposure_is_lost(elements, observer):
    """The score of cost and that of clear exposures agree on which targets are below the horizon."""
    model = StreakModel(site=LOCATION, elements=elements[0], telescope="rubin", fov=FOV_DEG * u.deg)
    # Setting, always above, and never above the horizon.
    positions = SkyCoord([55.0, 150.0, 150.0], [0.0, -60.0, 75.0], unit="deg")[:, np.newaxis]
    times = START + np.arange(40) * 180 * u.s
    cost, clear = (
        SatelliteStreakConstraint(model, 60.0, margin=0, boolean_constraint=False, score=score, worst_score=1e-9)
        for score in ("cost", "clear")
    )
    scores = cost.compute_constraint(times, observer, positions)
    below = np.isnan(model.assess(positions, times, 60.0).lost_fraction)
    assert 5 < below[0].sum() < 35 and not below[1].any() and below[2].all()
    assert (scores[below] <= 1e-9).all() and (scores[~below] > 0.9).all()
    assert (clear.compute_constraint(times, observer, positions)[below] <= 1e-9).all()


def test_blocking_avoid_ignores_faint_satellites(elements, observer, grid, few):
    counts = []
    for limit_mag in (3.0, 6.0, 20.0):
        model = StreakModel(site=LOCATION, elements=elements[0], fov=FOV_DEG * u.deg, limit_mag=limit_mag)
        counts.append(SatelliteStreakConstraint(model, blocking="avoid")(observer, few, grid, grid_times_targets=True).sum())
    any_of_them = SatelliteStreakConstraint(model, blocking="any")(observer, few, grid, grid_times_targets=True).sum()
    assert counts[0] >= counts[1] > counts[2] == any_of_them


SHAPES = {
    "one, one": ((), (), ()),
    "one, many": ((7,), (), (7,)),
    "grid": ((7,), (4, 1), (4, 7)),
    "one of a list": ((7,), (1,), (7,)),
    "pairs": ((4,), (4,), (4,)),
    "one time, many targets": ((), (4,), (4,)),
    "two axes of times": ((2, 3), (), (2, 3)),
    "no times": ((0,), (), (0,)),
}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("options", [{"exposure": 30.0}, {"exposure": 30.0, "n_exposures": 2}, {"exposure": 30.0, "boolean_constraint": False}])
def test_shapes_are_those_of_broadcasting(model, observer, targets, name, options):
    time_shape, target_shape, expected = SHAPES[name]
    times = START + np.arange(int(np.prod(time_shape))).reshape(time_shape) * 400 * u.s
    coordinates = SkyCoord([one.coord for one in targets[: int(np.prod(target_shape))]]).reshape(target_shape) if target_shape else targets[0].coord
    constraint = SatelliteStreakConstraint(model, **options)
    result = constraint.compute_constraint(times, observer, coordinates)
    assert np.shape(result) == expected and constraint.hook.counts["failed"] == 0
    assert np.asarray(result).dtype == (float if "boolean_constraint" in options else bool)
    assert np.shape(constraint(observer, coordinates, times)) == expected


def test_all_forms_of_calls_agree(model, observer, few):
    one = SatelliteStreakConstraint(model, 30.0, each="exposure", margin=0)
    times = START + np.arange(100) * 45 * u.s
    grid = one(observer, few, times, grid_times_targets=True)
    single = np.array([[bool(one(observer, target, moment)) for moment in times[:25]] for target in few])
    order = np.random.default_rng(1).permutation(100)
    assert (grid[:, :25] == single).all()
    assert (one(observer, few[1], times[order]) == grid[1, order]).all()
    assert (one.compute_constraint(times.tai, observer, few[2].coord) == grid[2]).all()
    galactic = one.compute_constraint(times, observer, few[3].coord.galactic)
    assert (galactic == grid[3]).all() and (~grid).sum() >= 10


def test_times_in_tai_are_not_read_as_utc(model, observer, few):
    constraint = SatelliteStreakConstraint(model, 5.0, each="exposure", margin=0)
    times = START + np.arange(400) * 5 * u.s
    mistaken = Time(times.tai.mjd, format="mjd", scale="utc")
    right, wrong = (constraint(observer, few, grid, grid_times_targets=True) for grid in (times, mistaken))
    assert (right == constraint(observer, few, times.tai, grid_times_targets=True)).all()
    # With a time error of 37 s most streaks are missed.
    assert (~right & ~wrong).sum() < 0.3 * (~right).sum()


def test_tables_of_astroplan_accept_the_constraint(model, observer, few):
    constraint = SatelliteStreakConstraint(model, 30 * u.s, each="exposure")
    table = observability_table([constraint], observer, few, time_range=(START, START + 2 * u.hour), time_grid_resolution=5 * u.min)
    assert table["ever observable"].all() and not table["always observable"].all()
    assert is_observable(constraint, observer, few, time_range=(START, START + 1 * u.hour)).all()


def test_a_target_below_the_horizon_is_not_observable(model, observer):
    north = FixedTarget(SkyCoord(10.0, 85.0, unit="deg"))
    times = START + np.arange(5) * 60 * u.s
    for options in ({}, {"exposure": 30.0}):
        assert not SatelliteStreakConstraint(model, **options)(observer, north, times).any()
    assert not SatelliteStreakConstraint(model, 30.0)(observer, north, START)


def test_a_block_defines_its_exposures(model, observer, few):
    block = ObservingBlock.from_exposures(few[0], 1, 30 * u.s, 6, readout_time=5 * u.s)
    rules = SatelliteStreakConstraint.for_block(model, block).rules
    assert (rules.exposures.exposure_s, rules.exposures.readout_s, rules.exposures.n_exposures) == (30.0, 5.0, 6)
    assert SatelliteStreakConstraint.for_block(model, ObservingBlock(few[0], 60 * u.s, 1)).rules.exposures.exposure_s is None


def test_copies_and_pickles_are_small_and_give_the_same_results(model, observer, grid, few):
    constraint = SatelliteStreakConstraint(model, 30.0, readout=2.0)
    expected = constraint(observer, few, grid, grid_times_targets=True)
    pickled = pickle.dumps(constraint)
    assert len(pickled) < 10_000
    for copy in (pickle.loads(pickled), deepcopy(constraint)):
        assert (copy(observer, few, grid, grid_times_targets=True) == expected).all()


INVALID = {
    "exposure is -1.0 s; allowed: above 0": {"exposure": -1.0},
    "exposure is .* allowed: a Quantity of time": {"exposure": 3 * u.m},
    "exposure is nan": {"exposure": float("nan")},
    "readout and n_exposures are given without exposure": {"readout": 2.0},
    "readout is -2.0 s; allowed: 0 to": {"exposure": 30, "readout": -2.0},
    "n_exposures is 0; allowed: 1 to": {"exposure": 30, "n_exposures": 0},
    "margin is -1.0 s; allowed": {"margin": -1},
    "blocking is 'all'; allowed: any, avoid": {"blocking": "all"},
    "each is 'instant'; allowed: auto, cell, exposure, block": {"each": "instant"},
    "each='exposure' without exposure": {"each": "exposure"},
    "score is 'sum'; allowed: clear, cost": {"score": "sum", "boolean_constraint": False},
    "score 'clear' with boolean_constraint=True": {"score": "clear"},
    "the model has no telescope": {"score": "cost", "boolean_constraint": False},
    "worst_score is 0; allowed: above 0": {"worst_score": 0},
}


@pytest.mark.parametrize("message", INVALID)
def test_invalid_arguments_are_reported_at_construction(model, message):
    with pytest.raises(ValueError, match=message):
        SatelliteStreakConstraint(model, **INVALID[message])


def test_invalid_models_are_reported_at_construction(elements):
    with pytest.raises(ValueError, match="no field of view"):
        SatelliteStreakConstraint(StreakModel(site=LOCATION, elements=elements[0]), 30.0)
    with pytest.raises(TypeError, match="model is a str"):
        SatelliteStreakConstraint("gp.csv", 30.0)
    with pytest.raises(ValueError, match="no-such-file"):
        StreakModel(site=LOCATION, elements="no-such-file.tle", fov="1deg")


def test_verif_cached_ratings_equal_computed_ones(model, few):
    memory = ClearStarts()
    found = []
    for rules in (Rules(Exposures(20.0, 40.0)), Rules(Exposures(20.0, 40.0, 3), blocking="avoid"), Rules(Exposures())):
        for target in few:
            ra_deg, dec_deg = target.coord.ra.deg, target.coord.dec.deg
            for minute in [*range(0, 130, 3), 5, 64]:
                start_s, block_s = float(unix_s(START)) + 60.0 * minute, 240.0
                expected = rules.worth_of_block(model, np.array([ra_deg]), np.array([dec_deg]), start_s, block_s)[0]
                assert memory.worth_of_block(model, rules, ra_deg, dec_deg, start_s, block_s) == pytest.approx(expected, abs=1e-12)
                found.append(expected)
    assert len(set(found)) >= 5
