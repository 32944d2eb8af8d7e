//! The plane test's geometry: between which distances a cone of sight runs through a shell.

use nalgebra::Vector3;

/// The line of sight as seen from the Earth's centre: between which distances it runs through a shell.
pub(super) struct Sight {
    observer_km: f64,
    /// Cosines of the largest and least angle between zenith and the cone's directions.
    cos_far: f64,
    cos_near: f64,
}

impl Sight {
    pub fn new(observer: &Vector3<f64>, axis: &Vector3<f64>, radius_rad: f64) -> Self {
        let zenith_rad = observer.cross(axis).norm().atan2(observer.dot(axis));
        Self {
            observer_km: observer.norm(),
            cos_far: (zenith_rad + radius_rad).min(std::f64::consts::PI).cos(),
            cos_near: (zenith_rad - radius_rad).max(0.0).cos(),
        }
    }

    /// Least and greatest distance at which the cone meets radii between the two; `None` where it never does.
    ///
    /// An observer `moved_km` away sees a point at the same distance and in the same direction at a radius that differs by no more than that: the shell
    /// is widened by it, which holds for observers inside the shell and above it too.
    pub fn distances_km(&self, lowest_km: f64, highest_km: f64, moved_km: f64) -> Option<(f64, f64)> {
        let (lowest_km, highest_km) = (lowest_km - moved_km, highest_km + moved_km);
        // ρ = -O cos z ± √(r² - O² sin² z)
        let root = |cosine: f64, radius_km: f64| {
            let square = radius_km * radius_km - self.observer_km.powi(2) * (1.0 - cosine * cosine);
            (square >= 0.0).then(|| square.sqrt())
        };
        let outside = self.observer_km > highest_km;
        let far = if outside {
            // From above, only directions that dip to the shell see it; the steepest of them see deepest.
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
