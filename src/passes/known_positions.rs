//! Satellites of a sky whose position is known at a time.

use std::sync::Arc;

use hifitime::Epoch;
use rayon::prelude::*;

use super::altaz::AltAz;
use super::exposure::Exposure;
use super::field::Field;
use super::predictability::{KnownLateness, Predictability, SatelliteLateness};
use super::scene::{middle_of_window, window_number};
use super::sky::Sky;
use crate::error::Error;
use crate::frames::seconds_after;
use crate::orbit::Propagator;

impl Sky {
    /// Returns how well the positions of all satellites are known at a time, in steps of six hours, and whether that of
    /// a telescope in orbit is known well enough for crossings of the field.
    #[doc(hidden)]
    pub fn predictability(&self, epoch: Epoch, field: Option<&Field>) -> Predictability {
        let mut known = Predictability::clone(&self.predictability_of_satellites(epoch));
        if let (Some(observer), Some(field)) = (self.viewpoint().orbit(), field) {
            known.unknown_observer = observer.reason_unknown(epoch, field.bounding_radius_rad());
        }
        known
    }

    /// Returns a warning if the position of a telescope in orbit is not known well enough at a time for the crossings
    /// of a circle on the sky, such as that around a frame. `of` names what is searched in the circle.
    pub(crate) fn unknown_observer_warning(&self, of: &str, epoch: Epoch, radius_rad: f64) -> Option<String> {
        let (reason, _) = self.viewpoint().orbit()?.reason_unknown(epoch, radius_rad)?;
        Some(format!("{of}: {reason}: most predictions are wrong; specify elements of the telescope of that time"))
    }

    /// Returns warnings about a frame of this exposure, whose name is `exposure.id`: an unknown position of a telescope
    /// in orbit; a field below the horizon of the site, or the Sun above it, which show that the time or the site is
    /// wrong.
    #[doc(hidden)]
    pub fn frame_warnings(&self, exposure: &Exposure, radius_rad: f64) -> Vec<String> {
        let of_observer = self.unknown_observer_warning(&exposure.id, exposure.start, radius_rad);
        of_observer.into_iter().chain(self.wrong_header_warning(exposure)).collect()
    }

    fn wrong_header_warning(&self, exposure: &Exposure) -> Option<String> {
        // The horizon is lower by refraction.
        const HORIZON_DEG: f64 = -0.6;
        let middle = seconds_after(exposure.start, 0.5 * exposure.duration_s);
        let altitude_deg = |found: Result<AltAz, Error>| found.ok().map(|altaz| altaz.altitude_rad.to_degrees());
        let of_field =
            || altitude_deg(self.pointing_altaz(&exposure.pointing, middle)).filter(|deg| *deg < HORIZON_DEG);
        let of_sun = || altitude_deg(self.sun_altaz(middle)).filter(|deg| *deg > HORIZON_DEG);
        let (what, deg) =
            of_field().map(|deg| ("the middle of the frame", deg)).or_else(|| Some(("the Sun", of_sun()?)))?;
        Some(format!(
            "{}: {what} is at an altitude of {deg:.1} deg: the start or the site is wrong, perhaps a local time",
            exposure.id
        ))
    }

    fn predictability_of_satellites(&self, epoch: Epoch) -> Arc<Predictability> {
        let number = window_number(epoch);
        if let Some(found) = self.predictabilities().find(number) {
            return found;
        }
        let middle = middle_of_window(number);
        let of_one = |element_index: usize| {
            if self.is_observer(element_index) {
                return None;
            }
            let propagator = self.index().propagator_over(element_index, [middle, middle])?;
            let known = || {
                let uncertainty = self.uncertainty_of(element_index, propagator, middle);
                KnownLateness {
                    late_s: uncertainty.along_track_s,
                    searched_share: uncertainty.lateness.searched_share(),
                }
            };
            let is_known = self.unknown_position(element_index, propagator, middle).is_none();
            Some(SatelliteLateness {
                element_index: element_index as u32,
                age_days: self.element_age_days(element_index, middle),
                known: is_known.then(known),
            })
        };
        let all: Vec<_> = (0..self.elements().len()).into_par_iter().with_min_len(64).filter_map(of_one).collect();
        let found = Arc::new(Predictability::new(&all, |element_index| {
            let propagator = self.index().propagator_over(element_index, [middle, middle])?;
            Some(self.uncertainty_of(element_index, propagator, middle).lateness)
        }));
        self.predictabilities().keep(number, &found);
        found
    }

    /// Returns the reason why the position of a satellite is unknown at a time; `None` if it is known.
    pub(super) fn unknown_position(
        &self,
        element_index: usize,
        propagator: &Propagator,
        epoch: Epoch,
    ) -> Option<Error> {
        if propagator.has_ephemeris() { None } else { self.too_old(element_index, epoch) }
    }
}
