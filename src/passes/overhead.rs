//! Who stands above a site's horizon at one moment or over a short stretch of time.
//!
//! Altitudes are geometric (no refraction) against the WGS84 horizon of the site, as everywhere in this room.

use hifitime::Epoch;

use super::look::Look;
use super::sightline::{ObserverMotion, SightLine};
use super::sky::{PassOptions, Sky, SkyError, check_epoch};
use super::track::TrackPoint;
use crate::constants::DAY_S;
use crate::elements::NoradId;
use crate::frames::{seconds_after, seconds_between};
use crate::orbit::{Arc, LeftOut, OrbitError, Propagator};

/// The longest stretch, seconds: longer ones are nights, for [`Sky::horizon_passes`].
const LONGEST_S: f64 = 3600.0;
/// The most points of one track.
const MOST_POINTS: usize = 1000;
/// No satellite that is not leaving the Earth moves faster against a site, km/s.
const FASTEST_KM_S: f64 = 12.0;

/// One satellite above the horizon.
#[derive(Clone, Debug, PartialEq)]
pub struct Overhead {
    /// Who.
    pub norad_id: NoradId,
    /// Position of its element set in the sky's catalogue.
    pub element_index: usize,
    /// Where it is at the moments asked for, in their order; at some of them it may be below the altitude asked for.
    pub points: Vec<TrackPoint>,
}

impl Sky {
    /// Every satellite that stands at `min_altitude_rad` or higher at any of `moments` evenly spaced moments over `duration_s` seconds from `start` on,
    /// in catalogue order, on all threads; and the satellites that have no position then.
    ///
    /// One moment stands at the start, several reach from the start to the end. Satellites that are dark at all of them come only with
    /// `include_dark`; `min_probability` and `samples` of the options mean nothing here.
    ///
    /// # Errors
    /// [`SkyError::NoEphemeris`] outside the years of the Sun's ephemeris; [`SkyError::NoHorizon`] for an observer in orbit; [`SkyError::Exposure`] for an altitude
    /// below 0 or above π/2, more than an hour, no moments or more than a thousand.
    pub fn overhead(
        &self,
        start: Epoch,
        duration_s: f64,
        moments: usize,
        min_altitude_rad: f64,
        options: &PassOptions,
    ) -> Result<(Vec<Overhead>, Vec<LeftOut>), SkyError> {
        let refuse = |problem: String| Err(SkyError::Exposure { id: "overhead".to_owned(), problem });
        if !(0.0..=LONGEST_S).contains(&duration_s) {
            return refuse(format!("{duration_s} s (allowed: 0 to {LONGEST_S} s)"));
        }
        if !(1..=MOST_POINTS).contains(&moments) {
            return refuse(format!("{moments} moments (allowed: 1 to {MOST_POINTS})"));
        }
        if !(0.0..=std::f64::consts::FRAC_PI_2).contains(&min_altitude_rad) {
            let given_deg = min_altitude_rad.to_degrees();
            return refuse(format!("a lowest altitude of {given_deg} deg (allowed: 0 to 90 deg)"));
        }
        check_epoch(start)?;
        let observer = self.site_observer()?;
        let scene = self.scene_without_windows(start, duration_s);
        let mid_s = 0.5 * duration_s;
        let orientation = scene.orientation.at_s(mid_s);
        let here = observer.state(&orientation);
        let motion = ObserverMotion::of_site(observer, &orientation, scene.sun.at_s(mid_s).earth_velocity, mid_s);
        let times_s: Vec<f64> =
            (0..moments).map(|moment| duration_s * moment as f64 / (moments.max(2) - 1) as f64).collect();
        let overhead = |element_index: usize, propagator: &Propagator| -> Result<Option<Overhead>, OrbitError> {
            let minutes = propagator.minutes_since_epoch(start);
            let state = propagator.state_at_minutes(minutes + mid_s / 60.0, &orientation.teme_to_gcrs)?;
            // How far above the plane of the horizon it stands half way, and how much of that it can make good until the ends.
            let up_km = (here.horizon.matrix() * (state.position - here.position).vector()).z;
            if up_km < -FASTEST_KM_S * mid_s {
                return Ok(None);
            }
            let arc = Arc::new(propagator, minutes, 0.0, duration_s, &orientation.teme_to_gcrs)?;
            let line = SightLine { arc: &arc, observer: motion.clone() };
            let is_up = times_s.iter().any(|&time_s| {
                let here = observer.state(&scene.orientation.at_s(time_s));
                here.sine_of_altitude(&line.aspect_at(time_s).2.geometric) >= min_altitude_rad.sin()
            });
            if !is_up {
                return Ok(None);
            }
            let age_days = seconds_between(propagator.epoch(), seconds_after(start, mid_s)) / DAY_S;
            let look = Look {
                scene: &scene,
                viewpoint: self.viewpoint(),
                shadow: self.shadow(),
                line: &line,
                model: self.model(element_index),
                options,
                uncertainty: self.uncertainty(element_index, age_days),
            };
            let is_lit = || {
                let lit = |&time_s: &f64| {
                    let sun = scene.sun.at_s(time_s).sun;
                    self.shadow().illumination(&arc.state_at(time_s).position, &sun).lit_fraction() > 0.0
                };
                times_s.iter().any(lit)
            };
            if !options.include_dark && !is_lit() {
                return Ok(None);
            }
            let points = times_s.iter().filter_map(|&time_s| look.point(time_s)).collect();
            Ok(Some(Overhead { norad_id: propagator.norad_id(), element_index, points }))
        };
        Ok(self.survey(
            |_| true,
            |element_index, propagator, found| {
                found.extend(overhead(element_index, propagator)?);
                Ok(())
            },
        ))
    }
}
