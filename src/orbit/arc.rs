//! A stretch of one orbit, interpolated between a few SGP4 states to centimetres.

use nalgebra::Vector3;

use super::propagator::{OrbitError, Propagator, State};
use crate::frames::{Gcrs, Position, Rotation, Teme, Velocity};

/// Longest step between two nodes, seconds.
///
/// Cubic Hermite errs by h⁴/384 · |r⁗| with |r⁗| = r ω⁴ (circular orbit): 2 cm at h = 30 s and 300 km height, less elsewhere.
const LONGEST_STEP_S: f64 = 30.0;

/// Positions and velocities of one satellite over a stretch of time, GCRS.
///
/// Times are seconds after the caller's own reference.
#[derive(Clone, Debug)]
pub struct Arc {
    start_s: f64,
    step_s: f64,
    nodes: Vec<State<Gcrs>>,
}

impl Arc {
    /// Propagates to evenly spaced nodes over [`start_s`, `start_s + duration_s`].
    ///
    /// `reference_minutes` is the caller's reference time in minutes after the element epoch. The rotation is taken as
    /// constant: TEME turns by less than 1e-6 arcsec in 30 s.
    ///
    /// # Errors
    /// [`OrbitError`] where SGP4 breaks down or the satellite has decayed at one of the nodes.
    pub fn new(
        propagator: &Propagator,
        reference_minutes: f64,
        start_s: f64,
        duration_s: f64,
        teme_to_gcrs: &Rotation<Teme, Gcrs>,
    ) -> Result<Self, OrbitError> {
        let steps = (duration_s / LONGEST_STEP_S).ceil().max(1.0);
        // An exposure of no length still needs two nodes.
        let step_s = (duration_s / steps).max(1e-3);
        let nodes = (0..=steps as usize)
            .map(|node| {
                propagator.state_at_minutes(reference_minutes + (start_s + step_s * node as f64) / 60.0, teme_to_gcrs)
            })
            .collect::<Result<Vec<_>, OrbitError>>()?;
        Ok(Self { start_s, step_s, nodes })
    }

    /// Position and velocity at a time inside the stretch (outside, the nearest cubic is continued).
    pub fn state_at(&self, time_s: f64) -> State<Gcrs> {
        let steps = (time_s - self.start_s) / self.step_s;
        let last = self.nodes.len() - 2;
        let left = (steps.max(0.0) as usize).min(last);
        let (a, b) = (&self.nodes[left], &self.nodes[left + 1]);
        let x = steps - left as f64;
        let (h, x2, x3) = (self.step_s, x * x, x * x * x);
        // r(x) = (2x³-3x²+1) r₀ + (x³-2x²+x) h v₀ + (3x²-2x³) r₁ + (x³-x²) h v₁
        let (r0, r1) = (a.position.vector(), b.position.vector());
        let (v0, v1): (&Vector3<f64>, &Vector3<f64>) = (a.velocity.vector(), b.velocity.vector());
        let position = r0 * (2.0 * x3 - 3.0 * x2 + 1.0)
            + v0 * ((x3 - 2.0 * x2 + x) * h)
            + r1 * (3.0 * x2 - 2.0 * x3)
            + v1 * ((x3 - x2) * h);
        let velocity = (r1 - r0) * (6.0 * (x - x2) / h) + v0 * (3.0 * x2 - 4.0 * x + 1.0) + v1 * (3.0 * x2 - 2.0 * x);
        State { position: Position::from_vector(position), velocity: Velocity::from_vector(velocity) }
    }
}
