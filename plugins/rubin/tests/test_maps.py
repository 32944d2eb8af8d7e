"""The two sky maps: shapes, masked cells compared with crossings of the model, limits, caches, errors."""

import copy
import pickle

import almanac
import healpy as hp
import night
import numpy as np
import pytest
import streakcast
from conftest import EVENING
from rubin_scheduler.scheduler.basis_functions import BaseBasisFunction
from rubin_scheduler.utils import _hpid2_ra_dec
from streakcast_rubin import StreakMaskBasisFunction, StreakRewardBasisFunction
from streakcast_rubin._tracks import Samples, Sky
from streakcast_rubin.mask import FIELD_PAD_DEG, HALF_CELL_DEG, _cells_to_mask

CELLS = 12_288
#: Accepted fraction of differences at the borders of discs: tracks are parabolas over 20 s, sampled every 2 s.
BORDER_SHARE = 0.03


@pytest.fixture(scope="module")
def conditions(_ready):
    return _ready.observatory.return_conditions()


@pytest.fixture
def greedy(_ready):
    return night.surveys_of("greedy", almanac.noon_of(EVENING))[0]


@pytest.mark.parametrize("kind", [StreakMaskBasisFunction, StreakRewardBasisFunction])
def test_shape(kind, conditions, models):
    function = kind(models[4408])
    value = function(conditions)
    assert isinstance(function, BaseBasisFunction)
    assert value.shape == (CELLS,) and value.dtype == np.float64
    assert function.mjd_last == conditions.mjd and function.recalc is False
    assert function.counts["asked"] == 1 and function.counts["failed"] == 0
    # A second call with the same conditions returns the cached map.
    assert function(conditions) is value and function.counts["asked"] == 1
    assert function.label().startswith(kind.__name__.replace("BasisFunction", ""))


@pytest.mark.parametrize("count", [4408, 40768])
def test_masked_cells_are_crossed(count, conditions, models):
    """Cells are compared with the crossings that the model finds for a field which is wider by half a cell."""
    model = models[count]
    value = StreakMaskBasisFunction(model, max_share=1.0)(conditions)
    reached = np.flatnonzero(np.isfinite(conditions.slewtime) & (conditions.alt > np.radians(20.0)))
    # Every seventh cell, because the computation of single cells is slow.
    reached = reached[::7]
    ra, dec = _hpid2_ra_dec(32, reached)
    wide = model.with_options(fov=f"{2.0 * (model.field_radius_deg + HALF_CELL_DEG)} deg")
    starts = conditions.mjd + (conditions.slewtime[reached] - 3.0) / 86_400.0
    crossed = wide.assess((np.degrees(ra), np.degrees(dec)), starts, 31.0 + 6.0).crosses
    masked = np.isnan(value[reached])
    assert 0.05 * reached.size < crossed.sum()
    assert np.count_nonzero(masked != crossed) < BORDER_SHARE * reached.size
    assert set(np.unique(value[~np.isnan(value)])) == {0.0}


def test_masked_fields_are_crossed(conditions, models, greedy):
    """Fields are compared with the crossings of the model, before and after the survey has rotated its fields."""
    model = models[40768]
    function, cellwise = (StreakMaskBasisFunction(model, max_share=1.0) for _ in range(2))
    function.follow(greedy)
    cells = np.flatnonzero(np.isfinite(conditions.slewtime) & (conditions.alt > np.radians(20.0)))[::7]
    starts = conditions.mjd + (conditions.slewtime[cells] - 3.0) / 86_400.0
    wide = model.with_options(fov=f"{2.0 * (model.field_radius_deg + FIELD_PAD_DEG)} deg")
    masks = []
    for night in (conditions.night, 3):
        # As in rubin_scheduler, which first rotates the fields and then sets the night.
        greedy._spin_fields(night)
        greedy.night = conditions.night
        function.recalc = True
        masked = np.isnan(function(conditions))
        fields = greedy.fields[greedy.hp2fields[cells]]
        crossed = wide.assess((np.degrees(fields["RA"]), np.degrees(fields["dec"])), starts, 31.0 + 6.0).crosses
        assert 0.05 * cells.size < crossed.sum() and np.count_nonzero(masked[cells] != crossed) < BORDER_SHARE * cells.size
        masks.append(masked)
    assert np.count_nonzero(masks[0] != masks[1]) > 0.1 * np.count_nonzero(masks[0])
    # With known fields no margin is needed, so that fewer cells are masked.
    assert masks[0].sum() < 0.95 * np.count_nonzero(np.isnan(cellwise(conditions)))
    assert function.counts["failed"] == 0


def test_the_fields_of_the_night_are_used_before_the_survey_rotates_them(conditions, models, greedy):
    """This also holds if another survey with the same fields is chosen all night."""
    function, after_rotation = (StreakMaskBasisFunction(models[40768]) for _ in range(2))
    assert greedy.dither == "night" and greedy.night != conditions.night
    before = greedy.fields.copy()
    function.follow(greedy)
    value = function(conditions)
    assert np.array_equal(greedy.fields, before) and greedy.night != conditions.night
    greedy._spin_fields(conditions.night)
    greedy.night = conditions.night
    assert not np.array_equal(greedy.fields, before)
    after_rotation.follow(greedy)
    assert np.array_equal(value, after_rotation(conditions), equal_nan=True) and function.counts["failed"] == 0


def test_copies_follow_the_copied_survey(conditions, models, greedy):
    function = StreakMaskBasisFunction(models[40768])
    function.follow(greedy)
    greedy.basis_functions.append(function)
    for other in (copy.deepcopy(greedy), pickle.loads(pickle.dumps(greedy))):
        other._spin_fields(3)
        other.night = conditions.night
        value = other.basis_functions[-1](conditions)
        alone = StreakMaskBasisFunction(models[40768])
        alone.follow(other)
        assert np.array_equal(value, alone(conditions), equal_nan=True)
        assert not np.array_equal(value, function(conditions), equal_nan=True)


def test_surveys_that_cannot_be_followed(models, greedy):
    function = StreakMaskBasisFunction(models[4408])
    greedy.dither = "call"
    with pytest.raises(ValueError, match="rotates its fields after the mask is evaluated"):
        function.follow(greedy)
    with pytest.raises(ValueError, match="object has no fields for the cells of nside 32"):
        function.follow(object())


def test_in_a_blocked_sky_every_sector_keeps_open_cells(conditions, models):
    """A field of 60 degrees is almost never clear, and the smallest losses are on one side of the sky."""
    function = StreakMaskBasisFunction(models[40768].with_options(fov="60deg"))
    open_cells = ~np.isnan(function(conditions))
    assert function.counts["capped"] == 1 and function.counts["failed"] == 0
    reached = np.isfinite(conditions.slewtime)
    part = hp.ring2nest(32, np.arange(CELLS)) // 64
    for one in np.unique(part[reached]):
        inside = reached & (part == one)
        if inside.sum() >= 20:
            assert 0.05 * inside.sum() <= np.count_nonzero(open_cells & inside)


def test_in_a_crossed_sky_cells_with_little_gain_stay_open():
    reached = np.ones(CELLS, dtype=bool)
    assert not _cells_to_mask(np.full(CELLS, 0.3), reached, 0.9).any()
    rng = np.random.default_rng(5)
    loss = rng.permutation(CELLS) / CELLS + 1e-9
    # One sector with clear cells, and sectors without.
    part = hp.ring2nest(32, np.arange(CELLS)) // 64
    clear = (part == 7) & (rng.random(CELLS) < 0.2)
    loss[clear] = 0.0
    masked = _cells_to_mask(loss, reached, 0.9)
    assert np.array_equal(masked[part == 7], ~clear[part == 7])
    for one in (3, 8):
        tenth = np.sort(loss[part == one])[6]
        assert np.array_equal(masked[part == one], loss[part == one] > 2.0 * tenth)
    # Cells that cannot be reached are not masked.
    assert not _cells_to_mask(loss, part == 3, 0.9)[part != 3].any()


def test_the_masked_fraction_is_limited(conditions, models):
    reached = np.count_nonzero(np.isfinite(conditions.slewtime))
    free, capped = (StreakMaskBasisFunction(models[40768], max_share=share) for share in (1.0, 0.2))
    all_masked, some = np.isnan(free(conditions)), np.isnan(capped(conditions))
    assert all_masked.sum() > some.sum() == int(0.2 * reached)
    assert capped.counts["capped"] == 1 and free.counts["capped"] == 0
    assert not np.any(some & ~all_masked)


def test_limits_mask_less(conditions, models):
    masked = [
        np.isnan(StreakMaskBasisFunction(models[40768], max_share=1.0, limit_mag=limit, bandname="g")(conditions)).sum()
        for limit in (None, 7.0, {"g": 5.0, "default": 30.0})
    ]
    assert masked[0] > masked[1] > masked[2]


def test_bands_without_a_limit_mask_all_lit_satellites(conditions, models):
    masks = [
        np.isnan(StreakMaskBasisFunction(models[40768], max_share=1.0, limit_mag=limit, bandname="g")(conditions))
        for limit in (None, {"u": -20.0}, {"g": -20.0})
    ]
    assert np.array_equal(masks[0], masks[1]) and masks[0].any() and not masks[2].any()


def test_the_scale_of_the_mjd_is_used(conditions, models):
    """TAI that is read as UTC changes the mask. TAI times, 37 s ahead, give the same mask as UTC."""
    later = copy.copy(conditions)
    later._mjd = conditions.mjd + 37.0 / 86_400.0
    utc, tai, ahead = (
        np.isnan(StreakMaskBasisFunction(models[40768], mjd_scale=scale, max_share=1.0)(when))
        for scale, when in (("utc", conditions), ("tai", conditions), ("tai", later))
    )
    assert np.count_nonzero(utc != tai) > 0.1 * np.count_nonzero(utc)
    assert np.count_nonzero(utc != ahead) < BORDER_SHARE * np.count_nonzero(utc)


def test_samples_without_magnitude_exceed_no_limit():
    p_brighter = np.array([[0.4, 0.9], [0.0, 0.0], [0.1, 0.2]])
    samples = Samples(np.eye(3), np.zeros(3), np.ones(3), np.ones(3), np.array([5.0, np.nan, 8.0]), p_brighter)
    sky = Sky(None, "utc", light=True, limits_mag=(4.0, 7.0))
    assert sky.probably_brighter(7.0, samples).magnitude.tolist() == [5.0]
    assert sky.probably_brighter(4.0, samples).magnitude.size == 0
    assert sky.probability_brighter(7.0, samples).tolist() == [0.9, 0.0, 0.2]
    assert sky.probability_brighter(None, samples).tolist() == [1.0, 1.0, 1.0]
    assert sky.probably_brighter(None, samples).magnitude.size == 3


def test_limits_follow_the_current_band(conditions, models):
    """The cached map is only used for the same limit."""
    function = StreakMaskBasisFunction(models[40768], max_share=1.0, limit_mag={"g": -20.0})
    masked = []
    for band in ("g", "r", "g"):
        now = copy.copy(conditions)
        now.current_band = band
        function.recalc = True
        masked.append(int(np.isnan(function._calc_value(now)).sum()))
    assert masked[0] == masked[2] == 0 < masked[1] and function.counts["failed"] == 0


def test_a_restart_at_an_earlier_time_gives_a_correct_mask(conditions, models):
    """Cached tracks of later times are not used."""
    function, fresh = (StreakMaskBasisFunction(models[4408], max_share=1.0) for _ in range(2))
    for minutes in (80, 70, 60):
        later = copy.copy(conditions)
        later._mjd = conditions.mjd + minutes / 1440.0
        function(later)
    value = function(conditions)
    assert np.array_equal(value, fresh(conditions), equal_nan=True) and np.isnan(value).any()


def test_rewards(conditions, models):
    few, many = (StreakRewardBasisFunction(models[count])(conditions) for count in (4408, 40768))
    assert few.max() <= 0.0 and few.min() < 0.0
    assert many.sum() < few.sum()
    alone = StreakRewardBasisFunction(models[40768], damage="pixels")(conditions)
    # 0.5 deg/s for 30 s, with a width of 3 arcsec and pixels of 0.2 arcsec: at most about 4 million pixels per streak.
    assert -40.0 < alone.min() < -0.01
    # The mean of the map agrees with the losses of visits that are spread over the sky.
    reached = np.flatnonzero(conditions.alt > np.radians(30.0))[::5]
    ra, dec = _hpid2_ra_dec(32, reached)
    verdicts = models[40768].assess((np.degrees(ra), np.degrees(dec)), conditions.mjd + 22.5 / 1440.0, 30.0)
    pixels = models[40768].field_area_deg2 * (3600.0 / 0.2) ** 2 / 1e6
    assert -alone[reached].mean() == pytest.approx(np.nan_to_num(verdicts.lost_fraction).mean() * pixels, rel=0.35)


def test_rewards_are_cached_for_five_minutes(conditions, models):
    function = StreakRewardBasisFunction(models[4408])
    later = copy.copy(conditions)
    first = function(conditions)
    for minutes, made in ((4.9, 1), (5.1, 2)):
        later._mjd = conditions.mjd + minutes / 1440.0
        value = function(later)
        assert function.counts["made"] == made
    assert not np.array_equal(first, value)


@pytest.mark.parametrize("kind", [StreakMaskBasisFunction, StreakRewardBasisFunction])
def test_errors_mask_nothing(kind, conditions, models, monkeypatch):
    function = kind(models[4408])
    monkeypatch.setattr(streakcast.StreakModel, "overhead", lambda *_, **__: 1 / 0)
    assert np.array_equal(function(conditions), np.zeros(CELLS))
    assert function.counts["failed"] == 1


@pytest.mark.parametrize("kind", [StreakMaskBasisFunction, StreakRewardBasisFunction])
def test_copies_are_small(kind, conditions, models):
    function = kind(models[40768])
    value = function(conditions)
    pickled = pickle.dumps(function)
    assert len(pickled) < 10_000
    assert np.array_equal(pickle.loads(pickled)(conditions), value, equal_nan=True)
    assert np.array_equal(copy.deepcopy(function)(conditions), value, equal_nan=True)


@pytest.mark.parametrize("kind", [StreakMaskBasisFunction, StreakRewardBasisFunction])
def test_invalid_options(kind, folder, models):
    without_scale = streakcast.StreakModel(site="Rubin Observatory", elements=folder / "4408.csv", telescope="rubin")
    with pytest.raises(ValueError, match="missing mjd_scale"):
        kind(without_scale)
    with pytest.raises(ValueError, match="no field of view"):
        kind(streakcast.StreakModel(site="Rubin Observatory", elements=folder / "4408.csv", mjd_scale="utc"))
    with pytest.raises(ValueError, match="nside is 64; allowed: 32"):
        kind(models[4408], nside=64)
    with pytest.raises(ValueError, match="limit_mag"):
        kind(models[4408], limit_mag={"x": 1.0})
    if kind is StreakMaskBasisFunction:
        with pytest.raises(ValueError, match="max_share is 1.5; allowed: a number from 0 to 1"):
            kind(models[4408], max_share=1.5)
        with pytest.raises(ValueError, match="max_share is 0; allowed: a number above 0, up to 1"):
            kind(models[4408], max_share=0)
    else:
        with pytest.raises(ValueError, match="look_ahead_min is 1000000.0; allowed: a number from 0.1 to 720"):
            kind(models[4408], look_ahead_min=1e6)
