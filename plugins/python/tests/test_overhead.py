"""Satellites above a site are consistent with the crossings of a field at the same time."""

import numpy as np
import pytest

from conftest import START
import streakcast


@pytest.fixture(scope="module")
def wide():
    return streakcast.StreakModel(site="Rubin Observatory", shells="starlink-gen1", telescope="rubin", fov="40deg")


def angles(direction):
    return np.degrees(np.arctan2(direction[:, 1], direction[:, 0])) % 360.0, np.degrees(np.arcsin(direction[:, 2]))


def test_parameters_of_costs(wide):
    assert wide.cost_parameters("g") == wide.cost_parameters() == (0.08, 7.0, None)
    model = wide.with_options(bright_share=0.3, limit_mag={"g": 6.0})
    assert model.cost_parameters("g") == streakcast.CostParameters(bright_share=0.3, bright_mag=7.0, limit_mag=6.0)
    assert model.cost_parameters("r").limit_mag is None
    assert streakcast.StreakModel(mpc="X05", shells="starlink-gen1", fov="3.5deg").cost_parameters() is None


def test_satellites_in_a_field_are_those_that_cross_it(wide):
    seconds = np.array([0.0, 2.0, 40.0])
    up = wide.overhead(START, seconds, min_altitude=0.0)
    assert up.direction.shape == (up.moment.size, 3) and np.allclose(np.linalg.norm(up.direction, axis=1), 1.0)
    # The mean direction of all satellites above the horizon is near the zenith.
    ra, dec = (float(one[0]) for one in angles(up.direction[up.moment == 0].mean(axis=0)[None, :]))
    alpha, delta = np.radians([ra, dec])
    centre = np.array([np.cos(delta) * np.cos(alpha), np.cos(delta) * np.sin(alpha), np.sin(delta)])
    compared, widths = 0, []
    for number, later in enumerate(seconds):
        start = np.datetime64("2026-08-14T23:29:05") + np.timedelta64(int(later), "s")
        crossed = wide.passes((ra, dec), start, 1e-6, scale="utc", output="dict")
        inside = (up.moment == number) & (up.direction @ centre >= np.cos(np.radians(20.0)))
        order = np.argsort(crossed["norad_id"])
        assert np.array_equal(np.asarray(crossed["norad_id"])[order], up.norad_id[inside])
        seen_ra, seen_dec = angles(up.direction[inside])
        assert np.allclose(seen_ra, np.asarray(crossed["mid_ra_deg"])[order], atol=1e-5)
        assert np.allclose(seen_dec, np.asarray(crossed["mid_dec_deg"])[order], atol=1e-5)
        compared += int(inside.sum())
        # Columns of a satellite are computed for the middle of its times.
        for index, norad in enumerate(np.asarray(crossed["norad_id"])[order]):
            moments = up.moment[up.norad_id == norad]
            if moments[len(moments) // 2] == number:
                row = np.flatnonzero((up.norad_id == norad) & (up.moment == number))[0]
                for here, there in (("range_km", "range_km"), ("angular_rate_deg_s", "angular_rate_deg_s"), ("magnitude", "magnitude_peak")):
                    expected = float(np.asarray(crossed[there])[order][index])
                    assert np.isclose(getattr(up, here)[row], expected, rtol=1e-4), (here, norad)
                widths.append(up.lost_width_arcsec[row] / float(np.asarray(crossed["width_arcsec"])[order][index]))
    assert compared > 5
    # The ratio of lost width to streak width is the same for all satellites.
    assert min(widths) >= 1.0 and np.allclose(widths, widths[0], rtol=1e-4)


def test_possible_positions(data):
    """With elements a week old, satellites are given at several positions along their tracks."""
    model = streakcast.StreakModel(site="Rubin Observatory", elements=str(data / "tle" / "active" / "active_2026-04-25.txt"))
    predicted, possible = (model.overhead("2026-05-02T23:30:00Z", min_altitude=20.0, light=False, possible=one) for one in (False, True))
    assert (predicted.probability == 1.0).all() and (possible.probability < 1.0).any()
    norad_ids, several, counts = np.unique(possible.norad_id, return_inverse=True, return_counts=True)
    sums = np.bincount(several, weights=possible.probability)
    # The probabilities of a satellite add up to 1, less those of delays beyond the searched ones and of positions out of sight.
    assert sums.max() <= 1.0 + 1e-6 and np.median(sums) > 0.95 and counts.max() > 10
    assert np.isclose(sums.sum(), predicted.norad_id.size, rtol=0.1)
    # Several positions of one satellite are on a line, its track.
    for norad_id in norad_ids[counts > 3][:20]:
        places = possible.direction[possible.norad_id == norad_id]
        values = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
        assert values[1] < 0.25 * values[0]


def test_bright_streaks_are_those_of_the_cost(wide):
    """The probability of a bright streak of a satellite in the field gives the cost of its pass."""
    up = wide.overhead(START, 0.0, min_altitude=0.0)
    assert up.q_bright.min() >= 0.0 and up.q_bright.max() <= 1.0 and 0.05 < up.q_bright.mean() < 0.95
    share, exposure_s = 1.0, 10.0
    model = wide.with_options(bright_share=share)
    alpha, delta = (float(one[0]) for one in angles(up.direction.mean(axis=0)[None, :]))
    passes = model.passes((alpha, delta), np.datetime64("2026-08-14T23:29:00"), exposure_s, scale="utc", output="dict")
    diameter_deg, compared = np.sqrt(4.0 / np.pi * wide.field_area_deg2), 0
    for norad, length_deg, cost_s, pixels in zip(*(passes[one] for one in ("norad_id", "streak_length_deg", "streak_cost_s", "lost_pixel_fraction"))):
        for q_bright in up.q_bright[up.norad_id == norad]:
            expected = exposure_s * (pixels + share * q_bright * length_deg / diameter_deg)
            assert cost_s == pytest.approx(expected, rel=0.3, abs=0.05)
            compared += 1
    assert compared > 3
    # The band of the exposures selects bright_mag.
    unlit = wide.overhead(START, 0.0, min_altitude=0.0, light=False)
    assert np.isnan(unlit.q_bright).all()
    dark = wide.overhead("2026-08-15T04:00:00Z", 0.0, include_dark=True, min_altitude=0.0)
    assert (dark.q_bright[np.isnan(dark.magnitude)] == 0.0).all() and np.isnan(dark.magnitude).any()


def test_units_and_filters(wide):
    plain = wide.overhead(START, 10.0, min_altitude=30.0)
    assert set(plain.moment) <= {0} and plain.moment.size > 3
    time = pytest.importorskip("astropy.time")
    u = pytest.importorskip("astropy.units")
    same = wide.overhead(time.Time("2026-08-14T23:29:05", scale="utc"), 1.0 / 6.0 * u.min, min_altitude=0.5236 * u.rad)
    assert np.array_equal(plain.norad_id, same.norad_id)
    # One and a half hours later, some satellites are in the shadow.
    lit, all_of_them = (wide.overhead("2026-08-15T01:00:00Z", 10.0, include_dark=dark) for dark in (False, True))
    assert set(lit.norad_id) < set(all_of_them.norad_id)
    unlit = wide.overhead(START, 10.0, min_altitude=30.0, light=False)
    assert np.array_equal(plain.norad_id, unlit.norad_id) and np.isnan(unlit.magnitude).all() and np.isfinite(plain.magnitude).all()
    without = streakcast.StreakModel(site="Rubin Observatory", shells="starlink-gen1").overhead(START)
    assert without.moment.size and np.isnan(without.lost_width_arcsec).all() and np.isnan(without.q_bright).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"seconds": [0.0, 5.0, 5.0]}, "order of the times is not increasing"),
        ({"seconds": []}, "number of times is 0"),
        ({"seconds": 4000.0}, "time is 4000 s"),
        ({"seconds": np.nan}, "time is NaN s"),
        ({"light": False, "limit_mag": 7.0}, "limit_mag is given with light=False; allowed: with light=True"),
        ({"min_altitude": 91.0}, r"min_altitude\[0\] is 91 deg; allowed: 0 to 90 deg"),
    ],
)
def test_bad_input(wide, arguments, message):
    with pytest.raises(ValueError, match=message):
        wide.overhead(START, **arguments)


def test_a_bare_number_needs_a_scale(wide):
    with pytest.raises(TypeError, match="without a time scale"):
        wide.overhead(61267.9)
    assert wide.overhead(61267.9, scale="utc").moment is not None


def test_satellites_in_shadow_shine_in_thermal_bands():
    night = "2026-06-22T04:40:00Z"  # local midnight in winter
    options = dict(mpc="X05", shells="starlink-gen1", telescope="rubin")
    visual = streakcast.StreakModel(**options).overhead(night, [0.0], limit_mag=[30.0], min_altitude=20.0)
    thermal = streakcast.StreakModel(**options, band="W2").overhead(night, [0.0], limit_mag=[30.0], min_altitude=20.0)
    assert len(thermal.norad_id) > len(visual.norad_id) + 10
    assert np.isfinite(thermal.magnitude).all() and (thermal.p_brighter > 0.99).all()
