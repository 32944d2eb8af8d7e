//! Reproducible random numbers (SplitMix64), without a dependency.

use nalgebra::Vector3;

/// Generator with its state; the initial state is the seed.
pub struct Random(pub u64);

impl Random {
    /// Returns a number that is uniform in (0, 1), excluding both ends.
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// Returns a number that is uniform between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Returns a normal number with mean 0 and sigma 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }

    /// Returns a unit vector that is uniform over the sphere.
    pub fn direction(&mut self) -> Vector3<f64> {
        let (longitude, z) = (self.between(0.0, std::f64::consts::TAU), self.between(-1.0, 1.0));
        let r = (1.0 - z * z).sqrt();
        Vector3::new(r * longitude.cos(), r * longitude.sin(), z)
    }
}
