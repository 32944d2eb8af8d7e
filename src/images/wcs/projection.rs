//! The sphere on a plane: projections in their native coordinates.
//!
//! M. Calabretta and E. Greisen, Representations of celestial coordinates in FITS (2002, A&A 395, 1077), "paper II". Plane coordinates (x, y) are
//! radians here, native directions are unit vectors whose third component points to the native pole.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector3;

/// Steps of Newton's method for the radius of ZPN; it converges in a few or not at all.
const MOST_STEPS: usize = 40;

/// A projection.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Projection {
    /// Gnomonic: R = cot θ (paper II, eq. 54).
    Tan,
    /// Orthographic: R = cos θ (eq. 59).
    Sin,
    /// Stereographic: R = 2 tan((90° - θ)/2) (eq. 55).
    Stg,
    /// Zenithal equidistant: R = 90° - θ (eq. 67).
    Arc,
    /// Zenithal equal area: R = 2 sin((90° - θ)/2) (eq. 69).
    Zea,
    /// Zenithal polynomial: R = Σ P_m (90° - θ)^m (eq. 71), from P_0.
    Zpn(Zpn),
    /// Plate carrée: x = φ, y = θ (eq. 83).
    Car,
}

/// The polynomial of ZPN, and how far from the pole it grows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Zpn {
    coefficients: Vec<f64>,
    furthest_rad: f64,
}

impl Zpn {
    /// From P_0, P_1, ...; `None` where the radius does not grow from the pole on.
    pub fn new(coefficients: Vec<f64>) -> Option<Self> {
        let mut zpn = Self { coefficients, furthest_rad: PI };
        // The radius is single-valued up to its first maximum.
        let steps = 2000;
        let grows = |step: &usize| zpn.radius(*step as f64 * PI / steps as f64).1 > 0.0;
        let count = (0..=steps).take_while(grows).count();
        zpn.furthest_rad = count.checked_sub(1)? as f64 * PI / steps as f64;
        (zpn.furthest_rad > 0.0).then_some(zpn)
    }

    /// Radius and its slope at a distance from the pole, radians.
    fn radius(&self, distance_rad: f64) -> (f64, f64) {
        let (mut value, mut slope) = (0.0, 0.0);
        for coefficient in self.coefficients.iter().rev() {
            slope = slope * distance_rad + value;
            value = value * distance_rad + coefficient;
        }
        (value, slope)
    }

    /// Distance from the pole of a radius; `None` where no distance has it.
    fn distance_rad(&self, radius: f64) -> Option<f64> {
        let mut distance_rad = radius.clamp(0.0, self.furthest_rad);
        for _ in 0..MOST_STEPS {
            let (value, slope) = self.radius(distance_rad);
            let step = (radius - value) / slope;
            distance_rad = (distance_rad + step).clamp(0.0, self.furthest_rad);
            if step.abs() < 1e-16 + 4.0 * f64::EPSILON * distance_rad {
                break;
            }
        }
        let miss = (self.radius(distance_rad).0 - radius).abs();
        (miss <= 1e-13 * radius.abs().max(1e-3)).then_some(distance_rad)
    }
}

impl Projection {
    /// Whether the native pole is the centre of the projection: its reference point is (0°, 90°), else (0°, 0°).
    pub fn is_zenithal(&self) -> bool {
        !matches!(self, Self::Car)
    }

    /// The native direction of a place in the plane; `None` outside of what the projection shows.
    pub fn to_native(&self, x: f64, y: f64) -> Option<Vector3<f64>> {
        // Zenithal: x = R sin φ, y = -R cos φ                                  paper II, eqs. 12, 13
        let radius = x.hypot(y);
        let distance_rad = match self {
            // The direction (-y, x, 1) itself, without an angle.
            Self::Tan => return Some(Vector3::new(-y, x, 1.0).normalize()),
            Self::Sin => (radius <= 1.0).then(|| radius.asin())?,
            Self::Stg => 2.0 * (radius / 2.0).atan(),
            Self::Arc => (radius <= PI).then_some(radius)?,
            Self::Zea => (radius <= 2.0).then(|| 2.0 * (radius / 2.0).asin())?,
            Self::Zpn(zpn) => zpn.distance_rad(radius)?,
            Self::Car => {
                let is_inside = x.abs() <= PI && y.abs() <= FRAC_PI_2;
                return is_inside.then(|| Vector3::new(y.cos() * x.cos(), y.cos() * x.sin(), y.sin()));
            }
        };
        let (sine, cosine) = distance_rad.sin_cos();
        if radius == 0.0 {
            return Some(Vector3::new(0.0, 0.0, 1.0));
        }
        Some(Vector3::new(-y / radius * sine, x / radius * sine, cosine))
    }

    /// The place of a native direction in the plane; `None` for what the projection does not show.
    pub fn to_plane(&self, native: &Vector3<f64>) -> Option<[f64; 2]> {
        let across = native.x.hypot(native.y);
        let distance_rad = || across.atan2(native.z);
        let radius = match self {
            Self::Tan => {
                return (native.z > 0.0).then(|| [native.y / native.z, -native.x / native.z]);
            }
            Self::Sin => (native.z >= 0.0).then_some(across)?,
            Self::Stg => (native.z > -1.0).then(|| 2.0 * (distance_rad() / 2.0).tan())?,
            Self::Arc => distance_rad(),
            Self::Zea => 2.0 * (distance_rad() / 2.0).sin(),
            Self::Zpn(zpn) => {
                let distance_rad = distance_rad();
                (distance_rad <= zpn.furthest_rad).then(|| zpn.radius(distance_rad).0)?
            }
            Self::Car => return Some([native.y.atan2(native.x), native.z.atan2(across)]),
        };
        if across == 0.0 {
            return Some([0.0, -radius]);
        }
        Some([radius * native.y / across, -radius * native.x / across])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_there_and_back() {
        let zpn = Zpn::new(vec![0.0, 1.0, 0.0, -50.0]).unwrap();
        // dR/dγ = 1 - 150 γ² ends at γ = 0.0816.
        assert!((zpn.furthest_rad - 150f64.powf(-0.5)).abs() < PI / 2000.0);
        assert_eq!(Zpn::new(vec![0.0, -1.0]), None);
        let projections = [
            Projection::Tan,
            Projection::Sin,
            Projection::Stg,
            Projection::Arc,
            Projection::Zea,
            Projection::Zpn(zpn),
            Projection::Car,
        ];
        for projection in &projections {
            for (x, y) in [(0.0, 0.0), (0.01, 0.0), (-0.02, 0.03), (1e-9, -2e-7)] {
                let native = projection.to_native(x, y).unwrap();
                let back = projection.to_plane(&native).unwrap();
                let miss = (back[0] - x).hypot(back[1] - y);
                assert!(miss < 1e-15 && (native.norm() - 1.0).abs() < 1e-15, "{projection:?} {x} {y}: {back:?}");
            }
        }
    }

    #[test]
    fn verif_what_is_not_shown_has_no_place() {
        let behind = Vector3::new(0.1, 0.0, -1.0).normalize();
        assert_eq!(Projection::Tan.to_plane(&behind), None);
        assert_eq!(Projection::Sin.to_plane(&behind), None);
        assert_eq!(Projection::Sin.to_native(1.1, 0.0), None);
        assert!(Projection::Arc.to_plane(&behind).is_some());
        assert_eq!(Projection::Car.to_native(0.0, 2.0), None);
    }
}
