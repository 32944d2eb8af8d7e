//! Chassis and sail (solar array) with coefficients: five terms of reflected sunlight and two of earthshine.
//!
//! B_total is the sum of glossy and diffuse light of the sail's front, light that leaks to its back, and glossy and
//! diffuse light of the chassis (Lu 2024, section 2.1). The sail follows the Sun about the zenith and is mounted on the
//! chassis, inclined by the panel offset angle. The chassis faces straight down. Earthshine falls on the chassis only
//! (section 2.4).

use std::f64::consts::{FRAC_1_PI, TAU};

use nalgebra::Vector3;

use crate::geometry::ViewingGeometry;
use crate::photometry::brightness::Earthshine;
use crate::photometry::earthshine::LitEarth;
use crate::photometry::model_file::{Coefficients, SatelliteShape};

use super::equations::{Blocked, ChassisAndSail, Directions, LitPanels, OpenSail};

/// Reflected light by term, m² sr⁻¹, with cosines and areas included, and the blocked fractions of the sail.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Terms {
    /// Glossy lobe of the sail's front (c1, n_sail), eq. 2.
    pub sail_glossy_m2_sr: f64,
    /// Diffuse light of the sail's front (c2), eq. 3.
    pub sail_diffuse_m2_sr: f64,
    /// Light that leaks to the sail's back (c3), eq. 4.
    pub sail_back_m2_sr: f64,
    /// Glossy lobe of the chassis (c4, n_base), eq. 5.
    pub base_glossy_m2_sr: f64,
    /// Diffuse light of the chassis (c5), eq. 6.
    pub base_diffuse_m2_sr: f64,
    /// Earthshine in the glossy lobe of the chassis (c4, n_base), section 2.4; 0 if earthshine is off.
    pub earth_glossy_m2_sr: f64,
    /// Earthshine as diffuse light of the chassis (c5); 0 if earthshine is off.
    pub earth_diffuse_m2_sr: f64,
    /// Fractions of the sail that the chassis hides or shades.
    pub blocked: Blocked,
}

impl Terms {
    /// Returns the sum of all terms, m² sr⁻¹: eq. 1 plus earthshine.
    pub fn b_total_m2_sr(&self) -> f64 {
        self.sunlight_m2_sr() + self.earthshine_m2_sr()
    }

    /// Returns the sum of the two terms of earthshine, m² sr⁻¹.
    pub fn earthshine_m2_sr(&self) -> f64 {
        self.earth_glossy_m2_sr + self.earth_diffuse_m2_sr
    }

    /// Returns the sum of the five terms of direct sunlight, eq. 1, m² sr⁻¹.
    pub fn sunlight_m2_sr(&self) -> f64 {
        self.sail_glossy_m2_sr
            + self.sail_diffuse_m2_sr
            + self.sail_back_m2_sr
            + self.base_glossy_m2_sr
            + self.base_diffuse_m2_sr
    }
}

/// Two-panel satellite with its coefficients. Its evaluation allocates nothing.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SatelliteModel {
    pub(super) panels: ChassisAndSail,
    pub(super) c: [f64; 5],
    n_sail: f64,
    n_base: f64,
}

impl SatelliteModel {
    /// Returns `None` if a length is not positive or the panel offset is not within ±90°.
    pub fn new(shape: &SatelliteShape, coefficients: &Coefficients) -> Option<Self> {
        let Coefficients { c1, c2, c3, c4, c5, n_sail, n_base } = *coefficients;
        Some(Self { panels: ChassisAndSail::new(shape)?, c: [c1, c2, c3, c4, c5], n_sail, n_base })
    }

    /// Returns all seven terms in full sunlight; the two of earthshine are 0 if earthshine is off.
    pub fn terms_with(&self, geometry: &ViewingGeometry, earthshine: Earthshine) -> Terms {
        let mut terms = self.terms(geometry);
        if earthshine == Earthshine::Computed {
            [terms.earth_glossy_m2_sr, terms.earth_diffuse_m2_sr] = self.earthshine_m2_sr(geometry);
        }
        terms
    }

    /// Returns the five terms in full sunlight.
    pub fn terms(&self, geometry: &ViewingGeometry) -> Terms {
        self.terms_of_directions(geometry.to_sun().vector(), geometry.to_observer().vector())
    }

    /// Returns the five terms of sunlight. The arguments are unit vectors to the Sun (with y = 0) and the observer, in
    /// the body frame.
    pub fn terms_of_directions(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> Terms {
        let exponents = self.exponents();
        let (open, lit) = self.lit(to_sun, to_observer, exponents);
        let basis = lit.basis::<false>(exponents);
        let [sail_glossy_m2_sr, sail_diffuse_m2_sr, sail_back_m2_sr, base_glossy_m2_sr, base_diffuse_m2_sr] =
            std::array::from_fn(|k| self.c[k] * basis[k][0]);
        Terms {
            sail_glossy_m2_sr,
            sail_diffuse_m2_sr,
            sail_back_m2_sr,
            base_glossy_m2_sr,
            base_diffuse_m2_sr,
            earth_glossy_m2_sr: 0.0,
            earth_diffuse_m2_sr: 0.0,
            blocked: self.panels.blocked_of(&open),
        }
    }

    /// Returns the glossy and the diffuse earthshine of the chassis, m² sr⁻¹; 0 if no ground in view is lit. Takes 1 to
    /// 5 µs for an exponent n_base of 22.
    pub(crate) fn earthshine_m2_sr(&self, geometry: &ViewingGeometry) -> [f64; 2] {
        /// Exponent used if the lobe has no weight: a broad lobe, which requires the smallest number of nodes.
        const BROAD_EXPONENT: f64 = 4.0;
        let exponent = if self.c[3] > 0.0 { self.n_base } else { BROAD_EXPONENT };
        let [glossy, diffuse] = chassis_earthshine(self.panels.base_m2(), geometry, exponent);
        [self.c[3] * glossy, self.c[4] * diffuse]
    }

    /// Returns the exponents of the lobes whose weight is not 0.
    pub(super) fn exponents(&self) -> [Option<f64>; 2] {
        [(self.c[0] != 0.0).then_some(self.n_sail), (self.c[3] != 0.0).then_some(self.n_base)]
    }

    fn lit(
        &self,
        to_sun: &Vector3<f64>,
        to_observer: &Vector3<f64>,
        exponents: [Option<f64>; 2],
    ) -> (OpenSail<1>, LitPanels<1>) {
        let directions = Directions::new(to_sun, to_observer);
        let open = self.panels.open_sail::<false, 1>(&directions);
        (open, self.panels.lit::<false, 1>(&directions, &open, exponents.map(|exponent| exponent.is_some())))
    }
}

/// Returns the glossy and the diffuse earthshine of a chassis with c4 = c5 = 1, m² sr⁻¹.
pub(crate) fn chassis_earthshine(base_m2: f64, geometry: &ViewingGeometry, exponent: f64) -> [f64; 2] {
    let (to_observer, down) = (geometry.to_observer(), -Vector3::z());
    let seen_m2 = base_m2 * down.dot(to_observer.vector());
    if seen_m2 <= 0.0 {
        return [0.0; 2];
    }
    let Some(earth) = LitEarth::new(geometry.sun_latitude_rad, geometry.height_km) else { return [0.0; 2] };
    let shine = earth.shine(&down, to_observer.vector(), exponent);
    // The laws of section 2.1 are applied to the light from each part of the Earth instead of the Sun's.
    [(exponent + 2.0) / TAU * shine.lobe * seen_m2, FRAC_1_PI * shine.irradiance * seen_m2]
}
