//! Tracks of delayed satellites during one exposure, for comparison with a measured streak.
//!
//! A satellite that is delayed by δ is at time t where its element set predicts it for t - δ. The observer moves during
//! the delay, so the delayed satellite takes a different path relative to the stars. For a delay of 10 s and a height
//! of 550 km, this path is up to 0.5° from the predicted path.

use nalgebra::Vector3;

use super::error;
use super::evaluator::PassEvaluator;
use super::exposure::Exposure;
use super::scene::Scene;
use super::sky::Sky;
use super::track::{Chord, ObserverMotion, SightLine, TrackPoint};
use crate::constants::DAY_S;
use crate::error::Error;
use crate::frames::{Direction, Gcrs, Orientation, Position, seconds_after, seconds_between};
use crate::geometry::aspect;
use crate::orbit::{OrbitArc, OrbitUncertainty, Propagator, State, not_initialised};
use crate::photometry::PhotometryOptions;

/// Time by which tracks extend beyond both ends of the exposure, seconds.
const MARGIN_S: f64 = 60.0;

/// A sky during one exposure and a minute before and after it. Times are seconds after the shutter opened.
pub struct ExposureInterval<'s> {
    sky: &'s Sky,
    scene: Scene,
    orientation: Orientation,
    motion: ObserverMotion,
    duration_s: f64,
}

/// Direction and distance of a satellite at one time.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Sighting {
    /// ICRS astrometric topocentric direction.
    pub direction: Direction<Gcrs>,
    /// Rate of the direction due to the satellite's motion alone (for an observer at rest), perpendicular to the
    /// direction, rad/s.
    pub own_rate: Vector3<f64>,
    /// Distance from the observer, km.
    pub range_km: f64,
}

/// Track of a satellite that is late by a given delay.
pub struct DelayedTrack<'s> {
    interval: &'s ExposureInterval<'s>,
    element_index: usize,
    arc: OrbitArc,
}

impl Sky {
    /// Computes the data that the tracks of all delayed satellites in one exposure share.
    ///
    /// # Errors
    /// The exposure has no finite length or direction, or lies outside the years of the Sun's
    /// ephemeris, or if the elements of a telescope in orbit give no position.
    #[doc(hidden)]
    pub fn exposure_interval(&self, exposure: &Exposure) -> Result<ExposureInterval<'_>, Error> {
        exposure.check()?;
        let start = seconds_after(exposure.start, -MARGIN_S);
        let scene = self.scene_without_windows(start, exposure.duration_s + 2.0 * MARGIN_S);
        let flight = self.flight(&scene, exposure)?;
        let mid_s = MARGIN_S + 0.5 * exposure.duration_s;
        let orientation = scene.orientation.at_s(mid_s);
        let motion =
            self.motion(&scene, &orientation, flight.as_ref(), mid_s).ok_or_else(|| error::no_ephemeris(start))?;
        Ok(ExposureInterval { sky: self, scene, orientation, motion, duration_s: exposure.duration_s })
    }
}

impl ExposureInterval<'_> {
    /// Returns the sky.
    pub fn sky(&self) -> &Sky {
        self.sky
    }

    /// Returns the exposure time, seconds.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Returns the propagator of an element set: its ephemeris if that covers the exposure, otherwise SGP4. `None` if
    /// SGP4 cannot be initialised, and for the observing telescope itself.
    pub fn propagator(&self, element_index: usize) -> Option<&Propagator> {
        if self.sky.is_observer(element_index) {
            return None;
        }
        self.sky.propagator_over(self.scene.start, element_index, [MARGIN_S, MARGIN_S + self.duration_s])
    }

    /// Converts a time in seconds after the shutter opened to an epoch.
    pub fn epoch(&self, time_s: f64) -> hifitime::Epoch {
        seconds_after(self.scene.start, MARGIN_S + time_s)
    }

    /// Returns the geocentric position of the observer at a time.
    pub fn observer(&self, time_s: f64) -> Position<Gcrs> {
        self.motion.position(MARGIN_S + time_s)
    }

    /// Returns the geocentric state of a satellite that is late by `late_s` seconds, computed by the propagator without
    /// interpolation on an arc.
    ///
    /// # Errors
    /// The propagation fails.
    pub fn state(&self, propagator: &Propagator, time_s: f64, late_s: f64) -> Result<State<Gcrs>, Error> {
        let minutes = propagator.minutes_since_epoch(self.scene.start) + (MARGIN_S + time_s - late_s) / 60.0;
        propagator.state_at_minutes(minutes, &self.orientation.teme_to_gcrs)
    }

    /// Returns the direction and the distance of a satellite that is late by `late_s` seconds, computed from
    /// [`Self::state`].
    ///
    /// # Errors
    /// The propagation fails.
    pub fn sighting(&self, propagator: &Propagator, time_s: f64, late_s: f64) -> Result<Sighting, Error> {
        let state = self.state(propagator, time_s, late_s)?;
        let earth_velocity = self.scene.sun.at_s(MARGIN_S + time_s).earth_velocity;
        let seen = aspect(&state.position, &state.velocity, &self.observer(time_s), &earth_velocity);
        let line = seen.direction.vector();
        let velocity = state.velocity.vector();
        let own_rate = (velocity - line * line.dot(velocity)) / seen.range_km;
        Ok(Sighting { direction: seen.direction, own_rate, range_km: seen.range_km })
    }

    /// Returns the days from the epoch of an element set to a time.
    pub fn element_age_days(&self, propagator: &Propagator, time_s: f64) -> f64 {
        seconds_between(propagator.epoch(), self.epoch(time_s)) / DAY_S
    }

    /// Returns the uncertainty (one sigma) of the predicted position of a satellite at a time.
    pub fn uncertainty(&self, element_index: usize, propagator: &Propagator, time_s: f64) -> OrbitUncertainty {
        self.sky.uncertainty_of(element_index, propagator, self.epoch(time_s))
    }

    /// Computes the track of a satellite that is late by `late_s` seconds, from a minute before to a minute after the
    /// exposure.
    ///
    /// # Errors
    /// The propagation fails, or the element set is that of the observer itself.
    pub fn track(&self, element_index: usize, late_s: f64) -> Result<DelayedTrack<'_>, Error> {
        let propagator = self.propagator(element_index).ok_or_else(|| {
            not_initialised(
                self.sky.elements()[element_index].norad_id,
                "no propagator for this object, or it is the observer",
            )
        })?;
        let minutes = propagator.minutes_since_epoch(self.scene.start) - late_s / 60.0;
        let span_s = self.duration_s + 2.0 * MARGIN_S;
        let arc = OrbitArc::new(propagator, minutes, 0.0, span_s, &self.orientation.teme_to_gcrs)?;
        Ok(DelayedTrack { interval: self, element_index, arc })
    }
}

impl DelayedTrack<'_> {
    /// Time by which tracks extend beyond both ends of the exposure, seconds.
    pub const MARGIN_S: f64 = MARGIN_S;

    fn line(&self) -> SightLine<'_> {
        SightLine { arc: &self.arc, observer: self.interval.motion.clone() }
    }

    /// Returns the earliest and the latest time of the track, seconds after the shutter opened.
    pub fn times_s(&self) -> [f64; 2] {
        [-MARGIN_S, self.interval.duration_s + MARGIN_S]
    }

    /// Returns the direction at a time, and its rate due to the motions of satellite and observer, perpendicular to it,
    /// rad/s.
    pub fn direction(&self, time_s: f64) -> (Direction<Gcrs>, Vector3<f64>) {
        let sight = self.line().sight(MARGIN_S + time_s);
        let along = sight.vector * sight.vector.dot(&sight.rate_s);
        (Direction::from_vector(sight.vector), sight.rate_s - along)
    }

    /// Returns the direction and the distance, km, at a time, of a satellite that is late by `late_s` seconds more than
    /// that of this track. Both `time_s` and `time_s - late_s` must be within [`DelayedTrack::times_s`].
    pub fn delayed(&self, time_s: f64, late_s: f64) -> (Direction<Gcrs>, f64) {
        let (_, _, aspect) = self.line().delayed_aspect(MARGIN_S + time_s, late_s);
        (aspect.direction, aspect.range_km)
    }

    /// Returns the time, within [`DelayedTrack::times_s`], at which the track is nearest to a direction. The search
    /// starts at `guess_s`.
    pub fn nearest_s(&self, direction: &Direction<Gcrs>, guess_s: f64) -> f64 {
        let [first_s, last_s] = self.times_s();
        let mut time_s = guess_s.clamp(first_s, last_s);
        // Newton's method for the time of closest approach: the distance along the track is divided by the rate.
        for _ in 0..8 {
            let (_, rate) = self.direction(time_s);
            let step_s = direction.vector().dot(&rate) / rate.norm_squared().max(1e-18);
            let next_s = (time_s + step_s).clamp(first_s, last_s);
            if (next_s - time_s).abs() < 1e-6 {
                return next_s;
            }
            time_s = next_s;
        }
        time_s
    }

    /// Returns position and brightness at a time; `None` only if observer and satellite coincide.
    pub fn point(&self, time_s: f64, photometry: &PhotometryOptions) -> Option<TrackPoint> {
        let line = self.line();
        self.evaluator(&line, Some(photometry), time_s).point(MARGIN_S + time_s)
    }

    /// Returns true if the satellite is above the horizon at a time; for an observer in orbit, if the Earth does not
    /// hide it.
    pub fn is_up(&self, time_s: f64) -> bool {
        let line = self.line();
        let at_s = MARGIN_S + time_s;
        let moment = Chord { enter_s: at_s, exit_s: at_s };
        !self.evaluator(&line, None, time_s).above_ground(&moment).is_empty()
    }

    fn evaluator<'a>(
        &'a self,
        line: &'a SightLine<'a>,
        photometry: Option<&'a PhotometryOptions>,
        time_s: f64,
    ) -> PassEvaluator<'a> {
        let ExposureInterval { sky, scene, .. } = self.interval;
        let element_index = self.element_index;
        let epoch = self.interval.epoch(time_s);
        let uncertainty = match self.interval.propagator(element_index) {
            Some(propagator) => sky.uncertainty_of(element_index, propagator, epoch),
            None => sky.uncertainty_at(element_index, epoch),
        };
        PassEvaluator { sky, scene, line, element_index, photometry, uncertainty }
    }
}
