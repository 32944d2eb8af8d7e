//! Brightness models of all kinds, with a common interface.

use std::sync::Arc;

use nalgebra::Vector3;

use super::band::{Band, MagSystem};
use super::brightness::{Brightness, Earthshine, MagnitudeSource, PhotometryOptions};
use super::error::PhotometryError;
use super::error_distribution::ErrorDistribution;
use super::magnitude::{StandardMagnitude, airmass};
use super::model_file::{GeometryRange, ModelFile, ModelKind, PANEL_OFFSET, SatelliteShape};
use super::panels::{PanelAssembly, PanelSensitivity};
use super::parameter_sigma::ParameterSigmas;
use super::phase::{PhaseFunction, StandardObject};
use super::two_panel::{BodyAngles, Columns, SatelliteModel, SatellitePositions, standard_magnitudes};
use crate::frames::{Body, Direction, Gcrs, Position};
use crate::geometry::ViewingGeometry;

/// Uncertainty that is added in quadrature if a magnitude is converted from the model's band to another one with the
/// Sun's colour, mag.
///
/// Assumed. The colours of STARLINK-1113 (V1.0) in r, i, J and Ks differ from the Sun's by 0.2 mag RMS (single images
/// on two nights; Tregloan-Reed et al. 2021, A&A 647, A54, abstract). Geostationary satellites are in general redder
/// than the Sun, by up to 0.55 mag in V - R.
const GREY_REFLECTANCE_SIGMA_MAG: f64 = 0.2;

/// One sigma of a magnitude from an object's standard magnitude, mag. The assumed value covers unknown shapes and
/// aspects, and errors of estimates by eye; authors of such lists state an accuracy of one magnitude.
pub(super) const STANDARD_MAGNITUDE_SIGMA_MAG: f64 = 1.0;

/// Assumed size of an unknown object, m.
const UNKNOWN_SIZE_M: f64 = 3.0;

/// Ranges of the geometry of the points to which a model was fitted, each as [least, greatest], radians.
#[derive(Copy, Clone, Debug, PartialEq)]
struct FittedRange {
    /// Latitude of the Sun above the chassis plane.
    sun_latitude_rad: [f64; 2],
    /// Latitude of the observer above the chassis plane.
    observer_latitude_rad: [f64; 2],
    /// Cosines of the largest and the smallest phase angle, with some slack. They avoid an arc cosine for each point of
    /// a track.
    cos_phase: [f64; 2],
}

/// Slack at the ends of a fitted range, radians (and in cosines), for the rounding in the conversion from degrees.
const RANGE_SLACK: f64 = 1e-9;

impl FittedRange {
    fn from_file(range: &GeometryRange) -> Self {
        let radians = |range: Option<[f64; 2]>, all: [f64; 2]| range.unwrap_or(all).map(f64::to_radians);
        let [least, greatest] = radians(range.phase_angle_deg, [0.0, 180.0]);
        Self {
            sun_latitude_rad: radians(range.sun_latitude_deg, [-90.0, 90.0]),
            observer_latitude_rad: radians(range.observer_latitude_deg, [-90.0, 90.0]),
            cos_phase: [greatest.cos() - RANGE_SLACK, least.cos() + RANGE_SLACK],
        }
    }

    fn holds(&self, geometry: &ViewingGeometry, cos_phase: f64) -> bool {
        let within = |value: f64, [from, to]: [f64; 2]| from - RANGE_SLACK <= value && value <= to + RANGE_SLACK;
        let [least, greatest] = self.cos_phase;
        within(geometry.sun_latitude_rad, self.sun_latitude_rad)
            && within(geometry.observer_latitude_rad, self.observer_latitude_rad)
            && (least..=greatest).contains(&cos_phase)
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Law {
    TwoPanel(Box<SatelliteModel>),
    Panels(Box<PanelAssembly>),
    Phase(PhaseFunction),
    Object(StandardObject),
    Mean(StandardMagnitude),
}

/// Step of the parameters of panels for derivatives, in their sigmas: well above rounding (1e-16), and so small that
/// the light changes linearly.
const STEP_SIGMAS: f64 = 1e-3;

/// Step of panel offsets for derivatives, degrees.
const OFFSET_STEP_DEG: f64 = 1e-3;

/// Uncertainty of the fitted parameters of a model.
#[derive(Clone, Debug, PartialEq)]
enum ParameterUncertainty {
    /// The uncertainty is unknown.
    None,
    /// Covariance of a two-panel model. If the panel offset was fitted as well, models with a larger and a smaller
    /// offset give the derivative with respect to it.
    Gradient(ParameterSigmas, Option<Box<[SatelliteModel; 2]>>),
    /// Covariance of the parameters of panels, and the derivatives with respect to them.
    Panels(ParameterSigmas, Box<PanelSensitivity>),
}

/// A brightness model: two panels, a list of panels, a phase function, a standard magnitude or a mean.
///
/// Computing a magnitude allocates nothing, except for earthshine on lists of panels.
#[derive(Clone, Debug, PartialEq)]
pub struct BrightnessModel {
    law: Law,
    uncertainty: ParameterUncertainty,
    source: MagnitudeSource,
    band: Band,
    system: MagSystem,
    sigma_mag: f64,
    sigma_outside_mag: f64,
    /// Learned offset of the satellite, mag; added to apparent magnitudes.
    offset_mag: f64,
    error_distribution: ErrorDistribution,
    fitted_range: Option<FittedRange>,
    size_m: f64,
    file: Option<Arc<ModelFile>>,
}

impl BrightnessModel {
    /// Creates a model from the text of a model file; errors contain `origin` (the name of the file).
    ///
    /// # Errors
    /// The errors of [`ModelFile::from_json`].
    pub fn from_json(text: &str, origin: &str) -> Result<Self, PhotometryError> {
        Self::from_file(ModelFile::from_json(text, origin)?, origin)
    }

    /// Creates a model from the content of a model file, which is validated again.
    ///
    /// # Errors
    /// The errors of [`ModelFile::validate`].
    pub fn from_file(file: ModelFile, origin: &str) -> Result<Self, PhotometryError> {
        file.validate(origin)?;
        let needs = |key| PhotometryError::ModelKey {
            origin: origin.to_owned(),
            kind: file.kind.name(),
            problem: "requires",
            key,
        };
        let (band, system) = file.band_and_system().ok_or_else(|| needs("band"))?;
        let name: Arc<str> = file.name.as_str().into();
        let sigmas = file.covariance.as_deref().map(ParameterSigmas::new);
        let mut uncertainty = ParameterUncertainty::None;
        let (law, source) = match file.kind {
            ModelKind::Panels => {
                let spec = file.panels.as_ref().ok_or_else(|| needs("panels"))?;
                if let (Some(sigmas), Some(covariance)) = (sigmas, &file.covariance) {
                    let variances = covariance.iter().enumerate().filter_map(|(i, row)| row.get(i));
                    let steps: Vec<f64> = variances.map(|variance| STEP_SIGMAS * variance.sqrt()).collect();
                    let sensitivity = PanelSensitivity::new(spec, &steps);
                    uncertainty = ParameterUncertainty::Panels(sigmas, Box::new(sensitivity));
                }
                (Law::Panels(Box::new(spec.assemble(&[]))), MagnitudeSource::Brdf(name))
            }
            ModelKind::TwoPanel => {
                let shape = file.shape.as_ref().ok_or_else(|| needs("shape"))?;
                let coefficients = file.coefficients.as_ref().ok_or_else(|| needs("coefficients"))?;
                let model = SatelliteModel::new(shape, coefficients).ok_or_else(|| needs("shape"))?;
                if let Some(sigmas) = sigmas {
                    let moved = |by: f64| {
                        let panel_offset_deg = shape.panel_offset_deg + by;
                        SatelliteModel::new(&SatelliteShape { panel_offset_deg, ..*shape }, coefficients)
                    };
                    let is_fitted = file.parameters().iter().any(|(name, _)| *name == PANEL_OFFSET);
                    let both = moved(OFFSET_STEP_DEG).zip(moved(-OFFSET_STEP_DEG)).filter(|_| is_fitted);
                    uncertainty = ParameterUncertainty::Gradient(sigmas, both.map(|(up, down)| Box::new([up, down])));
                }
                (Law::TwoPanel(Box::new(model)), MagnitudeSource::Brdf(name))
            }
            ModelKind::PhaseFunction => {
                let phase = file.phase_function.as_ref().ok_or_else(|| needs("phase_function"))?;
                let function = PhaseFunction::new(&phase.coefficients, phase.min_phase_deg, phase.max_phase_deg)
                    .ok_or_else(|| needs("phase_function"))?;
                (Law::Phase(function), MagnitudeSource::Phase(name))
            }
            ModelKind::Mean | ModelKind::Prior => {
                let mean = StandardMagnitude(file.mean_mag.ok_or_else(|| needs("mean_mag"))?);
                let source =
                    if file.kind == ModelKind::Mean { MagnitudeSource::Mean(name) } else { MagnitudeSource::Prior };
                (Law::Mean(mean), source)
            }
        };
        Ok(Self {
            law,
            uncertainty,
            source,
            band,
            system,
            sigma_mag: file.sigma_mag,
            sigma_outside_mag: file.sigma_outside_mag,
            offset_mag: 0.0,
            error_distribution: file.error_distribution.unwrap_or_default(),
            fitted_range: file.geometry_range.as_ref().map(FittedRange::from_file),
            size_m: file.size_m,
            file: Some(Arc::new(file)),
        })
    }

    /// Returns the model of one object with known standard magnitude (visual, taken as V Vega; 1000 km, phase angle
    /// 90°) and a sigma of 1 mag.
    pub fn from_standard_magnitude(half_lit: StandardMagnitude) -> Self {
        let source = MagnitudeSource::StandardMagnitude;
        Self::of_object(half_lit, STANDARD_MAGNITUDE_SIGMA_MAG, source, UNKNOWN_SIZE_M)
    }

    /// Returns the model of an object, or a class of objects, with a sigma and a source of its standard magnitude.
    pub(super) fn of_object(half_lit: StandardMagnitude, sigma_mag: f64, source: MagnitudeSource, size_m: f64) -> Self {
        Self {
            law: Law::Object(StandardObject { half_lit }),
            uncertainty: ParameterUncertainty::None,
            source,
            band: Band::V,
            system: MagSystem::Vega,
            sigma_mag,
            sigma_outside_mag: sigma_mag,
            offset_mag: 0.0,
            error_distribution: ErrorDistribution::default(),
            fitted_range: None,
            size_m,
            file: None,
        }
    }

    /// Returns the model for satellites whose kind is assumed, as its source then states.
    pub fn with_assumed_kind(&self) -> Self {
        Self { source: self.source.of_assumed_kind(), ..self.clone() }
    }

    /// Returns the model with an offset and a sigma that were learned from measurements: apparent magnitudes are
    /// `offset_mag` fainter, and single measurements scatter by `sigma_mag` with this distribution. The source ends
    /// with `(learned)`.
    ///
    /// The learned sigma contains the errors of the parameters. Outside the fitted range it is larger by the same
    /// variance as before. Standard magnitudes are those of the model.
    pub fn with_learned(&self, offset_mag: f64, sigma_mag: f64, error_distribution: ErrorDistribution) -> Self {
        // σ'² = σ_learned² + σ_outside² - σ_inside²
        let more_mag2 = self.sigma_outside_mag.powi(2) - self.sigma_mag.powi(2);
        Self {
            offset_mag,
            sigma_mag,
            sigma_outside_mag: (sigma_mag.powi(2) + more_mag2).max(0.0).sqrt().max(sigma_mag),
            error_distribution,
            uncertainty: ParameterUncertainty::None,
            source: self.source.of_learned(),
            ..self.clone()
        }
    }

    /// Returns the magnitude at 1000 km in full sunlight without earthshine, in the model's own band and system. `None`
    /// if no lit surface is visible.
    pub fn standard_magnitude(&self, geometry: &ViewingGeometry) -> Option<StandardMagnitude> {
        self.standard_magnitude_of(&geometry.to_sun(), &geometry.to_observer(), 0.0)
    }

    /// Returns the magnitude at 1000 km in full sunlight, with earthshine unless that is off.
    pub fn standard_magnitude_with(
        &self,
        geometry: &ViewingGeometry,
        earthshine: Earthshine,
    ) -> Option<StandardMagnitude> {
        let earth_m2_sr = self.earthshine_m2_sr(geometry, earthshine);
        self.standard_magnitude_of(&geometry.to_sun(), &geometry.to_observer(), earth_m2_sr)
    }

    /// Returns the earthshine, m² sr⁻¹; 0 for models without panels.
    fn earthshine_m2_sr(&self, geometry: &ViewingGeometry, earthshine: Earthshine) -> f64 {
        match (&self.law, earthshine) {
            (Law::TwoPanel(model), Earthshine::Computed) => {
                let [glossy, diffuse] = model.earthshine_m2_sr(geometry);
                glossy + diffuse
            }
            (Law::Panels(assembly), Earthshine::Computed) => assembly.earthshine_m2_sr(geometry),
            _ => 0.0,
        }
    }

    /// Writes magnitudes at 1000 km in full sunlight without earthshine for many directions into `out`; NaN where no
    /// lit surface is visible. The shortest column determines the number of values; the rest of `out` is unchanged.
    ///
    /// The values agree with [`Self::standard_magnitude`] to 1e-9 mag. Two-panel models are vectorised and take some 10
    /// ns per value on one core; other models are evaluated one direction at a time.
    pub fn standard_magnitudes(&self, angles: &BodyAngles, out: &mut [f64]) {
        if let Law::TwoPanel(model) = &self.law {
            return standard_magnitudes(model, self.zero_mag(), Columns::Angles(angles), out);
        }
        let rows = angles.sun_latitude_rad.iter().zip(angles.observer_longitude_rad).zip(angles.observer_latitude_rad);
        for (((&sun, &longitude), &latitude), out) in rows.zip(out) {
            let to_sun = Direction::from_lon_lat_rad(0.0, sun);
            let magnitude = self.standard_magnitude_of(&to_sun, &Direction::from_lon_lat_rad(longitude, latitude), 0.0);
            *out = magnitude.map_or(f64::NAN, |magnitude| magnitude.0);
        }
    }

    /// Writes the magnitudes of [`Self::standard_magnitudes`] for satellites at many positions seen by one observer.
    ///
    /// NaN for a satellite at the observer's position or at the Earth's centre.
    pub fn standard_magnitudes_at(&self, positions: &SatellitePositions, out: &mut [f64]) {
        if let Law::TwoPanel(model) = &self.law {
            return standard_magnitudes(model, self.zero_mag(), Columns::Positions(positions), out);
        }
        let [observer, sun] =
            [positions.observer_km, positions.sun_km].map(|km| Position::<Gcrs>::from_vector(Vector3::from(km)));
        let rows = positions.x_km.iter().zip(positions.y_km).zip(positions.z_km);
        for (((&x, &y), &z), out) in rows.zip(out) {
            let geometry = ViewingGeometry::new(&Position::from_vector(Vector3::new(x, y, z)), &observer, &sun);
            let magnitude = geometry.and_then(|geometry| self.standard_magnitude(&geometry));
            *out = magnitude.map_or(f64::NAN, |magnitude| magnitude.0);
        }
    }

    /// Returns the magnitude at 1000 km for a reflection of 1 m² sr⁻¹.
    fn zero_mag(&self) -> f64 {
        let unit = StandardMagnitude::from_reflection(1.0, self.band.sun_magnitude(self.system));
        unit.map_or(f64::NAN, |unit| unit.0)
    }

    fn standard_magnitude_of(
        &self,
        to_sun: &Direction<Body>,
        to_observer: &Direction<Body>,
        earth_m2_sr: f64,
    ) -> Option<StandardMagnitude> {
        match &self.law {
            Law::TwoPanel(model) => {
                let sunlight = model.terms_of_directions(to_sun.vector(), to_observer.vector()).b_total_m2_sr();
                StandardMagnitude::from_reflection(sunlight + earth_m2_sr, self.band.sun_magnitude(self.system))
            }
            Law::Panels(assembly) => {
                let sunlight = assembly.b_total_m2_sr(to_sun.vector(), to_observer.vector());
                StandardMagnitude::from_reflection(sunlight + earth_m2_sr, self.band.sun_magnitude(self.system))
            }
            Law::Phase(function) => Some(function.standard_magnitude(to_sun.separation_rad(to_observer))),
            Law::Object(object) => object.standard_magnitude(to_sun.separation_rad(to_observer)),
            Law::Mean(mean) => Some(*mean),
        }
    }

    /// Returns the apparent magnitude with its uncertainty, its source, and whether the geometry is within the fitted
    /// range.
    ///
    /// `lit_fraction` is the fraction of the Sun's light that reaches the satellite. `None` if it is 0 or NaN, if no
    /// lit surface is visible, or if extinction is applied and the satellite is on or below the observer's horizon.
    pub fn brightness(
        &self,
        geometry: &ViewingGeometry,
        lit_fraction: f64,
        options: &PhotometryOptions,
    ) -> Option<Brightness> {
        if !(lit_fraction > 0.0 && geometry.range_km > 0.0) {
            return None;
        }
        let (to_sun, to_observer) = (geometry.to_sun(), geometry.to_observer());
        // The Earth's shadow dims sunlight but not earthshine, so earthshine is divided by the factor that is applied
        // below.
        let earth_m2_sr = self.earthshine_m2_sr(geometry, options.earthshine) / lit_fraction.min(1.0);
        let standard = self.standard_magnitude_of(&to_sun, &to_observer, earth_m2_sr)?;
        let grey_reflectance = options.band != self.band;
        let colour = self.colour_to_mag(options.band, options.system);
        let dimming = if lit_fraction < 1.0 { -2.5 * lit_fraction.log10() } else { 0.0 };
        let sun = if options.sun_distance { 5.0 * geometry.sun_distance_au.log10() } else { 0.0 };
        let air = match options.extinction_mag_per_airmass {
            Some(k) => k * airmass(geometry.geocentric_altitude_rad()?)?,
            None => 0.0,
        };
        let magnitude = standard.at_range(geometry.range_km).dimmed_by(colour + dimming + sun + air + self.offset_mag);
        let in_fitted_range = self.covers_phase(geometry, to_sun.cosine(&to_observer));
        let scatter = if in_fitted_range { self.sigma_mag } else { self.sigma_outside_mag };
        let sigma =
            self.parameter_sigma_mag(&to_sun, &to_observer, earth_m2_sr).map_or(scatter, |own| scatter.hypot(own));
        magnitude.0.is_finite().then(|| Brightness {
            magnitude,
            sigma_mag: if grey_reflectance { sigma.hypot(GREY_REFLECTANCE_SIGMA_MAG) } else { sigma },
            scatter_mag: self.sigma_mag,
            error_distribution: self.error_distribution,
            source: self.source.clone(),
            in_fitted_range,
            grey_reflectance,
        })
    }

    /// Returns the uncertainty (one sigma) of the magnitude due to that of the fitted parameters alone, mag: √(J Σ Jᵀ).
    ///
    /// The uncertainty is that of the sunlight. Earthshine (`earth_m2_sr`, 0 without) is taken as exact, although it
    /// depends on the same coefficients; it only reduces the uncertainty. `None` if the model has no covariance, or if
    /// no lit surface is visible.
    pub fn parameter_sigma_mag(
        &self,
        to_sun: &Direction<Body>,
        to_observer: &Direction<Body>,
        earth_m2_sr: f64,
    ) -> Option<f64> {
        let (to_sun, to_observer) = (to_sun.vector(), to_observer.vector());
        let (variance, b_total) = match (&self.uncertainty, &self.law) {
            (ParameterUncertainty::Gradient(sigmas, moved), Law::TwoPanel(model)) => {
                let (gradient, b_total) = model.gradient(to_sun, to_observer);
                let mut all = [0.0; 8];
                all[..7].copy_from_slice(&gradient);
                if let Some(moved) = moved {
                    let [up, down] = moved.each_ref().map(|model| model.gradient(to_sun, to_observer).1);
                    all[7] = (up - down) / (2.0 * OFFSET_STEP_DEG);
                }
                (sigmas.variance_of_gradient(&all), b_total)
            }
            (ParameterUncertainty::Panels(sigmas, sensitivity), Law::Panels(assembly)) => {
                let (gradient, b_total) = sensitivity.gradient(assembly, to_sun, to_observer);
                (sigmas.variance_of_gradient(&gradient), b_total)
            }
            _ => return None,
        };
        // m = -2.5 log₁₀ B + …, dm/dp = -(2.5 / ln 10) (dB/dp) / B
        let b_total = b_total + earth_m2_sr;
        (b_total > 0.0).then(|| 2.5 / std::f64::consts::LN_10 * variance.sqrt() / b_total)
    }

    /// Returns the uncertainty (one sigma) of a single measurement about the model inside the fitted range, mag.
    pub fn sigma_mag(&self) -> f64 {
        self.sigma_mag
    }

    /// Returns the distribution of observed less predicted magnitudes, in units of [`sigma_mag`](Self::sigma_mag).
    pub fn error_distribution(&self) -> &ErrorDistribution {
        &self.error_distribution
    }

    /// Returns true for a geometry within that of the fitted points, or for a model that was not fitted to points.
    pub fn covers(&self, geometry: &ViewingGeometry) -> bool {
        self.covers_phase(geometry, geometry.to_sun().cosine(&geometry.to_observer()))
    }

    fn covers_phase(&self, geometry: &ViewingGeometry, cos_phase: f64) -> bool {
        self.fitted_range.is_none_or(|range| range.holds(geometry, cos_phase))
    }

    /// Returns the chassis and sail (solar array) of a two-panel model.
    pub fn satellite(&self) -> Option<&SatelliteModel> {
        match &self.law {
            Law::TwoPanel(model) => Some(model),
            _ => None,
        }
    }

    /// Returns the panels of a model of the kind `panels`.
    pub fn assembly(&self) -> Option<&PanelAssembly> {
        match &self.law {
            Law::Panels(assembly) => Some(assembly),
            _ => None,
        }
    }

    /// Returns true for models with panels, which are the only ones with earthshine.
    pub fn is_of_panels(&self) -> bool {
        matches!(self.law, Law::TwoPanel(_) | Law::Panels(_))
    }

    /// Returns the source of the magnitudes.
    pub fn source(&self) -> &MagnitudeSource {
        &self.source
    }

    /// Returns the band and the magnitude system of the model.
    pub fn band(&self) -> (Band, MagSystem) {
        (self.band, self.system)
    }

    /// Returns the difference between magnitudes in another band and system and the model's magnitudes, mag, for a grey
    /// satellite.
    pub fn colour_to_mag(&self, band: Band, system: MagSystem) -> f64 {
        // The satellite's colour is the Sun's: m_b = m + (m_sun,b - m_sun).
        band.sun_magnitude(system) - self.band.sun_magnitude(self.system)
    }

    /// Returns the typical size of the satellite's bright part, m.
    pub fn size_m(&self) -> f64 {
        self.size_m
    }

    /// Returns the model file, if the model was made from one.
    pub fn file(&self) -> Option<&ModelFile> {
        self.file.as_deref()
    }
}
