//! Part of one orbit, interpolated between a few SGP4 positions with millimetre accuracy.

use nalgebra::Vector3;

use super::propagator::Propagator;
use super::state::State;
use crate::error::Error;
use crate::frames::{Gcrs, Position, Rotation, Teme, Velocity};
use crate::math::interpolation::{cubic_slopes, cubic_weights};

/// Step between two nodes that is short enough for any orbit, seconds.
///
/// The error of a cubic through four positions is h⁴/24 · |r⁗| with |r⁗| = r ω⁴ (circular orbit): 4 mm at h = 10 s and
/// 300 km height, less elsewhere. SGP4's velocities are not used: on eccentric orbits they differ from the derivative
/// of its positions by J₂ e v, which adds up to metres in half a minute.
const LONGEST_STEP_S: f64 = 10.0;
/// Longest step as an angle about the Earth's centre, radians. The error of the cubic is (ωh)⁴/24 of the distance, 3 cm
/// for a geosynchronous satellite.
const LONGEST_STEP_RAD: f64 = 0.0115;
/// Steps between the four nodes that a cubic requires.
const FEWEST_STEPS: f64 = 3.0;

/// Positions and velocities of one satellite over a time interval, GCRS.
///
/// Times are seconds after a reference time that the caller chooses.
#[derive(Clone, Debug)]
pub struct OrbitArc {
    start_s: f64,
    step_s: f64,
    /// Positions of at least four nodes, evenly spaced, km.
    positions: Vec<Vector3<f64>>,
}

impl OrbitArc {
    /// Propagates to evenly spaced nodes over [`start_s`, `start_s + duration_s`].
    ///
    /// `reference_minutes` is the caller's reference time in minutes after the element epoch. The rotation is taken as
    /// constant: TEME turns by less than 1e-6 arcsec in 30 s.
    ///
    /// # Errors
    /// SGP4 fails or the satellite has decayed at one of the nodes, or where velocities differ
    /// from the derivative of positions.
    pub fn new(
        propagator: &Propagator,
        reference_minutes: f64,
        start_s: f64,
        duration_s: f64,
        teme_to_gcrs: &Rotation<Teme, Gcrs>,
    ) -> Result<Self, Error> {
        let turning_rad_s = propagator.fastest_turn_rad_s();
        Self::over_pass(propagator, reference_minutes, start_s, duration_s, teme_to_gcrs, turning_rad_s)
    }

    /// Same as [`OrbitArc::new`] for an interval in which the satellite turns about the Earth's centre at no more than
    /// `turning_rad_s`, with nodes as far apart as that rate allows.
    ///
    /// # Errors
    /// As [`OrbitArc::new`].
    pub fn over_pass(
        propagator: &Propagator,
        reference_minutes: f64,
        start_s: f64,
        duration_s: f64,
        teme_to_gcrs: &Rotation<Teme, Gcrs>,
        turning_rad_s: f64,
    ) -> Result<Self, Error> {
        let longest_s = (LONGEST_STEP_RAD / turning_rad_s).max(LONGEST_STEP_S);
        let steps = (duration_s / longest_s).ceil().max(FEWEST_STEPS);
        // An exposure of zero length still requires four nodes.
        let step_s = (duration_s / steps).max(1e-3);
        let nodes = (0..=steps as usize)
            .map(|node| {
                propagator.state_at_minutes(reference_minutes + (start_s + step_s * node as f64) / 60.0, teme_to_gcrs)
            })
            .collect::<Result<Vec<State<Gcrs>>, Error>>()?;
        for (node, pair) in nodes.windows(2).enumerate() {
            let minutes = reference_minutes + (start_s + step_s * node as f64) / 60.0;
            propagator.check_step(&pair[0], &pair[1], step_s, minutes)?;
        }
        let positions = nodes.iter().map(|node| *node.position.vector()).collect();
        Ok(Self { start_s, step_s, positions })
    }

    /// Creates the arc of an orbit of any height from a function of the positions, km, over [`start_s`,
    /// `start_s + duration_s`].
    ///
    /// # Errors
    /// The errors of `position`.
    pub(super) fn of_positions(
        start_s: f64,
        duration_s: f64,
        position: impl Fn(f64) -> Result<Vector3<f64>, Error>,
    ) -> Result<Self, Error> {
        let steps = (duration_s / LONGEST_STEP_S).ceil().max(FEWEST_STEPS);
        let step_s = (duration_s / steps).max(1e-3);
        let positions = (0..=steps as usize).map(|node| position(start_s + step_s * node as f64));
        Ok(Self { start_s, step_s, positions: positions.collect::<Result<_, _>>()? })
    }

    /// Returns position and velocity at a time inside the interval (outside it, the nearest cubic is extrapolated).
    pub fn state_at(&self, time_s: f64) -> State<Gcrs> {
        let steps = (time_s - self.start_s) / self.step_s;
        // The four nodes around the time, or the nearest four at the ends.
        let left = ((steps - 1.0).max(0.0) as usize).min(self.positions.len() - 4);
        let u = steps - left as f64;
        let nodes = &self.positions[left..left + 4];
        let sum = |weights: [f64; 4]| -> Vector3<f64> {
            nodes[0] * weights[0] + nodes[1] * weights[1] + nodes[2] * weights[2] + nodes[3] * weights[3]
        };
        State {
            position: Position::from_vector(sum(cubic_weights(u))),
            velocity: Velocity::from_vector(sum(cubic_slopes(u)) / self.step_s),
        }
    }
}
