//! Plane test: which orbit planes of a chunk pass through a cone, within the distances at which the cone crosses the
//! shell of the chunk's orbits.

use nalgebra::Vector3;

use super::window::{CHUNK, Chunk};
use crate::math::vectors::NullaryFnOnce;

/// Geometry of a cone relative to the Earth's centre, from which the distances at which it crosses a shell follow.
pub(super) struct ConeInShell {
    observer_km: f64,
    /// Cosines of the largest and of the smallest zenith angle of the cone's directions.
    cos_far: f64,
    cos_near: f64,
}

impl ConeInShell {
    pub fn new(observer: &Vector3<f64>, axis: &Vector3<f64>, radius_rad: f64) -> Self {
        let zenith_rad = observer.cross(axis).norm().atan2(observer.dot(axis));
        Self {
            observer_km: observer.norm(),
            cos_far: (zenith_rad + radius_rad).min(std::f64::consts::PI).cos(),
            cos_near: (zenith_rad - radius_rad).max(0.0).cos(),
        }
    }

    /// Returns the smallest and the largest distance from the observer at which the cone is between two radii; `None`
    /// if it never is.
    ///
    /// Observers up to `moved_km` away are included: for them, a point at the same distance and in the same direction
    /// has a radius that differs by at most `moved_km`. The shell is widened by this length on both sides.
    pub fn distances_km(&self, lowest_km: f64, highest_km: f64, moved_km: f64) -> Option<(f64, f64)> {
        let (lowest_km, highest_km) = (lowest_km - moved_km, highest_km + moved_km);
        // ρ = -O cos z ± √(r² - O² sin² z)
        let root = |cosine: f64, radius_km: f64| {
            let square = radius_km * radius_km - self.observer_km.powi(2) * (1.0 - cosine * cosine);
            (square >= 0.0).then(|| square.sqrt())
        };
        let outside = self.observer_km > highest_km;
        let far = if outside {
            // From above the shell, only descending directions meet it. The steepest of them has both the nearest and
            // the farthest intersection with the upper boundary.
            if self.cos_far >= 0.0 {
                return None;
            }
            -self.observer_km * self.cos_far + root(self.cos_far, highest_km)?
        } else {
            -self.observer_km * self.cos_far + root(self.cos_far, highest_km.max(self.observer_km)).unwrap_or(0.0)
        };
        let near = if outside {
            -self.observer_km * self.cos_far - root(self.cos_far, highest_km)?
        } else if self.observer_km < lowest_km {
            -self.observer_km * self.cos_near + root(self.cos_near, lowest_km).unwrap_or(0.0)
        } else {
            0.0
        };
        Some((near.max(0.0), far))
    }
}

/// Returns true if no orbit plane of a chunk passes through a cone, which the mean of their normals shows for most
/// chunks. The arguments are those of [`Planes`].
pub(super) fn all_outside(
    chunk: &Chunk,
    fraction: f64,
    observer: &Vector3<f64>,
    axis: &Vector3<f64>,
    ends: [f64; 2],
    limits: [f64; 2],
) -> bool {
    let [start, change] = &chunk.mean_normal;
    let mean = start + change * fraction;
    let [near, far] = ends.map(|distance_km| observer + axis * distance_km);
    // |(n - n̄)·P| ≤ |n - n̄| |P| for each point P = O + ρ d of the axis.
    let [near_limit, far_limit] =
        [(near, limits[0]), (far, limits[1])].map(|(point, limit)| limit + chunk.spread * point.norm());
    let (at_near, at_far) = (mean.dot(&near), mean.dot(&far));
    (at_near > near_limit && at_far > far_limit) || (at_near < -near_limit && at_far < -far_limit)
}

/// Test of all orbit planes of a chunk against a cone between two distances ρ from the observer.
pub(super) struct Planes<'a> {
    pub chunk: &'a Chunk,
    /// Time as a fraction of the window, from 0 to 1.
    pub fraction: f32,
    pub observer: &'a Vector3<f32>,
    pub axis: &'a Vector3<f32>,
    /// Smallest and largest ρ, km.
    pub ends: [f32; 2],
    /// Largest distance of a plane from the cone's axis at each of these ρ, km, for which the plane passes the test.
    pub limits: [f32; 2],
}

impl NullaryFnOnce for Planes<'_> {
    type Output = [f32; CHUNK];

    /// Returns the distance of each orbit plane from the cone, km; it is 0 or negative if the plane passes through the
    /// cone.
    #[inline(always)]
    fn call(self) -> Self::Output {
        let Self { chunk, fraction, observer: o, axis: d, ends: [near, far], limits: [near_limit, far_limit] } = self;
        // A plane passes if |n·O + ρ n·d| ≤ ρψ + slop at either end of ρ, with the radius ψ of the cone, or if the sign
        // of n·O + ρ n·d changes between the ends.
        let mut outside = [0.0_f32; CHUNK];
        for (lane, outside) in outside.iter_mut().enumerate() {
            let nx = chunk.normal[0][lane] + fraction * chunk.normal_change[0][lane];
            let ny = chunk.normal[1][lane] + fraction * chunk.normal_change[1][lane];
            let nz = chunk.normal[2][lane] + fraction * chunk.normal_change[2][lane];
            let along_observer = nx * o.x + ny * o.y + nz * o.z;
            let along_axis = nx * d.x + ny * d.y + nz * d.z;
            let at_near = along_observer + near * along_axis;
            let at_far = along_observer + far * along_axis;
            let above = lesser(at_near - near_limit, at_far - far_limit);
            let below = lesser(-at_near - near_limit, -at_far - far_limit);
            *outside = if above > below { above } else { below };
        }
        outside
    }
}

/// Returns the smaller of two numbers by one machine instruction; `f32::min` needs three because it handles NaN.
#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
