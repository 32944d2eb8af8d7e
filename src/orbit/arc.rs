//! A stretch of one orbit, interpolated between a few SGP4 states to centimetres.

use nalgebra::Vector3;

use super::propagator::{OrbitError, Propagator, State};
use crate::frames::{Gcrs, Position, Rotation, Teme, Velocity};

/// Longest step between two nodes, seconds.
///
/// Cubic Hermite errs by h⁴/384 · |r⁗| with |r⁗| = r ω⁴ (circular orbit): 2 cm at h = 30 s and 300 km height, less elsewhere.
const LONGEST_STEP_S: f64 = 30.0;

/// Position and velocity of two nodes may disagree by this, km: h³/12 · |r‴| is 0.06 km for the fastest orbit there is. SGP4's
/// velocity leaves out how drag changes the mean motion, which shows when elements years old run away.
const LARGEST_GAP_KM: f64 = 1.0;

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
    /// [`OrbitError`] where SGP4 breaks down or the satellite has decayed at one of the nodes, or where positions and velocities
    /// contradict one another.
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
            .collect::<Result<Vec<State<Gcrs>>, OrbitError>>()?;
        for (node, pair) in nodes.windows(2).enumerate() {
            let moved_km = pair[1].position.vector() - pair[0].position.vector();
            let by_velocity_km = (pair[0].velocity.vector() + pair[1].velocity.vector()) * (0.5 * step_s);
            if (moved_km - by_velocity_km).norm() > LARGEST_GAP_KM {
                let minutes = reference_minutes + (start_s + step_s * node as f64) / 60.0;
                return Err(OrbitError::Diverged {
                    norad_id: propagator.norad_id(),
                    days_since_epoch: minutes / 1440.0,
                    reason: format!(
                        "it moves by {:.1} km/s where its velocity is {:.1} km/s: the drag terms have run away",
                        moved_km.norm() / step_s,
                        by_velocity_km.norm() / step_s
                    ),
                });
            }
        }
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
