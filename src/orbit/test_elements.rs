//! Element sets for the unit tests of this module.

use hifitime::Epoch;

use crate::elements::{ElementSet, NoradId, Origin};

/// Returns an element set of 5 June 2026 with a name, a mean motion and half of its derivative.
pub(super) fn starlink(name: &str, mean_motion_rev_day: f64, half_derivative_rev_day2: f64) -> ElementSet {
    ElementSet {
        norad_id: NoradId(60_000),
        name: name.into(),
        international_designator: "".into(),
        epoch: Epoch::from_gregorian_utc_at_midnight(2026, 6, 5),
        mean_motion_rev_day,
        eccentricity: 1e-4,
        inclination_deg: 53.16,
        right_ascension_of_node_deg: 0.0,
        argument_of_perigee_deg: 0.0,
        mean_anomaly_deg: 0.0,
        bstar_per_earth_radius: 1e-3,
        mean_motion_dot_rev_day2: half_derivative_rev_day2,
        mean_motion_ddot_rev_day3: 0.0,
        revolution_at_epoch: 0,
        decayed: None,
        origin: Origin::Published,
    }
}
