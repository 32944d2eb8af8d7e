"""Tests of the brute-force computation: its rotations are compared with astropy."""

import brute_force
import numpy as np
from astropy import units as u
from astropy.coordinates import GCRS, TEME, CartesianRepresentation
from astropy.time import Time

#: 0.6 arcsec at 7000 km. astropy includes polar motion (0.5 arcsec), which is negligible for a field of 3.5 degrees.
TOLERANCE_KM = 0.02


def test_valid_rotation_against_astropy(truths):
    times = Time(["2026-01-16T01:00:00", "2026-08-15T05:00:00"], scale="utc")
    rotation, site = truths[4408]._rotations(times)
    position = np.array([4000.0, -3500.0, 4400.0])
    for one, time in enumerate(times):
        teme = TEME(CartesianRepresentation(position * u.km), obstime=time)
        expected = teme.transform_to(GCRS(obstime=time)).cartesian.xyz.to_value("km")
        assert np.linalg.norm(rotation[one] @ position - expected) < TOLERANCE_KM
        site_km = brute_force.almanac.location().get_gcrs(time).cartesian.xyz.to_value("km")
        assert np.linalg.norm(site[one] - site_km) < TOLERANCE_KM


def test_a_delay_equals_propagation(truths):
    """The series for a delay of ten seconds agrees with SGP4 ten seconds later."""
    truth = truths[4408]
    time = Time("2026-01-16T01:00:00", scale="utc")
    error, position, velocity = truth.array.sgp4(np.array([time.jd1]), np.array([time.jd2]))
    _, later, _ = truth.array.sgp4(np.array([time.jd1]), np.array([time.jd2 + 10.0 / 86_400.0]))
    moved = truth._propagated(position, velocity, np.full(error.shape, 10.0))
    # The oblateness of the Earth causes an acceleration of about 1e-5 km/s^2: half of it times ten seconds squared.
    assert np.abs(moved - later).max() < 0.002
