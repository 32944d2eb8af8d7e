//! Pass of one candidate satellite: its crossing, brightness and probability.

use super::super::candidates::CandidateInterval;
use super::super::crossing::cross;
use super::super::probability::{REACH_SIGMAS, crossing_probability_in_flight};
use super::super::track::{Chord, Pass, SightLine};
use super::exposed_field::ExposedField;
use super::options::PassOptions;
use crate::error::Error;
use crate::frames::seconds_after;
use crate::orbit::{Lateness, OrbitUncertainty};

impl ExposedField<'_> {
    /// Returns the pass of one satellite; `None` if it does not cross the field or the options exclude it.
    pub fn pass(&self, interval: &CandidateInterval, options: &PassOptions) -> Result<Option<Pass>, Error> {
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
        // In thermal bands no satellite is dark.
        let band = options.photometry.band;
        let lit_chords: Vec<Chord> = if band.is_thermal() {
            crossing.chords.clone()
        } else {
            crossing.chords.iter().flat_map(|chord| evaluator.lit_parts(chord)).collect()
        };
        let lit = band.is_thermal()
            || if crossing.chords.is_empty() { evaluator.is_lit(enter_s, exit_s) } else { !lit_chords.is_empty() };
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
        let is_certain = options.without_probability && !crossing.chords.is_empty();
        let wide = (!is_certain).then(|| satellite.arc(searched_s.0, searched_s.1));
        let probability = match (wide, self.sky.viewpoint().site()) {
            (None, _) => 1.0,
            (Some(Ok(wide)), Some(site)) => self.probability_at_site(site, element_index, &wide, searched_s, sigma),
            (Some(Ok(wide)), None) => {
                let line = SightLine { arc: &wide, observer: line.observer.clone() };
                crossing_probability_in_flight(
                    &|time_s, late_s| line.delayed_sight(time_s, late_s),
                    (start_s, end_s),
                    field,
                    &lateness,
                    cross_track_sigma_rad,
                )
            }
            // SGP4 fails just outside the exposure. The nominal crossing is known, but the probability of near misses
            // is not.
            (Some(Err(_)), _) => f64::from(u8::from(!crossing.chords.is_empty())),
        };
        if crossing.chords.is_empty() && options.min_probability.is_none_or(|least| probability < least) {
            return Ok(None);
        }
        let (position_angle_rad, angular_rate_rad_s) = evaluator.motion(middle_s);
        let length_rad = |chords: &[Chord]| -> f64 { chords.iter().map(|chord| evaluator.length_rad(chord)).sum() };
        let streak_length_rad = length_rad(&lit_chords);
        let is_all_lit = lit_chords == crossing.chords;
        Ok(Some(Pass {
            norad_id: satellite.propagator.norad_id(),
            element_index,
            peak: if lit || band.has_emission() { evaluator.peak(enter_s, exit_s) } else { None },
            samples: evaluator.samples(enter_s, exit_s, options.samples),
            streak_length_rad,
            track_length_rad: if is_all_lit { streak_length_rad } else { length_rad(&crossing.chords) },
            chords: self.after_opening(&crossing.chords),
            lit_chords: self.after_opening(&lit_chords),
            enter,
            mid,
            exit,
            min_separation_rad: crossing.min_separation_rad,
            position_angle_rad,
            angular_rate_rad_s,
            position_source: satellite.propagator.position_source(),
            element_age_days: self.sky.element_age_days(element_index, seconds_after(self.scene.start, middle_s)),
            along_track_sigma_s: sigma.along_track_s,
            cross_track_sigma_rad,
            probability,
            lit,
        }))
    }

    /// Converts the times of chords from seconds after the start of the scene to seconds after the shutter opened.
    pub fn after_opening(&self, chords: &[Chord]) -> Vec<Chord> {
        let shifted =
            |chord: &Chord| Chord { enter_s: chord.enter_s - self.opened_s, exit_s: chord.exit_s - self.opened_s };
        chords.iter().map(shifted).collect()
    }

    /// Returns false if no error of the elements can bring the satellite into the field of an observer in orbit. A few
    /// positions of the satellite suffice for this test.
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
            // Upper bound of the distance between predicted and true position, with a margin for the curvature of the
            // path.
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
