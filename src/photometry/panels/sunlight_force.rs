//! Force of sunlight on panels and spheres: momentum of the light that they intercept, less that of the light that they
//! reflect or transmit.
//!
//! A satellite that sends the light B(o), m² sr⁻¹, into the direction o receives the force
//!
//! ```text
//! F = -P (A s + ∫ B(o) o dω)
//! ```
//!
//! where P is the radiation pressure, A the area that intercepts light, projected onto the plane perpendicular to the
//! direction s of the Sun, and the integral is over all directions. Reflected light that another panel hides stays in
//! the satellite with its momentum, so that the same B applies as for magnitudes.

use nalgebra::Vector3;

use super::assembly::{AssembledPanel, Face, PanelAssembly};
use super::shapes::PlacedRectangle;
use crate::constants::{SOLAR_IRRADIANCE_W_M2, SPEED_OF_LIGHT_KM_S};
use crate::frames::{Acceleration, Body};
use crate::photometry::brdf::each_outgoing;

/// Radiation pressure of sunlight at 1 au, N/m²: 4.54e-6.
const PRESSURE_N_M2: f64 = SOLAR_IRRADIANCE_W_M2 / (SPEED_OF_LIGHT_KM_S * 1000.0);

/// Force of sunlight on a satellite, as areas.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SunlightForce {
    /// Area that intercepts sunlight, projected onto the plane perpendicular to the direction of the Sun, m².
    pub cross_section_m2: f64,
    /// Force divided by the radiation pressure of sunlight, in the body frame, m². For a black satellite, this vector
    /// has the length `cross_section_m2` and points away from the Sun.
    pub per_pressure_m2: Vector3<f64>,
}

impl SunlightForce {
    /// Returns the acceleration in the body frame.
    ///
    /// `mass_kg` is the mass of the satellite, `lit_fraction` the fraction of the Sun's light that reaches it, [0, 1],
    /// and `sun_distance_au` its distance from the Sun. `None` if the mass or the distance is not positive or a number
    /// is not finite.
    pub fn acceleration(&self, mass_kg: f64, lit_fraction: f64, sun_distance_au: f64) -> Option<Acceleration<Body>> {
        let is_valid = mass_kg > 0.0 && (0.0..=1.0).contains(&lit_fraction) && sun_distance_au > 0.0;
        // a = P F / m, P ~ 1/r²
        let per_area = PRESSURE_N_M2 * lit_fraction / (sun_distance_au * sun_distance_au * mass_kg);
        (is_valid && per_area.is_finite()).then(|| Acceleration::from_vector(self.per_pressure_m2 * per_area))
    }
}

impl PanelAssembly {
    /// Returns the force of sunlight for a direction of the Sun (unit vector in the body frame with y = 0).
    ///
    /// Light that falls on panels and is not reflected or transmitted by their laws is absorbed, and the absorbed power
    /// exerts no further force. Panels shade one another as for magnitudes; spheres are not shaded. Takes 0.1 to 0.2 s
    /// for two panels of which one blocks the other: the integral of the reflected light has an error below 1e-3 of the
    /// incident momentum for lobes wider than a degree.
    pub fn sunlight_force(&self, to_sun: &Vector3<f64>) -> SunlightForce {
        let mut cross_section_m2 = 0.0;
        let mut momentum_m2 = Vector3::zeros();
        for panel in self.panels() {
            let placed = panel.placed(to_sun);
            let cos_in = placed.axes.normal.dot(to_sun);
            let shaded = self.share_blocked(panel, &placed, to_sun, &[to_sun]);
            cross_section_m2 += cos_in.abs() * placed.area_m2() * (1.0 - shaded);
            let faces: &[Face] = if cos_in > 0.0 { &[Face::Front, Face::Through] } else { &[Face::Back] };
            momentum_m2 +=
                faces.iter().map(|&face| self.outgoing_m2(panel, face, &placed, to_sun)).sum::<Vector3<f64>>();
        }
        for sphere in self.spheres() {
            cross_section_m2 += sphere.area_m2;
            momentum_m2 += to_sun * sphere.reflected_momentum_m2();
        }
        SunlightForce { cross_section_m2, per_pressure_m2: -(to_sun * cross_section_m2 + momentum_m2) }
    }

    /// Returns the momentum of the light that one lit face sends out, divided by the radiation pressure, m².
    fn outgoing_m2(
        &self,
        panel: &AssembledPanel,
        face: Face,
        placed: &PlacedRectangle,
        to_sun: &Vector3<f64>,
    ) -> Vector3<f64> {
        let laws = panel.laws(face);
        if laws.is_empty() {
            return Vector3::zeros();
        }
        // The axes of the quadrature: the normal of the lit side, and the Sun in the plane of x and the normal.
        let normal = if face == Face::Back { -placed.axes.normal } else { placed.axes.normal };
        let cos_in = normal.dot(to_sun);
        let x = (to_sun - normal * cos_in).try_normalize(1e-12).unwrap_or(placed.axes.u);
        let y = normal.cross(&x);
        let side = if face == Face::Through { -1.0 } else { 1.0 };
        let mut momentum = Vector3::zeros();
        each_outgoing(laws, cos_in, side, |direction, part| {
            if part > 0.0 {
                let out = x * direction.x + y * direction.y + normal * direction.z;
                momentum += out * (part * (1.0 - self.share_blocked(panel, placed, to_sun, &[to_sun, &out])));
            }
        });
        momentum * (cos_in * placed.area_m2())
    }
}
