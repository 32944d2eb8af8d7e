//! Brightness models of all kinds, with a common interface.

use std::sync::Arc;

use nalgebra::Vector3;

use super::band::{Band, MagSystem};
use super::brightness::{Brightness, Earthshine, MagnitudeSource, PhotometryOptions};
use super::diffuse::{DIFFUSE_SIGMA_MAG, DiffuseBody, Ranges};
use super::error_distribution::ErrorDistribution;
use super::magnitude::{StandardMagnitude, airmass};
use super::model_file::{GeometryRange, ModelFile, ModelKind};
use super::panels::{PanelAssembly, PanelsSpec};
use super::phase::{PhaseFunction, StandardObject};
use super::thermal::{Emission, UNKNOWN_SIZE_M};
use super::two_panel::{BodyAngles, Columns, SatelliteModel, SatellitePositions, standard_magnitudes};
use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;
use crate::error::Error;
use crate::frames::{Body, Direction, Gcrs, Position};
use crate::geometry::{KARMAN_LINE_KM, ViewingGeometry};

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

/// Distance from the fitted geometry at which the variance of single magnitudes is twice that inside, radians.
///
/// Sigma on regions that were left out of the fits, over that inside, is 1.0 at 0 to 3°, 1.2 at 5 to 8°, 1.7 at 12 to
/// 18° and 2.5 at 18 to 25° (five kinds, `tests/fitting/outside_geometry.rs`).
const OUTSIDE_SCALE_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// Uncertainty that is added in quadrature beyond the largest fitted phase angle of models with a forward lobe, mag.
/// The strength of the lobe there is not known from smaller phase angles; errors are 0.5 to 3 mag.
const FORWARD_SIGMA_MAG: f64 = 1.0;

/// Uncertainty that is added in quadrature near the Earth's shadow, mag. Single magnitudes of Starlink V1.5 scatter by
/// 0.41 to 0.46 mag there, elsewhere by 0.33 mag.
const NEAR_SHADOW_SIGMA_MAG: f64 = 0.25;

/// Fraction of sunlight below which a satellite is near the Earth's shadow.
const NEAR_SHADOW_LIT: f64 = 0.999;

/// Returns true if less than 99.9 % of the sunlight arrives, or if the line to the Sun passes less than 100 km above a
/// sphere of the equatorial radius.
fn is_near_shadow(geometry: &ViewingGeometry, lit_fraction: f64) -> bool {
    let radius_km = geometry.height_km + EARTH_EQUATORIAL_RADIUS_KM;
    let is_grazing = geometry.sun_latitude_rad < 0.0
        && radius_km * geometry.sun_latitude_rad.cos() < EARTH_EQUATORIAL_RADIUS_KM + KARMAN_LINE_KM;
    lit_fraction < NEAR_SHADOW_LIT || is_grazing
}

/// Returns the extinction, mag; `None` on and below the observer's horizon if extinction is applied.
fn air_mag(geometry: &ViewingGeometry, options: &PhotometryOptions) -> Option<f64> {
    Some(match options.extinction_mag_per_airmass {
        Some(k) => k * airmass(geometry.geocentric_altitude_rad()?)?,
        None => 0.0,
    })
}

/// Height below which no constellation holds its orbit, km. Satellites there have just been launched or re-enter; drag
/// determines their attitude, and no model was fitted to them. The lowest shells in use are at 340 km.
const LOWEST_HELD_KM: f64 = 300.0;
/// Tolerance of the cosine of a phase angle at the end of a range.
const ROUNDING: f64 = 1e-9;

/// Ranges of the geometry of the points to which a model was fitted.
#[derive(Copy, Clone, Debug, PartialEq)]
struct FittedRange {
    /// Latitudes above the chassis plane, and phase angle.
    ranges: Ranges,
    /// Cosines of the largest and the smallest phase angle, which avoid an arc cosine for points inside.
    cos_phase: [f64; 2],
}

impl FittedRange {
    /// Ranges that the file omits are those of observers on the ground.
    fn from_file(range: Option<&GeometryRange>) -> Self {
        let radians = |range: Option<[f64; 2]>, all: [f64; 2]| range.map_or(all, |range| range.map(f64::to_radians));
        let all = Ranges::FROM_THE_GROUND;
        let ranges = Ranges {
            sun_latitude_rad: radians(range.and_then(|range| range.sun_latitude_deg), all.sun_latitude_rad),
            observer_latitude_rad: radians(
                range.and_then(|range| range.observer_latitude_deg),
                all.observer_latitude_rad,
            ),
            phase_rad: radians(range.and_then(|range| range.phase_angle_deg), all.phase_rad),
        };
        Self { ranges, cos_phase: [ranges.phase_rad[1].cos(), ranges.phase_rad[0].cos()] }
    }

    /// Returns the distance of a geometry from the ranges: the root of the sum of the squares of the angles by which
    /// Sun, observer and phase angle exceed them, radians.
    fn distance_rad(&self, geometry: &ViewingGeometry, cos_phase: f64) -> f64 {
        let beyond = |value: f64, [from, to]: [f64; 2]| (from - value).max(value - to).max(0.0);
        let sun = beyond(geometry.sun_latitude_rad, self.ranges.sun_latitude_rad);
        let observer = beyond(geometry.observer_latitude_rad, self.ranges.observer_latitude_rad);
        let [least, greatest] = self.cos_phase;
        let phase = if (least..=greatest).contains(&cos_phase) {
            0.0
        } else {
            beyond(cos_phase.clamp(-1.0, 1.0).acos(), self.ranges.phase_rad)
        };
        (sun * sun + observer * observer + phase * phase).sqrt()
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

impl Law {
    fn is_of_panels(&self) -> bool {
        matches!(self, Law::TwoPanel(_) | Law::Panels(_))
    }

    /// Returns the sunlight that panels reflect, m² sr⁻¹; 0 without panels.
    fn reflection_m2_sr(&self, to_sun: &Direction<Body>, to_observer: &Direction<Body>) -> f64 {
        match self {
            Law::TwoPanel(model) => model.terms_of_directions(to_sun.vector(), to_observer.vector()).b_total_m2_sr(),
            Law::Panels(assembly) => assembly.b_total_m2_sr(to_sun.vector(), to_observer.vector()),
            Law::Phase(_) | Law::Object(_) | Law::Mean(_) => 0.0,
        }
    }
}

/// A brightness model: two panels, a list of panels, a phase function, a standard magnitude or a mean.
///
/// Computing a magnitude allocates nothing, except for earthshine on lists of panels.
#[derive(Clone, Debug, PartialEq)]
pub struct BrightnessModel {
    law: Law,
    source: MagnitudeSource,
    band: Band,
    system: MagSystem,
    sigma_mag: f64,
    /// Learned offset of the satellite, mag; added to apparent magnitudes.
    offset_mag: f64,
    error_distribution: ErrorDistribution,
    fitted_range: Option<FittedRange>,
    /// True for a model with a lobe of transmitted light in the direction of the sunlight.
    has_forward_lobe: bool,
    size_m: f64,
    /// Light of a model of panels that is seen or lit from above.
    diffuse: Option<DiffuseBody>,
    file: Option<Arc<ModelFile>>,
}

impl BrightnessModel {
    /// Creates a model from the text of a model file; errors contain `origin` (the name of the file).
    ///
    /// # Errors
    /// The errors of [`ModelFile::from_json`].
    pub fn from_json(text: &str, origin: &str) -> Result<Self, Error> {
        Self::from_file(ModelFile::from_json(text, origin)?, origin)
    }

    /// Creates a model from the content of a model file, which is validated again.
    ///
    /// # Errors
    /// The errors of [`ModelFile::validate`].
    #[doc(hidden)]
    pub fn from_file(file: ModelFile, origin: &str) -> Result<Self, Error> {
        file.validate(origin)?;
        let needs = |key| {
            Error::format(format!("kind {} requires the key {key:?}", file.kind.name())).in_file("model file", origin)
        };
        let (band, system) = file.band_and_system().ok_or_else(|| needs("band"))?;
        let name: Arc<str> = file.name.as_str().into();
        let (law, source) = match file.kind {
            ModelKind::Panels => {
                let spec = file.panels.as_ref().ok_or_else(|| needs("panels"))?;
                (Law::Panels(Box::new(spec.assemble(&[]))), MagnitudeSource::Brdf(name))
            }
            ModelKind::TwoPanel => {
                let shape = file.shape.as_ref().ok_or_else(|| needs("shape"))?;
                let coefficients = file.coefficients.as_ref().ok_or_else(|| needs("coefficients"))?;
                let model = SatelliteModel::new(shape, coefficients).ok_or_else(|| needs("shape"))?;
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
                match file.kind {
                    ModelKind::Mean => (Law::Mean(mean), MagnitudeSource::Mean(name)),
                    _ => (Law::Object(StandardObject { half_lit: mean }), MagnitudeSource::Prior),
                }
            }
        };
        let fitted_range = match law {
            Law::TwoPanel(_) | Law::Panels(_) | Law::Phase(_) => {
                Some(FittedRange::from_file(file.geometry_range.as_ref()))
            }
            Law::Object(_) | Law::Mean(_) => None,
        };
        let diffuse = fitted_range
            .filter(|_| law.is_of_panels())
            .and_then(|range| DiffuseBody::new(|sun, observer| law.reflection_m2_sr(sun, observer), &range.ranges));
        // A prior describes differences between objects, which have no wing of flares.
        let is_prior = file.kind == ModelKind::Prior;
        Ok(Self {
            law,
            source,
            band,
            system,
            sigma_mag: file.sigma_mag,
            offset_mag: 0.0,
            error_distribution: if is_prior { ErrorDistribution::NORMAL } else { ErrorDistribution::SATELLITES },
            fitted_range,
            diffuse,
            has_forward_lobe: file.panels.as_ref().is_some_and(PanelsSpec::has_forward_lobe),
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
            source,
            band: Band::V,
            system: MagSystem::Vega,
            sigma_mag,
            offset_mag: 0.0,
            error_distribution: ErrorDistribution::SATELLITES,
            fitted_range: None,
            has_forward_lobe: false,
            size_m,
            diffuse: None,
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
    /// Outside the fitted range the learned sigma is increased by the rule of the model. Standard magnitudes are those
    /// of the model.
    #[doc(hidden)]
    pub fn with_learned(&self, offset_mag: f64, sigma_mag: f64, error_distribution: ErrorDistribution) -> Self {
        Self { offset_mag, sigma_mag, error_distribution, source: self.source.of_learned(), ..self.clone() }
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
    #[doc(hidden)]
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
    pub(crate) fn standard_magnitudes_at(&self, positions: &SatellitePositions, out: &mut [f64]) {
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
            Law::TwoPanel(_) | Law::Panels(_) => {
                let sunlight = self.law.reflection_m2_sr(to_sun, to_observer);
                StandardMagnitude::from_reflection(sunlight + earth_m2_sr, self.band.sun_magnitude(self.system))
            }
            Law::Phase(function) => Some(function.standard_magnitude(to_sun.separation_rad(to_observer))),
            Law::Object(object) => object.standard_magnitude(to_sun.separation_rad(to_observer)),
            Law::Mean(mean) => Some(*mean),
        }
    }

    /// Returns the apparent magnitude (the median of single measurements) with its uncertainty, its source, and whether
    /// the geometry is within 10° of the fitted one.
    ///
    /// `lit_fraction` is the fraction of the Sun's light that reaches the satellite. `None` if it is 0 or NaN, or if
    /// extinction is applied and the satellite is on or below the observer's horizon. With the Sun above its largest
    /// fitted latitude or the observer above the plane of the satellite's horizon, the satellite is at least as bright
    /// as a diffuse body with the median brightness of the model in its fitted range, with a sigma of 1.5 mag or more;
    /// elsewhere it is at most 5 mag fainter than this body. The source then ends with `(diffuse body)`. Without
    /// earthshine, magnitudes are those of sunlight on the panels alone.
    ///
    /// In K, W1, W2 and response curves beyond about 2 µm, thermal emission is added, and a satellite without sunlight
    /// has a magnitude.
    pub fn brightness(
        &self,
        geometry: &ViewingGeometry,
        lit_fraction: f64,
        options: &PhotometryOptions,
    ) -> Option<Brightness> {
        let reflected = self.reflected_light(geometry, lit_fraction, options);
        if !options.band.has_emission() {
            return reflected;
        }
        if !(lit_fraction >= 0.0 && geometry.range_km > 0.0) {
            return None;
        }
        // The sigma of a prior is that of different objects.
        let objects_sigma_mag = if matches!(self.source, MagnitudeSource::Prior) { self.sigma_mag } else { 0.0 };
        let emission = Emission::new(self.size_m, objects_sigma_mag, geometry, options)?;
        Some(emission.with_reflection(reflected, air_mag(geometry, options)?))
    }

    /// Returns the light of [`Self::brightness`] without thermal emission.
    fn reflected_light(
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
        let modelled = self.standard_magnitude_of(&to_sun, &to_observer, earth_m2_sr);
        // A satellite that is seen or lit from above is at least as bright as a diffuse body.
        let diffuse = self.diffuse.filter(|_| options.earthshine == Earthshine::Computed).and_then(|body| {
            let reflection_m2_sr = body.reflection_m2_sr(geometry);
            StandardMagnitude::from_reflection(reflection_m2_sr, self.band.sun_magnitude(self.system))
        });
        let brighter = diffuse.filter(|diffuse| modelled.is_none_or(|modelled| diffuse.0 < modelled.0));
        let standard = brighter.or(modelled)?;
        let grey_reflectance = options.band != self.band;
        let colour = self.colour_to_mag(options.band, options.system);
        let dimming = if lit_fraction < 1.0 { -2.5 * lit_fraction.log10() } else { 0.0 };
        let sun = if options.sun_distance { 5.0 * geometry.sun_distance_au.log10() } else { 0.0 };
        let air = air_mag(geometry, options)?;
        let magnitude = standard.at_range(geometry.range_km).dimmed_by(colour + dimming + sun + air + self.offset_mag);
        let (mut scatter_mag, in_fitted_range) = self.scatter_mag(geometry, to_sun.cosine(&to_observer), lit_fraction);
        if brighter.is_some() {
            scatter_mag = scatter_mag.max(DIFFUSE_SIGMA_MAG);
        }
        magnitude.0.is_finite().then(|| Brightness {
            magnitude,
            sigma_mag: if grey_reflectance { scatter_mag.hypot(GREY_REFLECTANCE_SIGMA_MAG) } else { scatter_mag },
            scatter_mag,
            error_distribution: self.error_distribution,
            source: if brighter.is_some() { self.source.of_diffuse_body() } else { self.source.clone() },
            in_fitted_range: in_fitted_range && brighter.is_none(),
            grey_reflectance,
        })
    }

    /// Returns the uncertainty (one sigma) of a single magnitude about the model in a geometry, mag, and whether the
    /// geometry is within 10° of the fitted one and the satellite at a height at which constellations hold their
    /// orbits.
    fn scatter_mag(&self, geometry: &ViewingGeometry, cos_phase: f64, lit_fraction: f64) -> (f64, bool) {
        // s² = s0² (1 + (d / 10°)²), with the distance d from the fitted geometry, at most that of a diffuse body
        let distance =
            self.fitted_range.map_or(0.0, |range| range.distance_rad(geometry, cos_phase) / OUTSIDE_SCALE_RAD);
        let inside = self.sigma_mag * self.sigma_mag;
        let mut variance =
            (inside * (1.0 + distance * distance)).min(inside.max(DIFFUSE_SIGMA_MAG * DIFFUSE_SIGMA_MAG));
        let is_forward =
            self.has_forward_lobe && self.fitted_range.is_some_and(|range| cos_phase < range.cos_phase[0] - ROUNDING);
        if is_forward {
            variance += FORWARD_SIGMA_MAG * FORWARD_SIGMA_MAG;
        }
        // Standard magnitudes and priors hold for any attitude.
        let is_falling = geometry.height_km < LOWEST_HELD_KM && !matches!(self.law, Law::Object(_));
        if is_falling {
            variance = variance.max(DIFFUSE_SIGMA_MAG * DIFFUSE_SIGMA_MAG);
        }
        if is_near_shadow(geometry, lit_fraction) {
            variance += NEAR_SHADOW_SIGMA_MAG * NEAR_SHADOW_SIGMA_MAG;
        }
        (variance.sqrt(), distance <= 1.0 && !is_forward && !is_falling)
    }

    /// Returns the uncertainty (one sigma) of a single measurement about the model inside the fitted range, mag.
    pub fn sigma_mag(&self) -> f64 {
        self.sigma_mag
    }

    /// Returns the distribution of observed less predicted magnitudes, in units of sigma.
    #[doc(hidden)]
    pub fn error_distribution(&self) -> &ErrorDistribution {
        &self.error_distribution
    }

    /// Returns true for a geometry within 10° of that of the fitted points, or for a model that was not fitted to
    /// points. Beyond the largest fitted phase angle of a model with a forward lobe the result is false, and also below
    /// 300 km, except for standard magnitudes of objects and for priors.
    pub fn covers(&self, geometry: &ViewingGeometry) -> bool {
        self.scatter_mag(geometry, geometry.to_sun().cosine(&geometry.to_observer()), 1.0).1
    }

    /// Returns the chassis and sail (solar array) of a two-panel model.
    #[doc(hidden)]
    pub fn satellite(&self) -> Option<&SatelliteModel> {
        match &self.law {
            Law::TwoPanel(model) => Some(model),
            _ => None,
        }
    }

    /// Returns the panels of a model of the kind `panels`.
    #[doc(hidden)]
    pub fn assembly(&self) -> Option<&PanelAssembly> {
        match &self.law {
            Law::Panels(assembly) => Some(assembly),
            _ => None,
        }
    }

    /// Returns true for models with panels, which are the only ones with earthshine.
    pub fn is_of_panels(&self) -> bool {
        self.law.is_of_panels()
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
    #[doc(hidden)]
    pub fn file(&self) -> Option<&ModelFile> {
        self.file.as_deref()
    }
}
