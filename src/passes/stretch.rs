//! Satellites about one exposure as they would be seen if they were late: for those who hold a prediction against what was measured.
//!
//! A satellite that is late by δ stands at time t where its element set has it at t - δ. The observer is where it is at t, so that a
//! late satellite takes a slightly different way among the stars, not the same one later (0.5° apart for 10 s at 550 km).

use std::sync::Arc as Shared;

use nalgebra::Vector3;

use super::exposure::Exposure;
use super::look::Look;
use super::scene::Scene;
use super::sightline::{ObserverMotion, SightLine};
use super::sky::{PassOptions, Sky, SkyError, check};
use super::track::{Chord, TrackPoint};
use crate::constants::DAY_S;
use crate::frames::{Direction, Gcrs, Orientation, Position, seconds_after, seconds_between};
use crate::geometry::aspect;
use crate::orbit::{Arc, OrbitError, OrbitUncertainty, Propagator, State};
use crate::photometry::PhotometryOptions;

/// Tracks reach so far beyond the exposure on both sides, seconds.
const MARGIN_S: f64 = 60.0;

/// A sky over one exposure. Times are seconds after shutter opening.
pub struct Stretch<'s> {
    sky: &'s Sky,
    scene: Scene,
    orientation: Orientation,
    motion: ObserverMotion,
    duration_s: f64,
}

/// A satellite as the observer sees it at one moment.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Sighting {
    /// ICRS astrometric topocentric direction.
    pub direction: Direction<Gcrs>,
    /// How this direction changes with the satellite's own motion alone, the observer standing still: at right angles to it, rad/s.
    pub own_rate: Vector3<f64>,
    /// Distance from the observer, km.
    pub range_km: f64,
}

/// The track of a satellite that is late by a certain time.
pub struct LateTrack<'s> {
    stretch: &'s Stretch<'s>,
    element_index: usize,
    arc: Arc,
}

impl Sky {
    /// What the tracks of late satellites over one exposure share.
    ///
    /// # Errors
    /// [`SkyError`] where the exposure has no finite length or direction, or lies outside the years of the Sun's ephemeris; where the telescope is
    /// in orbit and its own elements give no place.
    pub fn stretch(&self, exposure: &Exposure) -> Result<Stretch<'_>, SkyError> {
        check(exposure)?;
        let start = seconds_after(exposure.start, -MARGIN_S);
        let scene = self.scene_without_windows(start, exposure.duration_s + 2.0 * MARGIN_S);
        let flight: Option<Shared<Arc>> = self.flight(&scene, exposure)?;
        let mid_s = MARGIN_S + 0.5 * exposure.duration_s;
        let orientation = scene.orientation.at_s(mid_s);
        let motion =
            self.motion(&scene, &orientation, flight.as_ref(), mid_s).ok_or(SkyError::NoEphemeris { epoch: start })?;
        Ok(Stretch { sky: self, scene, orientation, motion, duration_s: exposure.duration_s })
    }
}

impl Stretch<'_> {
    /// The sky.
    pub fn sky(&self) -> &Sky {
        self.sky
    }

    /// Length of the exposure, seconds.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// SGP4 of an element set; `None` where it cannot start, and for the telescope itself.
    pub fn propagator(&self, element_index: usize) -> Option<&Propagator> {
        if self.sky.is_observer(element_index) { None } else { self.sky.index().propagator(element_index) }
    }

    /// The moment of a time.
    pub fn epoch(&self, time_s: f64) -> hifitime::Epoch {
        seconds_after(self.scene.start, MARGIN_S + time_s)
    }

    /// Geocentric place of the observer.
    pub fn observer(&self, time_s: f64) -> Position<Gcrs> {
        self.motion.position(MARGIN_S + time_s)
    }

    /// Geocentric state of a satellite that is late, by SGP4 itself.
    ///
    /// # Errors
    /// [`OrbitError`].
    pub fn state(&self, propagator: &Propagator, time_s: f64, late_s: f64) -> Result<State<Gcrs>, OrbitError> {
        let minutes = propagator.minutes_since_epoch(self.scene.start) + (MARGIN_S + time_s - late_s) / 60.0;
        propagator.state_at_minutes(minutes, &self.orientation.teme_to_gcrs)
    }

    /// A late satellite as it is seen, by SGP4 itself.
    ///
    /// # Errors
    /// [`OrbitError`].
    pub fn sighting(&self, propagator: &Propagator, time_s: f64, late_s: f64) -> Result<Sighting, OrbitError> {
        let state = self.state(propagator, time_s, late_s)?;
        let earth_velocity = self.scene.sun.at_s(MARGIN_S + time_s).earth_velocity;
        let seen = aspect(&state.position, &state.velocity, &self.observer(time_s), &earth_velocity);
        let line = seen.direction.vector();
        let velocity = state.velocity.vector();
        let own_rate = (velocity - line * line.dot(velocity)) / seen.range_km;
        Ok(Sighting { direction: seen.direction, own_rate, range_km: seen.range_km })
    }

    /// Days from the epoch of an element set to a time.
    pub fn element_age_days(&self, propagator: &Propagator, time_s: f64) -> f64 {
        seconds_between(propagator.epoch(), self.epoch(time_s)) / DAY_S
    }

    /// One-sigma errors of the prediction of a satellite.
    pub fn uncertainty(&self, element_index: usize, age_days: f64) -> OrbitUncertainty {
        self.sky.uncertainty(element_index, age_days)
    }

    /// The whole track of a satellite that is late, from a minute before the exposure to a minute after it.
    ///
    /// # Errors
    /// [`OrbitError`]; an observer has no track of itself and is reported as one without elements.
    pub fn track(&self, element_index: usize, late_s: f64) -> Result<LateTrack<'_>, OrbitError> {
        let propagator = self.propagator(element_index).ok_or_else(|| OrbitError::Elements {
            norad_id: self.sky.elements()[element_index].norad_id,
            reason: "no track".to_owned(),
        })?;
        let minutes = propagator.minutes_since_epoch(self.scene.start) - late_s / 60.0;
        let span_s = self.duration_s + 2.0 * MARGIN_S;
        let arc = Arc::new(propagator, minutes, 0.0, span_s, &self.orientation.teme_to_gcrs)?;
        Ok(LateTrack { stretch: self, element_index, arc })
    }
}

impl LateTrack<'_> {
    /// Tracks reach so far beyond the exposure on both sides, seconds.
    pub const MARGIN_S: f64 = MARGIN_S;

    fn line(&self) -> SightLine<'_> {
        SightLine { arc: &self.arc, observer: self.stretch.motion.clone() }
    }

    /// Earliest and latest time of the track, seconds after shutter opening.
    pub fn times_s(&self) -> [f64; 2] {
        [-MARGIN_S, self.stretch.duration_s + MARGIN_S]
    }

    /// The direction, and its rate of change by the motions of satellite and observer, at right angles to it, rad/s.
    pub fn place(&self, time_s: f64) -> (Direction<Gcrs>, Vector3<f64>) {
        let sight = self.line().sight(MARGIN_S + time_s);
        let along = sight.vector * sight.vector.dot(&sight.rate_s);
        (Direction::from_vector(sight.vector), sight.rate_s - along)
    }

    /// When the track passes nearest to a direction, looked for from a first guess; within [`LateTrack::times_s`].
    pub fn nearest_s(&self, direction: &Direction<Gcrs>, guess_s: f64) -> f64 {
        let [first_s, last_s] = self.times_s();
        let mut time_s = guess_s.clamp(first_s, last_s);
        // Newton on the distance along the track: the way left over the rate.
        for _ in 0..8 {
            let (_, rate) = self.place(time_s);
            let step_s = direction.vector().dot(&rate) / rate.norm_squared().max(1e-18);
            let next_s = (time_s + step_s).clamp(first_s, last_s);
            if (next_s - time_s).abs() < 1e-6 {
                return next_s;
            }
            time_s = next_s;
        }
        time_s
    }

    /// All that is seen at a time, light included; `None` only where observer and satellite coincide.
    pub fn point(&self, time_s: f64, photometry: &PhotometryOptions) -> Option<TrackPoint> {
        let options = PassOptions { photometry: *photometry, ..PassOptions::default() };
        let line = self.line();
        self.look(&line, &options, time_s).point(MARGIN_S + time_s)
    }

    /// True where it stands above the ground (or clear of the Earth, for an observer in orbit) at a time.
    pub fn is_up(&self, time_s: f64) -> bool {
        let (line, options) = (self.line(), PassOptions::default());
        let at_s = MARGIN_S + time_s;
        let moment = Chord { enter_s: at_s, exit_s: at_s };
        !self.look(&line, &options, time_s).above_ground(&moment).is_empty()
    }

    fn look<'a>(&'a self, line: &'a SightLine<'a>, options: &'a PassOptions, time_s: f64) -> Look<'a> {
        let sky = self.stretch.sky;
        let age_days = self
            .stretch
            .propagator(self.element_index)
            .map_or(0.0, |propagator| self.stretch.element_age_days(propagator, time_s));
        Look {
            scene: &self.stretch.scene,
            viewpoint: sky.viewpoint(),
            shadow: sky.shadow(),
            line,
            model: sky.model(self.element_index),
            options,
            uncertainty: sky.uncertainty(self.element_index, age_days),
        }
    }
}
