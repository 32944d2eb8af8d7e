"""Map of costs: comparison with the costs of the model, fields of surveys, limits, caches, errors."""

import copy
import logging
import pickle

import almanac
import brute_force
import night
import numpy as np
import pytest
import streakcast
from astropy.time import Time
from conftest import EVENING, HOURS
from rubin_scheduler.scheduler.basis_functions import BaseBasisFunction
from rubin_scheduler.utils import _hpid2_ra_dec
from streakcast_rubin import StreakCostBasisFunction, cost_map
from streakcast_rubin._candidates import OPEN_SHARE
from streakcast_rubin._tracks import CELLS, VISIT_S
from streakcast_rubin.cost_map import SLEW_UNIT_S

BOTH = pytest.mark.parametrize("ahead_min", [0.0, 45.0])


@pytest.fixture(scope="module")
def conditions(_ready):
    return _ready.observatory.return_conditions()


@pytest.fixture
def greedy(_ready):
    return night.surveys_of("greedy", almanac.noon_of(EVENING))[0]


def costs_s(function, conditions):
    """Returns the costs of a map, seconds of open shutter."""
    value = function(conditions)
    assert function.counts["failed"] == 0
    return -OPEN_SHARE * SLEW_UNIT_S * value


def cells_of(conditions, step):
    """Returns cells above 20 degrees, with their coordinates in degrees; few, because single exposures are slow."""
    cells = np.flatnonzero(np.isfinite(conditions.slewtime) & (conditions.alt > np.radians(20.0)))[::step]
    return cells, tuple(np.degrees(_hpid2_ra_dec(32, cells)))


def assessed_s(model, target, conditions, cells, **options):
    starts = conditions.mjd + conditions.slewtime[cells] / 86_400.0
    return np.asarray(model.assess(target, starts, VISIT_S, **options).streak_cost_s)


def agree(found, expected):
    """The same costs, except that chords are sums of steps of a second, and magnitudes those of slots of 40 s."""
    assert expected.mean() > 0.02
    assert found.mean() == pytest.approx(expected.mean(), rel=0.2)
    assert np.corrcoef(found, expected)[0, 1] >= 0.92
    return np.mean((found > 0.02) == (expected > 0.02))


@BOTH
def test_shape(ahead_min, conditions, models):
    function = StreakCostBasisFunction(models[40768], ahead_min=ahead_min)
    value = function(conditions)
    assert isinstance(function, BaseBasisFunction)
    assert value.shape == (CELLS,) and value.dtype == np.float64
    assert np.isfinite(value).all() and value.max() <= 0.0 and value.min() < 0.0
    assert function.mjd_last == conditions.mjd and function.recalc is False
    assert function.counts["asked"] == 1 and function.counts["failed"] == 0
    # A second call with the same conditions returns the same map.
    assert function(conditions) is value and function.counts["asked"] == 1
    assert function.label().startswith("StreakCost")


@pytest.mark.parametrize("options", [{}, {"bright_share": 1.0}, {"limit_mag": 6.0}])
def test_costs_of_cells_are_those_of_the_model(options, conditions, models):
    cells, target = cells_of(conditions, 7)
    found = costs_s(StreakCostBasisFunction(models[40768], **options), conditions)[cells]
    same = agree(found, assessed_s(models[40768].with_options(**options), target, conditions, cells))
    # Near misses, whose costs are small, and streaks that are shorter than a step differ.
    assert same >= 0.96


def test_costs_of_later_visits_are_those_of_the_model(conditions, models, monkeypatch):
    """Mean over visits at random times in the next 45 minutes."""
    monkeypatch.setattr(cost_map, "DEAD_BAND_S", 0.0)
    cells, target = cells_of(conditions, 3)
    found = costs_s(StreakCostBasisFunction(models[40768], ahead_min=45.0), conditions)[cells]
    starts = conditions.mjd + np.random.default_rng(45).uniform(0.0, 45.0, cells.size) / 1440.0
    assert found.mean() == pytest.approx(np.nanmean(models[40768].assess(target, starts, VISIT_S).streak_cost_s), rel=0.15)


@pytest.mark.parametrize(
    ("rate_deg_s", "q_bright", "width_arcsec", "least", "most"),
    # 5 mag and 10 mag at 550 km; geostationary, 12 mag.
    [(0.75, 1.0, 6.4, 1.9, 3.1), (0.75, 0.0, 6.4, 0.01, 0.05), (15.04 / 3600.0, 1.0, 1.6, 0.05, 0.1)],
)
def test_costs_of_single_satellites(rate_deg_s, q_bright, width_arcsec, least, most, conditions, model, monkeypatch):
    """A satellite that passes through the centre of a cell; its chord of 3.5 deg is a sum of steps of 0.75 deg."""
    cell = int(np.nanargmin(np.where(conditions.alt > np.radians(30.0), conditions.slewtime, np.nan)))
    opens_mjd = float(conditions.mjd + conditions.slewtime[cell] / 86_400.0)
    ra, dec = (float(one) for one in _hpid2_ra_dec(32, cell))

    def overhead(self, start_mjd, seconds, **_):
        # Along the meridian, in the middle of the visit at the centre of the cell.
        after_s = (start_mjd - opens_mjd) * 86_400.0 + np.asarray(seconds) - VISIT_S / 2.0
        angle, n = dec + np.radians(rate_deg_s * after_s), np.size(seconds)
        direction = np.column_stack([np.cos(angle) * np.cos(ra), np.cos(angle) * np.sin(ra), np.sin(angle)])
        ones = np.ones(n)
        return streakcast.Overhead(
            moment=np.arange(n), norad_id=np.ones(n, dtype=int), direction=direction, probability=ones, range_km=550.0 * ones,
            angular_rate_deg_s=rate_deg_s * ones, lost_width_arcsec=width_arcsec * ones, magnitude=5.0 * ones,
            p_brighter=np.ones((n, 0)), q_bright=q_bright * ones,
        )  # fmt: skip

    monkeypatch.setattr(streakcast.StreakModel, "overhead", overhead)
    assert least <= costs_s(StreakCostBasisFunction(model), conditions)[cell] <= most


def test_small_costs_of_later_visits_do_not_count(conditions, models, monkeypatch):
    with_band = costs_s(StreakCostBasisFunction(models[40768], ahead_min=45.0), conditions)
    monkeypatch.setattr(cost_map, "DEAD_BAND_S", 0.0)
    without = costs_s(StreakCostBasisFunction(models[40768], ahead_min=45.0), conditions)
    assert np.allclose(with_band, np.maximum(without - 0.1, 0.0)) and np.any((without > 0.0) & (with_band == 0.0))


def test_costs_of_fields_are_those_of_the_model(conditions, models, greedy):
    """Fields are compared before and after the survey has rotated them."""
    model = models[40768]
    function = StreakCostBasisFunction(model)
    function.follow(greedy)
    cells, _ = cells_of(conditions, 7)
    maps = []
    for number in (conditions.night, 3):
        # As in rubin_scheduler, which first rotates the fields and then sets the night.
        greedy._spin_fields(number)
        greedy.night = conditions.night
        function.recalc = True
        maps.append(costs_s(function, conditions)[cells])
        fields = greedy.fields[greedy.hp2fields[cells]]
        agree(maps[-1], assessed_s(model, (np.degrees(fields["RA"]), np.degrees(fields["dec"])), conditions, cells))
    assert np.mean(maps[0] != maps[1]) > 0.1


def test_the_fields_of_the_night_are_used_before_the_survey_rotates_them(conditions, models, greedy):
    """This also holds if another survey with the same fields is chosen all night."""
    function, after_rotation = (StreakCostBasisFunction(models[40768]) for _ in range(2))
    assert greedy.dither == "night" and greedy.night != conditions.night
    before = greedy.fields.copy()
    function.follow(greedy)
    value = function(conditions)
    assert np.array_equal(greedy.fields, before) and greedy.night != conditions.night
    greedy._spin_fields(conditions.night)
    greedy.night = conditions.night
    assert not np.array_equal(greedy.fields, before)
    after_rotation.follow(greedy)
    assert np.array_equal(value, after_rotation(conditions)) and function.counts["failed"] == 0


def test_copies_follow_the_copied_survey(conditions, models, greedy):
    function = StreakCostBasisFunction(models[40768])
    function.follow(greedy)
    greedy.basis_functions.append(function)
    for other in (copy.deepcopy(greedy), pickle.loads(pickle.dumps(greedy))):
        other._spin_fields(3)
        other.night = conditions.night
        value = other.basis_functions[-1](conditions)
        alone = StreakCostBasisFunction(models[40768])
        alone.follow(other)
        assert np.array_equal(value, alone(conditions))
        assert not np.array_equal(value, function(conditions))


def test_surveys_that_cannot_be_followed(models, greedy):
    function = StreakCostBasisFunction(models[4408])
    with pytest.raises(ValueError, match="ahead_min is 45, and the map does not depend on the fields"):
        StreakCostBasisFunction(models[4408], ahead_min=45.0).follow(greedy)
    greedy.dither = "call"
    with pytest.raises(ValueError, match="rotates its fields after the map is evaluated"):
        function.follow(greedy)
    with pytest.raises(ValueError, match="object has no fields for the cells of nside 32"):
        function.follow(object())


@BOTH
def test_limits_cost_the_visit(ahead_min, conditions, models):
    """The limit of the current band counts; -30 mag is never exceeded, 30 mag always."""
    maps = []
    function = StreakCostBasisFunction(models[40768], ahead_min=ahead_min, limit_mag={"g": -30.0, "r": 30.0})
    for band in ("g", "r", "i"):
        now = copy.copy(conditions)
        now.current_band = band
        function.recalc = True
        maps.append(costs_s(function, now))
    # Magnitudes have long tails.
    assert np.allclose(maps[0], maps[2], atol=0.05) and maps[1].max() <= VISIT_S
    assert maps[1].mean() > 5.0 * maps[0].mean()
    named = StreakCostBasisFunction(models[40768], ahead_min=ahead_min, limit_mag={"g": -30.0, "r": 30.0}, bandname="r")
    assert np.allclose(costs_s(named, conditions), maps[1])


def test_the_scale_of_the_mjd_is_used(conditions, models):
    """TAI that is read as UTC changes the map. TAI times, 37 s ahead, give the same map as UTC."""
    later = copy.copy(conditions)
    later._mjd = conditions.mjd + 37.0 / 86_400.0
    utc, tai, ahead = (
        costs_s(StreakCostBasisFunction(models[40768], mjd_scale=scale), when)
        for scale, when in (("utc", conditions), ("tai", conditions), ("tai", later))
    )
    assert np.corrcoef(utc, tai)[0, 1] < 0.7 < 0.9 < np.corrcoef(utc, ahead)[0, 1]


def test_maps_of_later_visits_are_computed_every_five_minutes_for_all_bands(conditions, models):
    function = StreakCostBasisFunction(models[4408], ahead_min=45.0)
    made = []
    later = copy.copy(conditions)
    for minutes, band in ((0.0, "g"), (0.0, "r"), (0.5, "i"), (5.5, "i"), (5.6, "g")):
        later._mjd, later.current_band = np.ceil(conditions.mjd * 288.0) / 288.0 + minutes / 1440.0, band
        function.recalc = True
        function(later)
        made.append(function.counts["made"])
    assert made == [1, 1, 1, 2, 2]


def test_a_restart_at_an_earlier_time_gives_the_same_map(conditions, models):
    """Cached tracks of later times are not used."""
    function, fresh = (StreakCostBasisFunction(models[4408]) for _ in range(2))
    for minutes in (80, 70, 60):
        later = copy.copy(conditions)
        later._mjd = conditions.mjd + minutes / 1440.0
        function(later)
    value = function(conditions)
    assert np.array_equal(value, fresh(conditions)) and value.any()


@BOTH
def test_after_errors_the_map_is_zero(ahead_min, conditions, models, monkeypatch):
    function = StreakCostBasisFunction(models[4408], ahead_min=ahead_min)
    monkeypatch.setattr(streakcast.StreakModel, "overhead", lambda *_, **__: 1 / 0)
    assert np.array_equal(function(conditions), np.zeros(CELLS))
    assert function.counts["failed"] == 1


@BOTH
def test_without_known_positions_the_map_is_zero(ahead_min, conditions, tmp_path, caplog):
    brute_force.write_walker(["starlink-gen1"], Time("2022-01-15T00:00:00"), tmp_path / "old.csv")
    model = streakcast.StreakModel(site="Rubin Observatory", elements=tmp_path / "old.csv", telescope="rubin", mjd_scale="utc")
    function = StreakCostBasisFunction(model, ahead_min=ahead_min)
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            function.recalc = True
            assert np.array_equal(function(conditions), np.zeros(CELLS))
    assert function.counts["unknown"] == 3 and function.counts["failed"] == 0
    assert len([one for one in caplog.records if "satellites are ignored" in one.message]) == 1


def test_a_map_of_zeros_leaves_the_order_of_visits(folder, models, pairs_evening, monkeypatch):
    monkeypatch.setattr(streakcast.StreakModel, "overhead", lambda *_, **__: 1 / 0)
    function = StreakCostBasisFunction(models[40768], ahead_min=45.0)
    zeros = night.run(EVENING, "pairs", folder, hours=HOURS, rewards=[(function, night.SLEWTIME_WEIGHT)])
    assert function.counts["asked"] == function.counts["failed"] >= 2
    for column in ("RA", "dec", "mjd"):
        assert np.array_equal(pairs_evening.visits[column], zeros.visits[column])


@BOTH
def test_copies_are_small(ahead_min, conditions, models):
    function = StreakCostBasisFunction(models[40768], ahead_min=ahead_min)
    value = function(conditions)
    pickled = pickle.dumps(function)
    assert len(pickled) < 10_000
    assert np.array_equal(pickle.loads(pickled)(conditions), value)
    assert np.array_equal(copy.deepcopy(function)(conditions), value)


def test_invalid_options(folder, models):
    without_scale = streakcast.StreakModel(site="Rubin Observatory", elements=folder / "4408.csv", telescope="rubin")
    with pytest.raises(ValueError, match="missing mjd_scale"):
        StreakCostBasisFunction(without_scale)
    with pytest.raises(ValueError, match="no telescope"):
        StreakCostBasisFunction(streakcast.StreakModel(site="Rubin Observatory", elements=folder / "4408.csv", fov="3.5deg", mjd_scale="utc"))
    with pytest.raises(ValueError, match="unknown band 'x'"):
        StreakCostBasisFunction(models[4408], limit_mag={"x": 1.0})
    with pytest.raises(ValueError, match="bandname is 'zz'; allowed: u, g, r, i, z, y"):
        StreakCostBasisFunction(models[4408], bandname="zz")
    with pytest.raises(ValueError, match="0 to 100"):
        StreakCostBasisFunction(models[4408], bright_share=-1.0)
    with pytest.raises(ValueError, match="ahead_min is 1000000.0; allowed: a number from 0 to 720"):
        StreakCostBasisFunction(models[4408], ahead_min=1e6)
