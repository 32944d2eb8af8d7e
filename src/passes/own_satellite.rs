//! Satellites of a sky that are the observing telescope itself, whatever their catalogue numbers are.
//!
//! The telescope is left out of all searches. It is found by its number and, because ephemerides and element sets may
//! have wrong or no numbers, by its orbit: nothing else stays within kilometres of it.

use hifitime::Epoch;

use super::sky::Sky;
use crate::constants::DAY_S;
use crate::elements::Origin;
use crate::frames::{Orientation, seconds_after, seconds_between};
use crate::orbit::State;

/// Largest distance of the telescope itself from a satellite that is the telescope, km. Element sets of a few days
/// differ by kilometres from the positions of an operator.
const SAME_KM: f64 = 10.0;
/// Largest relative speed of such a satellite, km/s. On neighbouring orbits it is the rate of the orbit, 0.001/s, times
/// the distance; satellites on other orbits pass with kilometres a second.
const SAME_KM_S: f64 = 0.1;
/// Age of an element set up to which its error is below that distance, days.
const EXACT_DAYS: f64 = 2.0;
/// Number of times that are tested, and time before and after the request over which they extend, seconds: together
/// more than half a revolution in a low orbit.
const TIMES: usize = 9;
const AROUND_S: f64 = 2_700.0;
/// Distance of an ephemeris from the element set of its number beyond which they are of different objects, km, and
/// largest age of the set, days. Sets of two weeks are wrong by at most some hundred kilometres.
const OTHER_KM: f64 = 1_000.0;
const LARGEST_AGE_DAYS: f64 = 14.0;

/// Satellites that are the telescope in orbit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OwnSatellites {
    /// Element indices of satellites with another number that are the telescope by their orbits.
    pub by_orbit: Vec<usize>,
    /// Element index of the satellite that has the number of the telescope's ephemeris but another orbit, and its
    /// distance from the ephemeris, km. It is searched like any other satellite.
    pub other_orbit: Option<(usize, f64)>,
}

impl Sky {
    /// Returns the sky in which the telescope in orbit is also recognised by its orbit from `first` to `last`, and the
    /// satellites that this concerns. A sky of a site is returned as it is.
    #[doc(hidden)]
    pub fn recognising_observer(self, first: Epoch, last: Epoch) -> (Self, OwnSatellites) {
        let Some(observer) = self.viewpoint().orbit() else { return (self, OwnSatellites::default()) };
        let from = seconds_after(first, -AROUND_S);
        let span_s = seconds_between(first, last) + 2.0 * AROUND_S;
        let times = (0..TIMES).map(|number| seconds_after(from, span_s * number as f64 / (TIMES - 1) as f64));
        // At times without a position of the telescope nothing is compared.
        let own: Vec<_> = times
            .chain([first, last])
            .filter_map(|epoch| {
                let orientation = self.orientation_over(epoch, epoch).at_s(0.0);
                Some((epoch, orientation, observer.state(epoch, &orientation).ok()?))
            })
            .collect();
        let has_number = |index: usize| observer.object().is_of(&self.elements()[index]);
        // A set is compared at the times at which its own error is small, or else at the time nearest to its epoch.
        let is_same = |index: usize| {
            let age_s = |epoch: Epoch| seconds_between(self.elements()[index].epoch, epoch).abs();
            let nearest_s = own.iter().map(|(epoch, ..)| age_s(*epoch)).fold(f64::INFINITY, f64::min);
            let is_compared =
                |(epoch, ..): &&(Epoch, Orientation, State<_>)| age_s(*epoch) <= nearest_s.max(EXACT_DAYS * DAY_S);
            let is_near = |(epoch, orientation, state): &(Epoch, Orientation, State<_>)| {
                self.relative_to(index, *epoch, orientation, state)
                    .is_some_and(|(km, km_s)| km <= SAME_KM && km_s <= SAME_KM_S)
            };
            !own.is_empty() && own.iter().filter(is_compared).all(is_near)
        };
        let is_real = |index: &usize| self.elements()[*index].origin == Origin::Published;
        let by_orbit: Vec<usize> =
            (0..self.elements().len()).filter(is_real).filter(|&index| !has_number(index) && is_same(index)).collect();
        let other_orbit = (0..self.elements().len()).find(|&index| has_number(index)).and_then(|index| {
            let (epoch, orientation, state) = own.get(own.len() / 2).filter(|_| observer.elements_epoch().is_none())?;
            let age_days = seconds_between(self.elements()[index].epoch, *epoch) / DAY_S;
            let (km, _) = self.relative_to(index, *epoch, orientation, state)?;
            (km > OTHER_KM && age_days.abs() <= LARGEST_AGE_DAYS).then_some((index, km))
        });
        if by_orbit.is_empty() && other_orbit.is_none() {
            return (self, OwnSatellites::default());
        }
        let number = |index: usize| self.elements()[index].norad_id;
        let (same, other) =
            (by_orbit.iter().map(|&index| number(index)).collect(), other_orbit.map(|(index, _)| number(index)));
        let observer = observer.clone().with_own_satellites(same, other);
        (self.seen_by_same(observer), OwnSatellites { by_orbit, other_orbit })
    }

    /// Returns distance and speed of a satellite relative to a state of the telescope, by its element set, km and km/s.
    fn relative_to(
        &self,
        index: usize,
        epoch: Epoch,
        orientation: &Orientation,
        own: &State<crate::frames::Gcrs>,
    ) -> Option<(f64, f64)> {
        let state = self.index().propagator(index)?.state(epoch, &orientation.teme_to_gcrs).ok()?;
        let position = state.position.vector() - own.position.vector();
        let velocity = state.velocity.vector() - own.velocity.vector();
        Some((position.norm(), velocity.norm()))
    }
}
