//! Evaluation of one satellite along its line of sight: position, brightness and motion.

use nalgebra::Vector3;

use super::crossing::{Crossing, root};
use super::intervals::intervals_where;
use super::scene::Scene;
use super::sky::Sky;
use super::track::{Chord, SightLine, TrackPoint};
use super::viewpoint::Viewpoint;
use crate::frames::{Gcrs, Position, seconds_after};
use crate::geometry::{Illumination, ObserverState, ShadowModel, ViewingGeometry, ellipsoidal_height_km};
use crate::math::minimum::minimum;
use crate::orbit::{OrbitUncertainty, State};
use crate::photometry::{Brightness, PhotometryOptions};

/// Number of steps along a pass in the first search for shadow and peak.
const LIGHT_STEPS: usize = 24;
/// Tolerance of the time of the peak, as a fraction of the step between two points.
const PEAK_TOLERANCE: f64 = 1e-4;

/// Geometric altitude below which the ground hides a satellite, radians. It allows for 0.57° of refraction and the dip
/// of the horizon on a mountain. Used only for fields that extend below the horizon.
pub(super) const LOWEST_ALTITUDE_RAD: f64 = -0.035;
/// Step of the search for rise and set within a chord, seconds. No satellite sets and rises again in this time.
const HORIZON_STEP_S: f64 = 30.0;
/// Step of the search for the Earth's limb as seen from an orbit, seconds.
const LIMB_STEP_S: f64 = 5.0;

/// Longest delay, seconds, for which an error along the track is replaced by a displacement along the tangent of the
/// orbit. The orbit deviates from the tangent by ½ g t², here 0.4 km. Longer delays are extrapolated linearly from this
/// one.
const LONGEST_GEOMETRY_STEP_S: f64 = 10.0;
/// Largest uncertainty of a magnitude due to the error of the position, mag. It applies to satellites that may be in
/// the Earth's shadow, where the magnitude has no limit.
const MOST_GEOMETRY_SIGMA_MAG: f64 = 3.0;

/// Line of sight to one satellite, with the data needed for its brightness. Times are seconds after the start of the
/// scene.
pub(super) struct PassEvaluator<'a> {
    pub sky: &'a Sky,
    pub scene: &'a Scene,
    pub line: &'a SightLine<'a>,
    pub element_index: usize,
    /// Band, magnitude system and extinction; `None` for points without brightness.
    pub photometry: Option<&'a PhotometryOptions>,
    /// Uncertainty of the satellite's position at the age of its elements.
    pub uncertainty: OrbitUncertainty,
}

impl PassEvaluator<'_> {
    /// Returns position and brightness at one time; `None` only if observer and satellite coincide.
    pub fn point(&self, time_s: f64) -> Option<TrackPoint> {
        let here = self.sky.viewpoint().site().map(|observer| observer.state(&self.scene.orientation.at_s(time_s)));
        self.point_over(time_s, 0.0, here.as_ref())
    }

    /// Returns the same as [`PassEvaluator::point`] for a satellite that is late by `late_s`, given the state of the
    /// site at that time (`None` for an observer in orbit).
    pub fn point_over(&self, time_s: f64, late_s: f64, here: Option<&ObserverState>) -> Option<TrackPoint> {
        let (state, observer, aspect) = self.line.delayed_aspect(time_s, late_s);
        let (geometry, illumination, brightness) = self.light_at(time_s, &state.position, &observer)?;
        let brightness = brightness.map(|light| self.widened(time_s, &state, &observer, light));
        let horizontal = match here {
            Some(here) => Some(here.altitude_azimuth_rad(&aspect.geometric)?),
            None => None,
        };
        let orientation = self.scene.orientation.at_s(time_s);
        Some(TrackPoint {
            epoch: seconds_after(self.scene.start, time_s),
            direction: aspect.direction,
            altitude_rad: horizontal.map(|(altitude_rad, _)| altitude_rad),
            azimuth_rad: horizontal.map(|(_, azimuth_rad)| azimuth_rad),
            range_km: aspect.range_km,
            height_km: ellipsoidal_height_km(&(orientation.itrs_to_gcrs.inverse() * state.position)),
            geometry,
            illumination,
            brightness,
        })
    }

    /// Returns the brightness, with a sigma that does not include the error of the position.
    pub fn brightness(&self, time_s: f64) -> Option<Brightness> {
        let (state, observer, _) = self.line.aspect_at(time_s);
        self.light_at(time_s, &state.position, &observer)?.2
    }

    /// Returns viewing geometry, illumination and brightness of a satellite at a position.
    fn light_at(
        &self,
        time_s: f64,
        satellite: &Position<Gcrs>,
        observer: &Position<Gcrs>,
    ) -> Option<(ViewingGeometry, Illumination, Option<Brightness>)> {
        let sun = self.scene.sun.at_s(time_s).sun;
        let geometry = ViewingGeometry::new(satellite, observer, &sun)?;
        let illumination = self.sky.shadow().illumination(satellite, &sun);
        let Some(photometry) = self.photometry else { return Some((geometry, illumination, None)) };
        let epoch = seconds_after(self.scene.start, time_s);
        let lit_fraction = illumination.lit_fraction();
        let brightness = self.sky.brightness_in(self.element_index, epoch, &geometry, lit_fraction, photometry);
        Some((geometry, illumination, brightness))
    }

    /// Returns the brightness with an uncertainty that includes the error of the predicted position, which affects the
    /// range, the viewing geometry, and whether the satellite is in the Earth's shadow.
    fn widened(&self, time_s: f64, state: &State<Gcrs>, observer: &Position<Gcrs>, light: Brightness) -> Brightness {
        let (position, velocity) = (state.position.vector(), state.velocity.vector());
        let Some(across) = position.cross(velocity).try_normalize(0.0) else { return light };
        // Magnitude at a displaced position; in the shadow, the faintest magnitude that is considered.
        let faintest = light.magnitude.0 + MOST_GEOMETRY_SIGMA_MAG;
        let magnitude = |moved_km: Vector3<f64>| {
            let lit = self.light_at(time_s, &Position::from_vector(position + moved_km), observer);
            lit.and_then(|(_, _, light)| light).map_or(faintest, |light| light.magnitude.0.min(faintest))
        };
        let half_difference = |moved_km: Vector3<f64>| 0.5 * (magnitude(moved_km) - magnitude(-moved_km)).abs();
        let step_s = self.uncertainty.along_track_s.min(LONGEST_GEOMETRY_STEP_S);
        let along = half_difference(velocity * step_s) * (self.uncertainty.along_track_s / step_s.max(1e-9));
        let cross = half_difference(across * self.uncertainty.cross_track_km);
        let geometry = along.hypot(cross).min(MOST_GEOMETRY_SIGMA_MAG);
        Brightness { sigma_mag: light.sigma_mag.hypot(geometry), ..light }
    }

    /// Returns true if the satellite is lit at any of [`LIGHT_STEPS`] + 1 evenly spaced times from entry to exit.
    pub fn is_lit(&self, enter_s: f64, exit_s: f64) -> bool {
        times(enter_s, exit_s, LIGHT_STEPS).any(|time_s| self.illumination(time_s).is_lit())
    }

    /// Returns the parts of a chord in which the satellite is lit.
    pub fn lit_parts(&self, chord: &Chord) -> Vec<Chord> {
        intervals_where(chord.enter_s, chord.exit_s, LIGHT_STEPS, |time_s| self.illumination(time_s).is_lit())
            .into_iter()
            .map(|(enter_s, exit_s)| Chord { enter_s, exit_s })
            .collect()
    }

    /// Returns the parts of a chord in which the satellite is above the ground; for an observer in orbit, the parts in
    /// which the Earth does not hide it.
    pub fn above_ground(&self, chord: &Chord) -> Vec<Chord> {
        let height = |time_s: f64| match self.sky.viewpoint() {
            Viewpoint::Site(observer) => {
                let here = observer.state(&self.scene.orientation.at_s(time_s));
                here.sine_of_altitude(&self.line.aspect_at(time_s).2.geometric) - LOWEST_ALTITUDE_RAD.sin()
            }
            Viewpoint::Orbit(observer) => {
                let (state, position, _) = self.line.aspect_at(time_s);
                observer.limb().clearance_km(&position, &state.position)
            }
        };
        let longest_s = if self.sky.viewpoint().site().is_some() { HORIZON_STEP_S } else { LIMB_STEP_S };
        let steps = ((chord.exit_s - chord.enter_s) / longest_s).ceil().max(1.0) as usize;
        let samples: Vec<(f64, f64)> =
            times(chord.enter_s, chord.exit_s, steps).map(|time_s| (time_s, height(time_s))).collect();
        let mut borders_s = vec![chord.enter_s];
        for pair in samples.windows(2) {
            if (pair[0].1 >= 0.0) != (pair[1].1 >= 0.0) {
                borders_s.push(root(height, pair[0], pair[1]));
            }
        }
        borders_s.push(chord.exit_s);
        borders_s
            .windows(2)
            .filter(|pair| height(0.5 * (pair[0] + pair[1])) >= 0.0)
            .map(|pair| Chord { enter_s: pair[0], exit_s: pair[1] })
            .collect()
    }

    /// Removes the parts of a crossing that are below the ground if `near_the_ground` is true, and returns the time
    /// interval from the first entry to the last exit of the rest. For a near miss, both ends are the time of the
    /// closest approach. `None` if nothing is left.
    pub fn keep_above_ground(&self, crossing: &mut Crossing, near_the_ground: bool) -> Option<(f64, f64)> {
        if near_the_ground {
            let closest = Chord { enter_s: crossing.closest_s, exit_s: crossing.closest_s };
            let near_miss_is_up = crossing.chords.is_empty() && !self.above_ground(&closest).is_empty();
            crossing.chords = crossing.chords.iter().flat_map(|chord| self.above_ground(chord)).collect();
            if crossing.chords.is_empty() && !near_miss_is_up {
                return None;
            }
        }
        let enter_s = crossing.chords.first().map_or(crossing.closest_s, |chord| chord.enter_s);
        let exit_s = crossing.chords.last().map_or(crossing.closest_s, |chord| chord.exit_s);
        Some((enter_s, exit_s))
    }

    /// Returns the illumination of the satellite.
    pub fn illumination(&self, time_s: f64) -> Illumination {
        self.sky.shadow().illumination(&self.line.arc.state_at(time_s).position, &self.scene.sun.at_s(time_s).sun)
    }

    /// Returns true if the whole disk of the Sun would be visible from the satellite if the Earth had no atmosphere.
    pub fn is_outside_geometric_shadow(&self, time_s: f64) -> bool {
        let (state, sun) = (self.line.arc.state_at(time_s), &self.scene.sun.at_s(time_s).sun);
        ShadowModel::Geometric.illumination(&state.position, sun) == Illumination::Sunlit
    }

    /// Returns the brightest point; `None` if the satellite is dark at all points, or without photometry.
    pub fn peak(&self, enter_s: f64, exit_s: f64) -> Option<TrackPoint> {
        self.peak_in_steps(enter_s, exit_s, LIGHT_STEPS)
    }

    /// Returns the brightest point, with a given number of steps in the first search.
    pub fn peak_in_steps(&self, enter_s: f64, exit_s: f64, steps: usize) -> Option<TrackPoint> {
        self.photometry?;
        let magnitudes: Vec<(f64, f64)> = times(enter_s, exit_s, steps)
            .map(|time_s| (time_s, magnitude_of(self.brightness(time_s).as_ref())))
            .collect();
        self.peak_near(&magnitudes)
    }

    /// Returns the brightest point of an interval, given its magnitudes at evenly spaced times (infinite in the dark),
    /// the first and the last of which are its ends.
    pub fn peak_near(&self, magnitudes: &[(f64, f64)]) -> Option<TrackPoint> {
        let (enter_s, exit_s) = (magnitudes.first()?.0, magnitudes.last()?.0);
        let best =
            *magnitudes.iter().min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, magnitude)| magnitude.is_finite())?;
        let step_s = (exit_s - enter_s) / (magnitudes.len() - 1) as f64;
        let ends_s = [(best.0 - step_s).max(enter_s), (best.0 + step_s).min(exit_s)];
        let magnitude = |time_s: f64| magnitude_of(self.brightness(time_s).as_ref());
        let (peak_s, _) = minimum(magnitude, ends_s, best, PEAK_TOLERANCE * step_s);
        self.point(peak_s)
    }

    /// Returns evenly spaced points from entry to exit, both included; a single point is in the middle of the interval.
    pub fn samples(&self, enter_s: f64, exit_s: f64, count: usize) -> Vec<TrackPoint> {
        match count {
            0 => Vec::new(),
            1 => self.point(0.5 * (enter_s + exit_s)).into_iter().collect(),
            _ => times(enter_s, exit_s, count - 1).filter_map(|time_s| self.point(time_s)).collect(),
        }
    }

    /// Returns the position angle of the motion, radians, and the angular speed, rad/s.
    pub fn motion(&self, time_s: f64) -> (f64, f64) {
        // This step is long enough that rounding (1e-16 rad of a motion of about 1e-3 rad) is negligible, and short
        // enough that the path is straight.
        const HALF_S: f64 = 0.05;
        let (_, _, before) = self.line.aspect_at(time_s - HALF_S);
        let (_, _, now) = self.line.aspect_at(time_s);
        let (_, _, after) = self.line.aspect_at(time_s + HALF_S);
        let rate_rad_s = before.direction.separation_rad(&after.direction) / (2.0 * HALF_S);
        (now.direction.position_angle_rad(&after.direction), rate_rad_s)
    }

    /// Returns the length of a chord on the sky, radians.
    pub fn length_rad(&self, chord: &Chord) -> f64 {
        let directions: Vec<_> = times(chord.enter_s, chord.exit_s, LIGHT_STEPS)
            .map(|time_s| self.line.aspect_at(time_s).2.direction)
            .collect();
        directions.windows(2).map(|pair| pair[0].separation_rad(&pair[1])).sum()
    }
}

/// Returns the magnitude of a brightness; infinity in the dark.
pub(super) fn magnitude_of(light: Option<&Brightness>) -> f64 {
    light.map_or(f64::INFINITY, |light| light.magnitude.0)
}

/// Returns `steps + 1` evenly spaced times.
pub(super) fn times(from_s: f64, to_s: f64, steps: usize) -> impl Iterator<Item = f64> {
    (0..=steps).map(move |step| from_s + (to_s - from_s) * step as f64 / steps as f64)
}
