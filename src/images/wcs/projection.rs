//! Projections of the sphere onto a plane, and rotations on the sphere.
//!
//! M. Calabretta and E. Greisen, Representations of celestial coordinates in FITS (2002, A&A 395, 1077), is cited as
//! "paper II". Plane coordinates (x, y) are in radians. Native directions are unit vectors whose third component is
//! along the native pole.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3, Vector3};

/// Largest number of steps of Newton's method for the radius of ZPN. It converges in a few steps or not at all.
const MOST_STEPS: usize = 40;

/// Projection of the sphere onto a plane.
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
    /// Zenithal polynomial: R = Σ P_m (90° - θ)^m (eq. 71), beginning with P_0.
    Zpn(Zpn),
    /// Plate carrée: x = φ, y = θ (eq. 83).
    Car,
}

/// Polynomial of the ZPN projection, and the distance from the pole up to which it increases.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Zpn {
    coefficients: Vec<f64>,
    furthest_rad: f64,
}

impl Zpn {
    /// Creates the polynomial from P_0, P_1, ...; `None` if the radius does not increase at the pole.
    pub fn new(coefficients: Vec<f64>) -> Option<Self> {
        let mut zpn = Self { coefficients, furthest_rad: PI };
        // The radius can be inverted up to its first maximum.
        let steps = 2000;
        let grows = |step: &usize| zpn.radius(*step as f64 * PI / steps as f64).1 > 0.0;
        let count = (0..=steps).take_while(grows).count();
        zpn.furthest_rad = count.checked_sub(1)? as f64 * PI / steps as f64;
        (zpn.furthest_rad > 0.0).then_some(zpn)
    }

    /// Returns the radius and its slope at a distance from the pole (radians).
    fn radius(&self, distance_rad: f64) -> (f64, f64) {
        let (mut value, mut slope) = (0.0, 0.0);
        for coefficient in self.coefficients.iter().rev() {
            slope = slope * distance_rad + value;
            value = value * distance_rad + coefficient;
        }
        (value, slope)
    }

    /// Returns the distance from the pole (radians) at which the radius has a value; `None` if there is none.
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
    /// Returns true if the reference point of the projection is the native pole (0°, 90°), false if it is the native
    /// origin (0°, 0°).
    pub fn is_zenithal(&self) -> bool {
        !matches!(self, Self::Car)
    }

    /// Returns the native direction of a position in the plane; `None` outside the range of the projection.
    pub fn to_native(&self, x: f64, y: f64) -> Option<Vector3<f64>> {
        // Zenithal: x = R sin φ, y = -R cos φ                                  paper II, eqs. 12, 13
        let radius = x.hypot(y);
        let distance_rad = match self {
            // The direction is proportional to (-y, x, 1), so no angle is needed.
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

    /// Returns the position of a native direction in the plane; `None` outside the range of the projection.
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

/// Absolute value below which a sine or cosine is taken as zero, as for a reference point at a pole.
const TINY: f64 = 1e-10;

/// Orientation of the native sphere on the sky, in degrees as in a header.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct NativePole {
    /// CRVAL of the right ascension axis.
    pub right_ascension_deg: f64,
    /// CRVAL of the declination axis.
    pub declination_deg: f64,
    /// LONPOLE; `None` if it is not given.
    pub lonpole_deg: Option<f64>,
    /// LATPOLE; `None` if it is not given.
    pub latpole_deg: Option<f64>,
    /// True if the reference point is the native pole (zenithal projections), false if it is the native origin.
    pub is_zenithal: bool,
}

impl NativePole {
    /// Returns the rotation from native directions to the sky; `None` if the values of the header describe no rotation.
    ///
    /// Paper II (Calabretta and Greisen 2002), eqs. 2 and 8 to 10.
    pub fn to_sky(self) -> Option<Matrix3<f64>> {
        let declination_0 = self.declination_deg.to_radians();
        let native_latitude_deg = if self.is_zenithal { 90.0 } else { 0.0 };
        // Default of LONPOLE: 0 if δ₀ ≥ θ₀, else 180°.
        let default = if self.declination_deg >= native_latitude_deg { 0.0 } else { 180.0 };
        let phi_pole = self.lonpole_deg.unwrap_or(default).to_radians();
        let right_ascension_0 = self.right_ascension_deg.to_radians();
        let (pole_longitude, pole_latitude) = if self.is_zenithal {
            (right_ascension_0, declination_0)
        } else {
            let pole_latitude = self.pole_latitude(declination_0, phi_pole)?;
            (right_ascension_0 - self.longitude_from_pole(declination_0, phi_pole, pole_latitude), pole_latitude)
        };
        let (sin_phi, cos_phi) = phi_pole.sin_cos();
        let (sin_lat, cos_lat) = pole_latitude.sin_cos();
        let (sin_lon, cos_lon) = pole_longitude.sin_cos();
        // Paper II, eq. 2: sin δ = sin θ sin δp + cos θ cos δp cos(φ - φp), and the equations of the other two
        // components.
        let turned = Matrix3::new(
            -sin_lat * cos_phi,
            -sin_lat * sin_phi,
            cos_lat,
            sin_phi,
            -cos_phi,
            0.0,
            cos_lat * cos_phi,
            cos_lat * sin_phi,
            sin_lat,
        );
        let about_pole = Matrix3::new(cos_lon, -sin_lon, 0.0, sin_lon, cos_lon, 0.0, 0.0, 0.0, 1.0);
        Some(about_pole * turned)
    }

    /// Returns the declination of the native pole if the reference point is the native origin (θ₀ = 0, φ₀ = 0).
    ///
    /// δp = atan2(0, cos φp) ± arccos(sin δ₀ / |cos φp|), whichever is nearer to LATPOLE        paper II, eq. 8
    fn pole_latitude(self, declination_0: f64, phi_pole: f64) -> Option<f64> {
        let (sin_phi, cos_phi) = phi_pole.sin_cos();
        let across = (1.0 - sin_phi * sin_phi).sqrt();
        let target = self.latpole_deg.unwrap_or(90.0).to_radians();
        if across < TINY {
            // Any native pole on a circle is possible, and LATPOLE selects one.
            return (declination_0.abs() < TINY).then_some(target);
        }
        let ratio = declination_0.sin() / across;
        if ratio.abs() > 1.0 + TINY {
            return None;
        }
        let from = 0f64.atan2(cos_phi);
        let angle = ratio.clamp(-1.0, 1.0).acos();
        let is_latitude = |latitude: &f64| latitude.abs() <= FRAC_PI_2 + TINY;
        let wrapped = |latitude: f64| {
            let turn = std::f64::consts::TAU;
            latitude - turn * (latitude / turn).round()
        };
        let candidates = [wrapped(from + angle), wrapped(from - angle)];
        candidates.into_iter().filter(is_latitude).min_by(|a, b| (a - target).abs().total_cmp(&(b - target).abs()))
    }

    /// Returns the right ascension of the reference point minus that of the native pole (θ₀ = 0, φ₀ = 0; paper II, eqs.
    /// 9, 10).
    fn longitude_from_pole(self, declination_0: f64, phi_pole: f64, pole_latitude: f64) -> f64 {
        if (pole_latitude - FRAC_PI_2).abs() < TINY {
            return std::f64::consts::PI - phi_pole;
        }
        if (pole_latitude + FRAC_PI_2).abs() < TINY {
            return phi_pole;
        }
        if declination_0.cos().abs() < TINY {
            return 0.0;
        }
        let sine = phi_pole.sin() / declination_0.cos();
        let cosine = -pole_latitude.sin() * declination_0.sin() / (pole_latitude.cos() * declination_0.cos());
        sine.atan2(cosine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_projections_are_inverted() {
        let zpn = Zpn::new(vec![0.0, 1.0, 0.0, -50.0]).unwrap();
        // At a distance γ from the pole, dR/dγ = 1 - 150 γ², which is 0 at γ = 0.0816.
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
    fn verif_directions_outside_the_range_have_no_position() {
        let behind = Vector3::new(0.1, 0.0, -1.0).normalize();
        assert_eq!(Projection::Tan.to_plane(&behind), None);
        assert_eq!(Projection::Sin.to_plane(&behind), None);
        assert_eq!(Projection::Sin.to_native(1.1, 0.0), None);
        assert!(Projection::Arc.to_plane(&behind).is_some());
        assert_eq!(Projection::Car.to_native(0.0, 2.0), None);
    }
}
