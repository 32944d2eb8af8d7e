//! The full result for one candidate: crossing, light and probability.

use super::super::candidates::CandidateInterval;
use super::super::crossing::cross;
use super::super::probability::{Delays, REACH_SIGMAS, crossing_odds, crossing_probability_in_flight};
use super::super::track::{Chord, Pass, SightLine};
use super::exposed_field::ExposedField;
use super::options::PassOptions;
use crate::frames::seconds_after;
use crate::orbit::{Lateness, OrbitError, OrbitUncertainty};

impl ExposedField<'_> {
    /// The pass of one satellite; `None` where it does not cross, or the options exclude it.
    pub fn pass(&self, interval: &CandidateInterval, options: &PassOptions) -> Result<Option<Pass>, OrbitError> {
        let &CandidateInterval { element_index, start_s, end_s, .. } = interval;
        let (field, is_in_flight) = (&self.field, self.flight.is_some());
        let Some(satellite) = self.satellite(element_index, 0.5 * (start_s + end_s)) else { return Ok(None) };
        let sigma = satellite.uncertainty;
        let arc = satellite.arc(start_s, end_s)?;
        let line = SightLine { arc: &arc, observer: satellite.observer.clone() };
        let mut crossing = cross(&|time_s| line.sight(time_s), start_s, end_s, field);
        if crossing.chords.is_empty() && options.min_probability.is_none() {
            return Ok(None);
        }
        let photometry = (!options.without_light).then_some(&options.photometry);
        let evaluator = self.evaluator(&line, element_index, photometry, sigma);
        let near_the_ground = self.sky.reaches_the_ground(self.exposure, field, &satellite.orientation);
        let Some((enter_s, exit_s)) = evaluator.keep_above_ground(&mut crossing, near_the_ground) else {
            return Ok(None);
        };
        let lit = evaluator.is_lit(enter_s, exit_s);
        if !(lit || options.include_dark) {
            return Ok(None);
        }

        let middle_s = 0.5 * (enter_s + exit_s);
        let points = [enter_s, middle_s, exit_s].map(|time_s| evaluator.point(time_s));
        let [Some(enter), Some(mid), Some(exit)] = points else { return Ok(None) };
        let cross_track_sigma_rad = sigma.cross_track_km / mid.range_km;
        let lateness = sigma.lateness;
        if crossing.chords.is_empty() && is_in_flight && !self.may_cross(&line, interval, &lateness, &sigma) {
            return Ok(None);
        }
        let searched_s = (start_s - lateness.reach_s(), end_s + lateness.reach_s());
        let probability = match satellite.arc(searched_s.0, searched_s.1) {
            Ok(wide) if is_in_flight => {
                let line = SightLine { arc: &wide, observer: line.observer.clone() };
                crossing_probability_in_flight(
                    &|time_s, late_s| line.delayed_sight(time_s, late_s),
                    (start_s, end_s),
                    field,
                    &lateness,
                    cross_track_sigma_rad,
                )
            }
            Ok(wide) => {
                // A satellite that a delay brings into the exposure is seen from the site's position in the exposure.
                let line =
                    SightLine { arc: &wide, observer: line.observer.still_outside(self.opened_s, self.closed_s) };
                let track = |time_s: f64| line.sight(time_s);
                let nominal = cross(&track, searched_s.0, searched_s.1, field);
                let delays = Delays { start_s: self.opened_s, end_s: self.closed_s, lateness, only_entering: false };
                crossing_odds(&track, &nominal, searched_s, &delays, field, cross_track_sigma_rad).probability
            }
            // SGP4 fails just outside the exposure: the nominal crossing stands, near misses are unknown.
            Err(_) => f64::from(u8::from(!crossing.chords.is_empty())),
        };
        if crossing.chords.is_empty() && options.min_probability.is_none_or(|least| probability < least) {
            return Ok(None);
        }
        let (position_angle_rad, angular_rate_rad_s) = evaluator.motion(middle_s);
        Ok(Some(Pass {
            norad_id: satellite.propagator.norad_id(),
            element_index,
            peak: evaluator.peak(enter_s, exit_s),
            samples: evaluator.samples(enter_s, exit_s, options.samples),
            streak_length_rad: crossing.chords.iter().map(|chord| evaluator.length_rad(chord)).sum(),
            chords: self.after_opening(&crossing.chords),
            enter,
            mid,
            exit,
            min_separation_rad: crossing.min_separation_rad,
            position_angle_rad,
            angular_rate_rad_s,
            element_age_days: self.sky.element_age_days(element_index, seconds_after(self.scene.start, middle_s)),
            along_track_sigma_s: sigma.along_track_s,
            cross_track_sigma_rad,
            probability,
            lit,
        }))
    }

    /// Chords in seconds after the shutter opened.
    pub fn after_opening(&self, chords: &[Chord]) -> Vec<Chord> {
        let shifted =
            |chord: &Chord| Chord { enter_s: chord.enter_s - self.opened_s, exit_s: chord.exit_s - self.opened_s };
        chords.iter().map(shifted).collect()
    }

    /// For an observer in orbit: whether errors of the elements can bring a satellite into the field at all, from a few
    /// positions.
    fn may_cross(
        &self,
        line: &SightLine<'_>,
        interval: &CandidateInterval,
        lateness: &Lateness,
        sigma: &OrbitUncertainty,
    ) -> bool {
        let mut time_s = interval.start_s;
        loop {
            let sight = line.sight(time_s);
            let (state, _, aspect) = line.aspect_at(time_s);
            // A late satellite is elsewhere on its curved path, never farther than this.
            let strayed_km =
                1.1 * state.velocity.norm_km_s() * lateness.reach_s() + 1.5 * REACH_SIGMAS * sigma.cross_track_km;
            let relative_km_s = sight.rate_s.norm() * aspect.range_km;
            let step_s = (0.1 * aspect.range_km / relative_km_s.max(1e-6)).clamp(0.05, 5.0);
            let reach_rad = ((strayed_km + relative_km_s * step_s) / aspect.range_km).min(1.0).asin();
            let angle_rad = aspect.direction.vector().angle(self.field.centre());
            if angle_rad <= self.field.bounding_radius_rad() + 1.1 * reach_rad {
                return true;
            }
            if time_s >= interval.end_s {
                return false;
            }
            time_s = (time_s + step_s).min(interval.end_s);
        }
    }
}
