//! Who stands above a site's horizon at one moment or over a short stretch of time, and where Sun and pointing stand.
//!
//! Altitudes are geometric (no refraction) against the WGS84 horizon of the site, as everywhere in this room.

use hifitime::Epoch;
use rayon::prelude::*;

use super::look::Look;
use super::sightline::{ObserverMotion, SightLine};
use super::sky::{PassOptions, Sky, SkyError, check_epoch};
use super::track::TrackPoint;
use crate::catalogue::NoradId;
use crate::constants::DAY_S;
use crate::frames::{Direction, Gcrs, seconds_after, seconds_between};
use crate::orbit::{Arc, LeftOut, OrbitError};

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

/// Sun or pointing over a site at one moment.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Horizontally {
    /// Above the horizon, geometric, radians.
    pub altitude_rad: f64,
    /// From north through east, [0, 2π), radians.
    pub azimuth_rad: f64,
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
        let overhead = |element_index: usize| -> Result<Option<Overhead>, OrbitError> {
            let Some(propagator) = self.index().propagator(element_index) else { return Ok(None) };
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
        let answers: Vec<Result<Option<Overhead>, LeftOut>> = (0..self.elements().len())
            .into_par_iter()
            .with_min_len(64)
            .map(|element_index| {
                let norad_id = self.elements()[element_index].norad_id;
                overhead(element_index).map_err(|reason| LeftOut { norad_id, element_index, reason })
            })
            .collect();
        let mut left_out = self.left_out().to_vec();
        let mut found = Vec::new();
        for answer in answers {
            match answer {
                Ok(overhead) => found.extend(overhead),
                Err(failed) => left_out.push(failed),
            }
        }
        left_out.sort_by_key(|left_out| left_out.element_index);
        Ok((found, left_out))
    }

    /// Where the Sun stands over the site at `count` moments, `step_s` apart from `start` on.
    ///
    /// # Errors
    /// As [`Sky::overhead`], for the epoch and the observer.
    pub fn sun_over_site(&self, start: Epoch, step_s: f64, count: usize) -> Result<Vec<Horizontally>, SkyError> {
        check_epoch(start)?;
        let observer = self.site_observer()?;
        let scene = self.scene_without_windows(start, step_s * count as f64);
        let at = |step: usize| {
            let time_s = step_s * step as f64;
            let here = observer.state(&scene.orientation.at_s(time_s));
            let (altitude_rad, azimuth_rad) =
                here.altitude_azimuth_rad(&(scene.sun.at_s(time_s).sun - here.position)).unwrap_or((f64::NAN, 0.0));
            Horizontally { altitude_rad, azimuth_rad }
        };
        Ok((0..count).map(at).collect())
    }

    /// Where a pointing stands over the site, without aberration (25" at most).
    ///
    /// # Errors
    /// As [`Sky::overhead`], for the epoch and the observer.
    pub fn pointing_over_site(&self, pointing: &Direction<Gcrs>, epoch: Epoch) -> Result<Horizontally, SkyError> {
        check_epoch(epoch)?;
        let orientation = self.orientation_over(epoch, epoch).at_s(0.0);
        let direction = self.site_observer()?.state(&orientation).horizon * *pointing;
        Ok(Horizontally { altitude_rad: direction.latitude_rad(), azimuth_rad: direction.longitude_rad() })
    }
}
