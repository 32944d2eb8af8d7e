"""The two maps over the sky: shapes, what is masked against what the model itself says cell by cell, caps, caches, faults."""

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
from streakcast_rubin._tracks import Samples, brighter_than
from streakcast_rubin.mask import FIELD_PAD_DEG, HALF_CELL_DEG, _worst

CELLS = 12_288
#: Tracks are parabolas over 20 s, looked at every 2 s: cells at the very border of a disc may fall to either side.
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
    # The same moment again is not asked again.
    assert function(conditions) is value and function.counts["asked"] == 1
    assert function.label().startswith(kind.__name__.replace("BasisFunction", ""))


@pytest.mark.parametrize("count", [4408, 40768])
def test_masked_cells_are_those_that_are_crossed(count, conditions, models):
    """Cell by cell, by the model's own crossings in a field that is wider by half a cell."""
    model = models[count]
    value = StreakMaskBasisFunction(model, max_share=1.0)(conditions)
    reached = np.flatnonzero(np.isfinite(conditions.slewtime) & (conditions.alt > np.radians(20.0)))
    # One in seven: cell by cell the question is dear.
    reached = reached[::7]
    ra, dec = _hpid2_ra_dec(32, reached)
    wide = model.with_options(fov=f"{2.0 * (model.field_radius_deg + HALF_CELL_DEG)} deg")
    starts = conditions.mjd + (conditions.slewtime[reached] - 3.0) / 86_400.0
    crossed = wide.assess((np.degrees(ra), np.degrees(dec)), starts, 31.0 + 6.0).crosses
    masked = np.isnan(value[reached])
    assert 0.05 * reached.size < crossed.sum()
    assert np.count_nonzero(masked != crossed) < BORDER_SHARE * reached.size
    assert set(np.unique(value[~np.isnan(value)])) == {0.0}


def test_followed_fields_are_masked_as_they_are_crossed(conditions, models, greedy):
    """Field by field, by the model's own crossings, before and after the survey has turned its fields."""
    model = models[40768]
    function, cellwise = (StreakMaskBasisFunction(model, max_share=1.0) for _ in range(2))
    function.follow(greedy)
    cells = np.flatnonzero(np.isfinite(conditions.slewtime) & (conditions.alt > np.radians(20.0)))[::7]
    starts = conditions.mjd + (conditions.slewtime[cells] - 3.0) / 86_400.0
    wide = model.with_options(fov=f"{2.0 * (model.field_radius_deg + FIELD_PAD_DEG)} deg")
    seen = []
    for night in (conditions.night, 3):
        # The host turns them so, and then says for which night it did.
        greedy._spin_fields(night)
        greedy.night = conditions.night
        function.recalc = True
        masked = np.isnan(function(conditions))
        fields = greedy.fields[greedy.hp2fields[cells]]
        crossed = wide.assess((np.degrees(fields["RA"]), np.degrees(fields["dec"])), starts, 31.0 + 6.0).crosses
        assert 0.05 * cells.size < crossed.sum() and np.count_nonzero(masked[cells] != crossed) < BORDER_SHARE * cells.size
        seen.append(masked)
    assert np.count_nonzero(seen[0] != seen[1]) > 0.1 * np.count_nonzero(seen[0])
    # Without a margin for what is not known less is masked.
    assert seen[0].sum() < 0.95 * np.count_nonzero(np.isnan(cellwise(conditions)))
    assert function.counts["failed"] == 0


def test_tonights_fields_are_looked_at_before_the_host_turns_them(conditions, models, greedy):
    """And where it is another survey with the same fields that is chosen all night."""
    function, told = (StreakMaskBasisFunction(models[40768]) for _ in range(2))
    assert greedy.dither == "night" and greedy.night != conditions.night
    before = greedy.fields.copy()
    function.follow(greedy)
    value = function(conditions)
    assert np.array_equal(greedy.fields, before) and greedy.night != conditions.night
    greedy._spin_fields(conditions.night)
    greedy.night = conditions.night
    assert not np.array_equal(greedy.fields, before)
    told.follow(greedy)
    assert np.array_equal(value, told(conditions), equal_nan=True) and function.counts["failed"] == 0


def test_copies_follow_the_survey_that_was_copied_with_them(conditions, models, greedy):
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
    with pytest.raises(ValueError, match="turns its fields at each call"):
        function.follow(greedy)
    with pytest.raises(ValueError, match="object has no fields for the cells of nside 32"):
        function.follow(object())


def test_in_a_blocked_sky_every_part_keeps_something_open(conditions, models):
    """A field of 60 degrees is hardly ever clear; the least loss of all lies on one side of the sky."""
    function = StreakMaskBasisFunction(models[40768].with_options(fov="60deg"))
    open_cells = ~np.isnan(function(conditions))
    assert function.counts["capped"] == 1 and function.counts["failed"] == 0
    reached = np.isfinite(conditions.slewtime)
    part = hp.ring2nest(32, np.arange(CELLS)) // 64
    for one in np.unique(part[reached]):
        inside = reached & (part == one)
        if inside.sum() >= 20:
            assert 0.05 * inside.sum() <= np.count_nonzero(open_cells & inside)


def test_where_all_is_crossed_no_slew_is_asked_for_that_gains_little():
    reached = np.ones(CELLS, dtype=bool)
    assert not _worst(np.full(CELLS, 0.3), reached, 0.9).any()
    rng = np.random.default_rng(5)
    loss = rng.permutation(CELLS) / CELLS + 1e-9
    # A part of the sky with a tenth that is clear, and one without.
    part = hp.ring2nest(32, np.arange(CELLS)) // 64
    clear = (part == 7) & (rng.random(CELLS) < 0.2)
    loss[clear] = 0.0
    masked = _worst(loss, reached, 0.9)
    assert np.array_equal(masked[part == 7], ~clear[part == 7])
    for one in (3, 8):
        tenth = np.sort(loss[part == one])[6]
        assert np.array_equal(masked[part == one], loss[part == one] > 2.0 * tenth)
    # Nothing that cannot be reached is masked.
    assert not _worst(loss, part == 3, 0.9)[part != 3].any()


def test_the_share_is_capped_and_the_worst_kept(conditions, models):
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


def test_bands_without_a_limit_mask_what_is_lit(conditions, models):
    masks = [
        np.isnan(StreakMaskBasisFunction(models[40768], max_share=1.0, limit_mag=limit, bandname="g")(conditions))
        for limit in (None, {"u": -20.0}, {"g": -20.0})
    ]
    assert np.array_equal(masks[0], masks[1]) and masks[0].any() and not masks[2].any()


def test_the_scale_of_the_mjd_is_that_of_the_hook(conditions, models):
    """TAI taken for UTC asks for other moments; told of moments 37 s ahead it asks for the same."""
    later = copy.copy(conditions)
    later._mjd = conditions.mjd + 37.0 / 86_400.0
    utc, tai, ahead = (
        np.isnan(StreakMaskBasisFunction(models[40768], mjd_scale=scale, max_share=1.0)(when))
        for scale, when in (("utc", conditions), ("tai", conditions), ("tai", later))
    )
    assert np.count_nonzero(utc != tai) > 0.1 * np.count_nonzero(utc)
    assert np.count_nonzero(utc != ahead) < BORDER_SHARE * np.count_nonzero(utc)


def test_what_has_no_magnitude_breaks_no_limit():
    samples = Samples(np.eye(3), np.zeros(3), np.ones(3), np.ones(3), np.array([5.0, np.nan, 8.0]))
    assert brighter_than(7.0, samples).magnitude.tolist() == [5.0]
    assert brighter_than(None, samples) is samples


def test_limits_follow_the_band_that_is_in(conditions, models):
    """What is kept of the sky was found under one limit."""
    function = StreakMaskBasisFunction(models[40768], max_share=1.0, limit_mag={"g": -20.0})
    masked = []
    for band in ("g", "r", "g"):
        now = copy.copy(conditions)
        now.current_band = band
        function.recalc = True
        masked.append(int(np.isnan(function._calc_value(now)).sum()))
    assert masked[0] == masked[2] == 0 < masked[1] and function.counts["failed"] == 0


def test_a_host_that_goes_back_in_time_is_masked(conditions, models):
    """The tracks of an hour are not kept in place of those of now."""
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
    # Half a degree a second for 30 s, 3 arcsec wide, in pixels of 0.2 arcsec: some 4 Mpx a streak at most.
    assert -40.0 < alone.min() < -0.01
    # What is expected is what happens: the map's mean against the losses of visits spread over the sky.
    reached = np.flatnonzero(conditions.alt > np.radians(30.0))[::5]
    ra, dec = _hpid2_ra_dec(32, reached)
    answer = models[40768].assess((np.degrees(ra), np.degrees(dec)), conditions.mjd + 22.5 / 1440.0, 30.0)
    pixels = models[40768].field_area_deg2 * (3600.0 / 0.2) ** 2 / 1e6
    assert -alone[reached].mean() == pytest.approx(np.nan_to_num(answer.lost_fraction).mean() * pixels, rel=0.35)


def test_rewards_are_kept_for_five_minutes(conditions, models):
    function = StreakRewardBasisFunction(models[4408])
    later = copy.copy(conditions)
    first = function(conditions)
    for minutes, made in ((4.9, 1), (5.1, 2)):
        later._mjd = conditions.mjd + minutes / 1440.0
        value = function(later)
        assert function.counts["made"] == made
    assert not np.array_equal(first, value)


@pytest.mark.parametrize("kind", [StreakMaskBasisFunction, StreakRewardBasisFunction])
def test_faults_mask_nothing(kind, conditions, models, monkeypatch):
    function = kind(models[4408])
    monkeypatch.setattr(streakcast.StreakModel, "overhead", lambda *_, **__: 1 / 0)
    assert np.array_equal(function(conditions), np.zeros(CELLS))
    assert function.counts["failed"] == 1


@pytest.mark.parametrize("kind", [StreakMaskBasisFunction, StreakRewardBasisFunction])
def test_copies_are_small(kind, conditions, models):
    function = kind(models[40768])
    value = function(conditions)
    kept = pickle.dumps(function)
    assert len(kept) < 10_000
    assert np.array_equal(pickle.loads(kept)(conditions), value, equal_nan=True)
    assert np.array_equal(copy.deepcopy(function)(conditions), value, equal_nan=True)


@pytest.mark.parametrize("kind", [StreakMaskBasisFunction, StreakRewardBasisFunction])
def test_impossible_options(kind, folder, models):
    unsaid = streakcast.StreakModel(site="Rubin Observatory", elements=folder / "4408.csv", telescope="rubin")
    with pytest.raises(ValueError, match="mjd_scale is not said"):
        kind(unsaid)
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
