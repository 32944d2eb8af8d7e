//! Integration state of half-day and one-day orbits, kept near the times that are evaluated.
//!
//! SDP4, the part of SGP4 for periods above 225 minutes, integrates the resonances of such orbits in steps of 720
//! minutes from the element epoch. For elements that are years old this costs a thousand times more than the rest of an
//! evaluation. Therefore the integrator state at a time that is a few days nearer to the epoch than the last distant
//! time is kept, and later evaluations continue from it. The steps are the same, so results are identical bit for bit
//! for any order of evaluations.

use std::sync::{Mutex, PoisonError};

use sgp4::{Constants, MinutesSinceEpoch, ResonanceState};

/// Time difference beyond which the kept state is moved, minutes: below it, the steps cost less than one evaluation.
const FAR_MIN: f64 = 20.0 * 1440.0;
/// Distance of the kept state from the evaluated time, towards the epoch, minutes: evaluations go back and forth by
/// days.
const BACK_MIN: f64 = 5.0 * 1440.0;

/// Start of the integration of one orbit, and the state kept.
pub(super) struct Resonance {
    initial: ResonanceState,
    kept: Mutex<ResonanceState>,
}

impl Clone for Resonance {
    fn clone(&self) -> Self {
        Self { initial: self.initial, kept: Mutex::new(self.kept()) }
    }
}

impl Resonance {
    /// Returns the integration start of an orbit with resonances, `None` for others.
    pub fn new(constants: &Constants) -> Option<Self> {
        constants.initial_state().map(|initial| Self { initial, kept: Mutex::new(initial) })
    }

    /// Returns the state from which to integrate to a time, `minutes` after the element epoch.
    pub fn state_before(&self, constants: &Constants, minutes: f64) -> ResonanceState {
        let kept = self.kept();
        // A kept state is usable for times on its side of the epoch and beyond it.
        let serves = kept.t() == 0.0 || (kept.t().signum() == minutes.signum() && minutes.abs() >= kept.t().abs());
        let state = if serves { kept } else { self.initial };
        if (minutes - state.t()).abs() < FAR_MIN {
            return state;
        }
        let mut nearer = state;
        let back = MinutesSinceEpoch(minutes - BACK_MIN.copysign(minutes));
        // An orbit that fails on the way leaves no state to keep.
        if constants.propagate_from_state(back, Some(&mut nearer), true).is_err() {
            return state;
        }
        *self.kept.lock().unwrap_or_else(PoisonError::into_inner) = nearer;
        nearer
    }

    fn kept(&self) -> ResonanceState {
        *self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use hifitime::{Epoch, Unit};

    use super::super::propagator::Propagator;
    use crate::elements::{ElementSet, NoradId, Origin};

    /// A half-day and a one-day orbit, evaluated near and far, back and forth, before and after the epoch: identical to
    /// the last bit with an integration from the epoch.
    #[test]
    fn verif_order_of_evaluations_changes_no_bit() {
        for (mean_motion_rev_day, eccentricity, inclination_deg) in [(2.0056, 0.7, 63.4), (1.0027, 0.0002, 0.05)] {
            let elements = ElementSet {
                norad_id: NoradId(7),
                name: "".into(),
                international_designator: "".into(),
                epoch: Epoch::from_gregorian_utc_at_noon(2020, 1, 1),
                mean_motion_rev_day,
                eccentricity,
                inclination_deg,
                right_ascension_of_node_deg: 80.0,
                argument_of_perigee_deg: 270.0,
                mean_anomaly_deg: 30.0,
                bstar_per_earth_radius: 0.0,
                mean_motion_dot_rev_day2: 0.0,
                mean_motion_ddot_rev_day3: 0.0,
                revolution_at_epoch: 0,
                decayed: None,
                origin: Origin::Published,
            };
            let propagator = Propagator::new(&elements).expect("starts");
            for days in [650.0, 651.3, 646.0, 600.0, 30.0, 1400.0, -400.0, 0.2, -399.0, 650.0] {
                let minutes = days * Unit::Day.in_seconds() / 60.0;
                let (position, _) = propagator.teme_state_at_minutes(minutes).expect("in orbit");
                assert_eq!(Some(position), propagator.position_from_the_epoch(minutes), "{days} days");
            }
        }
    }
}
