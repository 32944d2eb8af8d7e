//! The paper's satellite: a chassis and a sail, five terms of reflected sunlight and two of earthshine, each to be had apart.
//!
//! B_total = glossy + diffuse of the sail's front, light leaking through its back, glossy + diffuse of the chassis
//! (Lu 2024, section 2.1). The sail is kept turned to the Sun about the zenith and stands on the chassis, leaning by
//! the panel offset angle; the chassis looks straight down. Earthshine falls on the chassis alone (section 2.4).

use std::f64::consts::{FRAC_1_PI, TAU};

use nalgebra::Vector3;

use crate::geometry::ViewingGeometry;

use super::blocking::{Blocked, ChassisBlocking};
use super::brdf::{Lambert, Phong};
use super::brightness::Earthshine;
use super::earthshine::{EarthTerms, PAPER_ALBEDO, Shine};
use super::model_file::{Coefficients, SatelliteShape};
use super::panel::Panel;

/// Reflected light term by term, and what the chassis hides of the sail. All in m² sr⁻¹, cosines and areas included.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Terms {
    /// Glossy lobe of the sail's front (c1, n_sail), eq. 2.
    pub sail_glossy_m2_sr: f64,
    /// Diffuse light of the sail's front (c2), eq. 3.
    pub sail_diffuse_m2_sr: f64,
    /// Light that leaks through to the sail's back (c3), eq. 4.
    pub sail_back_m2_sr: f64,
    /// Glossy lobe of the chassis (c4, n_base), eq. 5.
    pub base_glossy_m2_sr: f64,
    /// Diffuse light of the chassis (c5), eq. 6.
    pub base_diffuse_m2_sr: f64,
    /// Earthshine in the glossy lobe of the chassis (c4, n_base), section 2.4; 0 where it was not asked for.
    pub earth_glossy_m2_sr: f64,
    /// Earthshine as diffuse light of the chassis (c5); 0 where it was not asked for.
    pub earth_diffuse_m2_sr: f64,
    /// Shares of the sail that the chassis hides or shades.
    pub blocked: Blocked,
}

impl Terms {
    /// Their sum, m² sr⁻¹; eq. 1 and earthshine.
    pub fn b_total_m2_sr(&self) -> f64 {
        self.sunlight_m2_sr() + self.earthshine_m2_sr()
    }

    /// The two terms of earthshine.
    pub fn earthshine_m2_sr(&self) -> f64 {
        self.earth_glossy_m2_sr + self.earth_diffuse_m2_sr
    }

    /// The five terms of light straight from the Sun; eq. 1.
    pub fn sunlight_m2_sr(&self) -> f64 {
        self.sail_glossy_m2_sr
            + self.sail_diffuse_m2_sr
            + self.sail_back_m2_sr
            + self.base_glossy_m2_sr
            + self.base_diffuse_m2_sr
    }
}

/// One geometry as the laws see it: cosines times areas, and the cosines of the two mirror angles.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Faces {
    /// cos φ_i cos φ_r A of the sail's front, nothing blocked, m².
    pub sail_front_m2: f64,
    /// cos φ_i cos(π - φ_r) A of a sail lit from the front and seen from behind, nothing blocked, m².
    pub sail_through_m2: f64,
    /// cos φ_i cos φ_r A of the chassis, m².
    pub base_front_m2: f64,
    /// cos θ_sail: observer and mirror direction of the Sun on the sail.
    pub cos_sail_mirror: f64,
    /// cos θ_base.
    pub cos_base_mirror: f64,
    /// Shares of the sail that are lost.
    pub blocked: Blocked,
}

/// Stands for the exponent where there is no lobe: the fewest nodes serve.
const BROAD_EXPONENT: f64 = 4.0;

/// The numbers of a two-panel satellite, for loops over many directions.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct TwoPanelNumbers {
    pub c1: f64,
    pub c2: f64,
    pub c3: f64,
    pub c4: f64,
    pub c5: f64,
    pub n_sail: f64,
    pub n_base: f64,
    pub sin_panel_offset: f64,
    pub cos_panel_offset: f64,
    pub sail_m2: f64,
    pub base_m2: f64,
    pub sail_length_m: f64,
    pub base_length_m: f64,
    /// The smaller width.
    pub narrow_m: f64,
    /// Half the sum of both widths.
    pub half_sum_m: f64,
    /// Half the sum of the smaller width and the chassis'.
    pub half_both_m: f64,
}

/// Panels and laws made ready: no allocation and no choice is left when it is asked.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SatelliteModel {
    sail: Panel,
    base: Panel,
    blocking: ChassisBlocking,
    sail_glossy: Phong,
    sail_diffuse: Lambert,
    sail_back: Lambert,
    base_glossy: Phong,
    base_diffuse: Lambert,
}

impl SatelliteModel {
    /// From a shape and coefficients; `None` where a length is not positive or the offset is not within ±90°.
    pub fn new(shape: &SatelliteShape, coefficients: &Coefficients) -> Option<Self> {
        let blocking = ChassisBlocking::new(
            shape.sail_length_m,
            shape.sail_width_m,
            shape.base_length_m,
            shape.base_width_m,
            shape.panel_offset_deg.to_radians(),
        )?;
        Some(Self {
            // n_sail = (cos POA, 0, sin POA), towards the Sun; n_base = -z    Lu (2024), section 2.1
            sail: Panel { area_m2: blocking.sail_area_m2(), normal: blocking.sail_normal() },
            base: Panel { area_m2: blocking.base_area_m2(), normal: -Vector3::z() },
            blocking,
            sail_glossy: Phong { weight: coefficients.c1, exponent: coefficients.n_sail },
            sail_diffuse: Lambert { albedo: coefficients.c2 },
            sail_back: Lambert { albedo: coefficients.c3 },
            base_glossy: Phong { weight: coefficients.c4, exponent: coefficients.n_base },
            base_diffuse: Lambert { albedo: coefficients.c5 },
        })
    }

    /// All seven terms for full sunlight, or five where earthshine is off.
    pub fn terms_with(&self, geometry: &ViewingGeometry, earthshine: Earthshine) -> Terms {
        let mut terms = self.terms(geometry);
        if earthshine == Earthshine::Computed {
            let earth = self.earth_terms(geometry);
            terms.earth_glossy_m2_sr = earth.glossy_m2_sr;
            terms.earth_diffuse_m2_sr = earth.diffuse_m2_sr;
        }
        terms
    }

    /// Earthshine on the chassis under the paper's Earth (Lambertian, albedo 0.3), computed: 1 to 5 µs at n_base = 22,
    /// and nothing where no ground in view is lit.
    pub fn earth_terms(&self, geometry: &ViewingGeometry) -> EarthTerms {
        let to_observer = geometry.to_observer();
        if to_observer.vector().dot(&self.base.normal) <= 0.0 {
            return EarthTerms::default();
        }
        // Where there is no lobe none need be resolved.
        let exponent = if self.base_glossy.weight > 0.0 { self.base_glossy.exponent } else { BROAD_EXPONENT };
        let shine = Shine::on_panel(
            geometry.sun_latitude_rad,
            geometry.height_km,
            PAPER_ALBEDO,
            &self.base.normal,
            to_observer.vector(),
            exponent,
        );
        self.earth_terms_of(&shine, to_observer.vector())
    }

    /// Earthshine on the chassis from what falls on it: by a table, or under another Earth.
    pub fn earth_terms_of(&self, shine: &Shine, to_observer: &Vector3<f64>) -> EarthTerms {
        let cos_out = self.base.normal.dot(to_observer);
        shine.reflected(self.base.area_m2, cos_out, &self.base_diffuse, &self.base_glossy)
    }

    /// Exponent of the chassis' glossy lobe: what a table of earthshine is made for.
    pub fn base_exponent(&self) -> f64 {
        self.base_glossy.exponent
    }

    /// All numbers at once.
    pub(super) fn numbers(&self) -> TwoPanelNumbers {
        let widths = [self.blocking.sail_width_m(), self.blocking.base_width_m()];
        let narrow_m = widths[0].min(widths[1]);
        let normal = self.blocking.sail_normal();
        TwoPanelNumbers {
            c1: self.sail_glossy.weight,
            c2: self.sail_diffuse.albedo,
            c3: self.sail_back.albedo,
            c4: self.base_glossy.weight,
            c5: self.base_diffuse.albedo,
            n_sail: self.sail_glossy.exponent,
            n_base: self.base_glossy.exponent,
            sin_panel_offset: normal.z,
            cos_panel_offset: normal.x,
            sail_m2: self.sail.area_m2,
            base_m2: self.base.area_m2,
            sail_length_m: self.sail.area_m2 / widths[0],
            base_length_m: self.base.area_m2 / widths[1],
            narrow_m,
            half_sum_m: 0.5 * (widths[0] + widths[1]),
            half_both_m: 0.5 * (narrow_m + widths[1]),
        }
    }

    /// The five terms of full sunlight.
    pub fn terms(&self, geometry: &ViewingGeometry) -> Terms {
        let to_sun = geometry.to_sun();
        let to_observer = geometry.to_observer();
        self.terms_of_directions(to_sun.vector(), to_observer.vector())
    }

    /// The five terms of sunlight from unit vectors to Sun (its y is 0) and observer, in the body frame.
    pub fn terms_of_directions(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> Terms {
        let sail = self.sail.incidence(to_sun, to_observer);
        let base = self.base.incidence(to_sun, to_observer);
        let blocked = self.blocking.blocked(to_sun, to_observer);
        // B_s,sail and B_d,sail lose what is hidden or shaded, B_b,sail what is shaded: from behind, the chassis hides
        // nothing of the sail.                                            Lu (2024), eqs. 2-6
        let open = 1.0 - blocked.shadow_or_hidden;
        Terms {
            sail_glossy_m2_sr: self.sail.front_m2_sr(&self.sail_glossy, &sail) * open,
            sail_diffuse_m2_sr: self.sail.front_m2_sr(&self.sail_diffuse, &sail) * open,
            sail_back_m2_sr: self.sail.through_m2_sr(&self.sail_back, &sail) * (1.0 - blocked.shadow),
            base_glossy_m2_sr: self.base.front_m2_sr(&self.base_glossy, &base),
            base_diffuse_m2_sr: self.base.front_m2_sr(&self.base_diffuse, &base),
            earth_glossy_m2_sr: 0.0,
            earth_diffuse_m2_sr: 0.0,
            blocked,
        }
    }

    /// What the light of one geometry is made of before any law is applied.
    pub fn faces(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> Faces {
        let sail = self.sail.incidence(to_sun, to_observer);
        let base = self.base.incidence(to_sun, to_observer);
        Faces {
            sail_front_m2: sail.front() * self.sail.area_m2,
            sail_through_m2: sail.through() * self.sail.area_m2,
            base_front_m2: base.front() * self.base.area_m2,
            cos_sail_mirror: sail.cos_mirror,
            cos_base_mirror: base.cos_mirror,
            blocked: self.blocking.blocked(to_sun, to_observer),
        }
    }

    /// Derivatives of B_total by c1, c2, c3, c4, c5, n_sail, n_base, and B_total itself, m² sr⁻¹.
    pub fn gradient(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> ([f64; 7], f64) {
        let faces = self.faces(to_sun, to_observer);
        let front_m2 = faces.sail_front_m2 * (1.0 - faces.blocked.shadow_or_hidden);
        let through_m2 = faces.sail_through_m2 * (1.0 - faces.blocked.shadow);
        let base_m2 = faces.base_front_m2;
        // The model is linear in c; ∂/∂n of c (n+2)/2π cosⁿθ = c cosⁿθ (1 + (n+2) ln cos θ)/2π.
        let (sail_lobe, sail_slope) = lobe(&self.sail_glossy, faces.cos_sail_mirror);
        let (base_lobe, base_slope) = lobe(&self.base_glossy, faces.cos_base_mirror);
        let gradient = [
            sail_lobe * front_m2,
            FRAC_1_PI * front_m2,
            FRAC_1_PI * through_m2,
            base_lobe * base_m2,
            FRAC_1_PI * base_m2,
            self.sail_glossy.weight * sail_slope * front_m2,
            self.base_glossy.weight * base_slope * base_m2,
        ];
        let weights = [
            self.sail_glossy.weight,
            self.sail_diffuse.albedo,
            self.sail_back.albedo,
            self.base_glossy.weight,
            self.base_diffuse.albedo,
        ];
        (gradient, weights.iter().zip(&gradient).map(|(weight, unit)| weight * unit).sum())
    }
}

/// A lobe of weight 1 and its derivative by the exponent, sr⁻¹.
fn lobe(law: &Phong, cos_mirror: f64) -> (f64, f64) {
    if cos_mirror <= 0.0 {
        return (0.0, 0.0);
    }
    let power = cos_mirror.powf(law.exponent) / TAU;
    ((law.exponent + 2.0) * power, power * (1.0 + (law.exponent + 2.0) * cos_mirror.ln()))
}
