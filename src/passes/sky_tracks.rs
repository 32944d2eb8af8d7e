//! Whom a site has above it at several moments of a short stretch of time, told in places alone with one look at the light: what maps of the sky are
//! made of. All that is told of each point is of [`Sky::overhead`].

use hifitime::Epoch;
use rayon::prelude::*;

use super::expose::{Dark, Run};
use super::exposure::Exposure;
use super::field::Field;
use super::scene::Scene;
use super::sightline::SightLine;
use super::sky::{Sky, SkyError, check_epoch};
use crate::constants::EARTH_ROTATION_RAD_S;
use crate::elements::NoradId;
use crate::frames::{Direction, Gcrs, Position, seconds_after};
use crate::geometry::{ObserverState, ViewingGeometry};
use crate::orbit::{Arc, LeftOut, OrbitError};
use crate::photometry::{Brightness, PhotometryOptions};

/// The longest stretch, seconds: the site is not to turn too far under the cone that satellites are looked for in.
const LONGEST_S: f64 = 3600.0;
/// The most moments of one question.
const MOST_MOMENTS: usize = 10_000;
/// Satellites that a thread takes at a time at least.
const TOGETHER: usize = 16;

/// What is wanted of satellites over a site.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SkyTrackOptions {
    /// The lowest altitude, geometric, radians, 0 to π/2.
    pub min_altitude_rad: f64,
    /// Satellites in the umbra too.
    pub include_dark: bool,
    /// Which magnitude; `None` where light is not asked about.
    pub photometry: Option<PhotometryOptions>,
}

/// One satellite over a site.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyTrack {
    /// Who.
    pub norad_id: NoradId,
    /// Position of its element set in the sky's catalogue.
    pub element_index: usize,
    /// Those of the moments at which it stands above the altitude and is lit, in the order of time: number of the moment, and the direction (ICRS, astrometric). At
    /// least one.
    pub places: Vec<(usize, Direction<Gcrs>)>,
    /// Distance at the middle one of the places, km.
    pub range_km: f64,
    /// Speed among the stars there, rad/s.
    pub angular_rate_rad_s: f64,
    /// Its light there, the sigma without the error of the elements; `None` where it was not asked for, in the umbra, and where a model sees nothing.
    pub brightness: Option<Brightness>,
}

/// Site and Sun at one of the moments.
struct Moment {
    time_s: f64,
    here: ObserverState,
    sun: Position<Gcrs>,
}

impl Sky {
    /// Every satellite that stands above an altitude at any of `moments_s` (seconds after `start`, 0 to an hour, in the order of time), in catalogue order, on all
    /// threads; and the satellites that have no position then.
    ///
    /// # Errors
    /// [`SkyError::NoEphemeris`] outside the years of the Sun's ephemeris; [`SkyError::NoHorizon`] for an observer in orbit; [`SkyError::Exposure`] for an altitude
    /// below 0 or above π/2, moments out of order or later than an hour, none or more than ten thousand.
    pub fn sky_tracks(
        &self,
        start: Epoch,
        moments_s: &[f64],
        options: &SkyTrackOptions,
    ) -> Result<(Vec<SkyTrack>, Vec<LeftOut>), SkyError> {
        check(moments_s, options)?;
        check_epoch(start)?;
        let observer = self.site_observer()?;
        let (Some(&first_s), Some(&last_s)) = (moments_s.first(), moments_s.last()) else {
            return Ok((Vec::new(), Vec::new()));
        };
        let scene = self.scene(start, last_s, false);
        let moment = |&time_s: &f64| Moment {
            time_s,
            here: observer.state(&scene.orientation.at_s(time_s)),
            sun: scene.sun.at_s(time_s).sun,
        };
        let moments: Vec<Moment> = moments_s.iter().map(moment).collect();
        // All of the sky above the altitude as one round field about the zenith of the middle, as wide as that zenith moves to both sides.
        let half_s = 0.5 * (last_s - first_s);
        let to_gcrs = observer.state(&scene.orientation.at_s(first_s + half_s)).horizon.inverse();
        let zenith = to_gcrs * Direction::from_lon_lat_rad(0.0, std::f64::consts::FRAC_PI_2);
        let reach_rad = std::f64::consts::FRAC_PI_2 - options.min_altitude_rad + EARTH_ROTATION_RAD_S * half_s;
        let exposure = Exposure {
            id: "sky".to_owned(),
            start: seconds_after(start, first_s),
            duration_s: last_s - first_s,
            pointing: zenith,
            rotation_rad: 0.0,
        };
        let field = Field::circle((2.0 * reach_rad).clamp(1e-3, std::f64::consts::PI))
            .map_err(|error| refusal(error.to_string()))?;
        let dark = if options.include_dark { Dark::Wanted } else { Dark::LeftOut };
        let on_sky = field.on_sky(&exposure.pointing, 0.0);
        let runs = self.runs(&scene, &exposure, &on_sky, None, dark, &mut Vec::new());
        let looked: Vec<Result<Option<SkyTrack>, LeftOut>> = runs
            .par_iter()
            .with_min_len(TOGETHER)
            .map(|run| {
                self.sky_track(&scene, &moments, run, options).map_err(|reason| LeftOut {
                    norad_id: self.elements()[run.element_index].norad_id,
                    element_index: run.element_index,
                    reason,
                })
            })
            .collect();
        let of_windows = scene.windows.iter().flat_map(|window| window.left_out());
        let mut left_out: Vec<LeftOut> = self.left_out().iter().chain(of_windows).cloned().collect();
        let mut tracks = Vec::new();
        for look in looked {
            match look {
                Ok(track) => tracks.extend(track),
                Err(failed) => left_out.push(failed),
            }
        }
        left_out.sort_by_key(|one| one.element_index);
        left_out.dedup_by_key(|one| one.element_index);
        Ok((tracks, left_out))
    }

    fn sky_track(
        &self,
        scene: &Scene,
        moments: &[Moment],
        run: &Run,
        options: &SkyTrackOptions,
    ) -> Result<Option<SkyTrack>, OrbitError> {
        let [from_s, to_s] = run.near_s;
        let Some(propagator) = self.index().propagator(run.element_index) else { return Ok(None) };
        let mid_s = 0.5 * (from_s + to_s);
        let orientation = scene.orientation.at_s(mid_s);
        let Some(observer) = self.motion(scene, &orientation, None, mid_s) else { return Ok(None) };
        let minutes = propagator.minutes_since_epoch(scene.start);
        let arc = Arc::new(propagator, minutes, from_s, to_s - from_s, &orientation.teme_to_gcrs)?;
        let line = SightLine { arc: &arc, observer };
        let lowest = options.min_altitude_rad.sin();
        let near = moments.partition_point(|moment| moment.time_s < from_s)
            ..moments.partition_point(|moment| moment.time_s <= to_s);
        let place = |number: usize| {
            let moment = &moments[number];
            let (state, _, aspect) = line.aspect_at(moment.time_s);
            let is_up = moment.here.sine_of_altitude(&aspect.geometric) >= lowest;
            let is_lit = || self.shadow().illumination(&state.position, &moment.sun).lit_fraction() > 0.0;
            (is_up && (options.include_dark || is_lit())).then_some((number, aspect.direction))
        };
        let places: Vec<(usize, Direction<Gcrs>)> = near.filter_map(place).collect();
        let Some(&(middle, _)) = places.get(places.len() / 2) else { return Ok(None) };
        let Moment { time_s, sun, .. } = &moments[middle];
        let (state, here, aspect) = line.aspect_at(*time_s);
        let light = |photometry: &PhotometryOptions| {
            let lit = self.shadow().illumination(&state.position, sun).lit_fraction();
            let geometry = ViewingGeometry::new(&state.position, &here, sun)?;
            self.model(run.element_index).brightness(&geometry, lit, photometry)
        };
        let sight = line.sight(*time_s);
        Ok(Some(SkyTrack {
            norad_id: propagator.norad_id(),
            element_index: run.element_index,
            range_km: aspect.range_km,
            // ω = |ŝ × dŝ/dt|
            angular_rate_rad_s: sight.vector.cross(&sight.rate_s).norm(),
            brightness: options.photometry.as_ref().and_then(light),
            places,
        }))
    }
}

fn refusal(problem: String) -> SkyError {
    SkyError::Exposure { id: "sky".to_owned(), problem }
}

fn check(moments_s: &[f64], options: &SkyTrackOptions) -> Result<(), SkyError> {
    if !(0.0..=std::f64::consts::FRAC_PI_2).contains(&options.min_altitude_rad) {
        let given_deg = options.min_altitude_rad.to_degrees();
        return Err(refusal(format!("a lowest altitude of {given_deg} deg (allowed: 0 to 90 deg)")));
    }
    let count = moments_s.len();
    if !(1..=MOST_MOMENTS).contains(&count) {
        return Err(refusal(format!("{count} moments (allowed: 1 to {MOST_MOMENTS})")));
    }
    let in_order = moments_s.windows(2).all(|pair| pair[0] < pair[1]);
    if let Some(bad_s) = moments_s.iter().find(|time_s| !(0.0..=LONGEST_S).contains(*time_s)) {
        return Err(refusal(format!("a moment {bad_s} s after the start (allowed: 0 to {LONGEST_S} s)")));
    }
    if in_order { Ok(()) } else { Err(refusal("moments that are not in the order of time".to_owned())) }
}
