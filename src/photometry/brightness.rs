//! Predicted magnitudes with uncertainty and source, and the options of a prediction.

use std::fmt;
use std::sync::Arc;

use super::band::{Band, MagSystem};
use super::error_distribution::ErrorDistribution;
use super::magnitude::Magnitude;

/// Source of a magnitude; cloning it is fast.
///
/// It is displayed as `brdf:starlink-v1.5`, `phase:v2mini`, `stdmag`, `prior:oneweb` (the mean of a constellation or of
/// a class of objects), `prior` (unknown satellite) or `thermal` (mostly thermal emission, in the infrared). The name
/// of a model is followed by ` (kind assumed)` if the kind of the satellite is assumed, and by ` (learned)` if offsets
/// learned from measurements are applied.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MagnitudeSource {
    /// A model with reflection laws, by name.
    Brdf(Arc<str>),
    /// A phase function, by name.
    Phase(Arc<str>),
    /// The standard magnitude of this object.
    StandardMagnitude,
    /// The mean of a constellation or class of objects, by name.
    Mean(Arc<str>),
    /// An assumed mean for unknown satellites, with an uncertainty that covers most of them.
    Prior,
    /// Thermal emission of the satellite, with at most an equal part of reflected light.
    Thermal,
}

impl MagnitudeSource {
    /// Returns the source for satellites whose kind is assumed; a source without a name is unchanged.
    pub(super) fn of_assumed_kind(&self) -> Self {
        self.with_note("kind assumed")
    }

    /// Returns the source of magnitudes with a learned offset; a source without a name is unchanged.
    pub(super) fn of_learned(&self) -> Self {
        self.with_note("learned")
    }

    /// Returns the source of magnitudes of a diffuse body; a source without a name is unchanged.
    pub(super) fn of_diffuse_body(&self) -> Self {
        self.with_note("diffuse body")
    }

    fn with_note(&self, note: &str) -> Self {
        let noted = |name: &Arc<str>| Arc::from(format!("{name} ({note})"));
        match self {
            Self::Brdf(name) => Self::Brdf(noted(name)),
            Self::Phase(name) => Self::Phase(noted(name)),
            Self::Mean(name) => Self::Mean(noted(name)),
            Self::StandardMagnitude | Self::Prior | Self::Thermal => self.clone(),
        }
    }
}

impl fmt::Display for MagnitudeSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Brdf(name) => write!(f, "brdf:{name}"),
            Self::Phase(name) => write!(f, "phase:{name}"),
            Self::StandardMagnitude => f.write_str("stdmag"),
            Self::Mean(name) => write!(f, "prior:{name}"),
            Self::Prior => f.write_str("prior"),
            Self::Thermal => f.write_str("thermal"),
        }
    }
}

/// Predicted apparent magnitude of a satellite.
#[derive(Clone, Debug, PartialEq)]
pub struct Brightness {
    /// Magnitude at the observer, dimmed by the Earth's shadow, with thermal emission in K, W1 and W2: the median of
    /// single measurements.
    pub magnitude: Magnitude,
    /// One sigma of a single measurement about the prediction, mag: the scatter about the model and, in quadrature, the
    /// errors of colour and position.
    pub sigma_mag: f64,
    /// Scatter about the model only, mag; at most `sigma_mag`. It is larger outside the fitted geometry and near the
    /// Earth's shadow.
    pub scatter_mag: f64,
    /// Distribution of the scatter, in units of `scatter_mag`.
    #[doc(hidden)]
    pub error_distribution: ErrorDistribution,
    /// Source of the magnitude.
    pub source: MagnitudeSource,
    /// True if the geometry is within 10° of that of the fitted measurements; farther away the uncertainty is more than
    /// 1.4 times as large as inside. False also for satellites of constellations below 300 km, which have just been
    /// launched or re-enter; their uncertainty is at least 1.5 mag. False for light that is mostly thermal emission.
    pub in_fitted_range: bool,
    /// True if the model is for another band and the magnitude was converted with the Sun's colour.
    pub grey_reflectance: bool,
}

impl Brightness {
    /// Returns the probability that the satellite is brighter than an apparent magnitude in the same band, [0, 1].
    ///
    /// The scatter about the model has wings; the other errors in `sigma_mag` are normal and independent.
    pub fn probability_brighter_than(&self, limit_mag: f64) -> f64 {
        // m + σ x + e < limit, with the scatter σ and e² = sigma_mag² - σ²
        let more_mag = (self.sigma_mag * self.sigma_mag - self.scatter_mag * self.scatter_mag).max(0.0).sqrt();
        let x = (limit_mag - self.magnitude.0) / self.scatter_mag;
        self.error_distribution.cumulative(x, more_mag / self.scatter_mag)
    }

    /// Returns the apparent magnitude than which the satellite is brighter with a probability, in (0, 1).
    pub fn exceeded_with(&self, probability: f64) -> f64 {
        /// Distances from the median in which the magnitude is searched, mag; the wings are a few sigmas wide.
        const FARTHEST_MAG: f64 = 50.0;
        let (mut bright, mut faint) = (self.magnitude.0 - FARTHEST_MAG, self.magnitude.0 + FARTHEST_MAG);
        for _ in 0..40 {
            let middle = 0.5 * (bright + faint);
            if self.probability_brighter_than(middle) < probability { bright = middle } else { faint = middle }
        }
        0.5 * (bright + faint)
    }
}

/// Earthshine on the chassis of two-panel models, and on panels that receive it.
///
/// Lu (2024) is inconsistent as to whether its final model includes earthshine (section 4.3 against 4.4). Phase
/// functions and means are based on measured magnitudes, which include earthshine; they ignore this option. The
/// coefficients of panel models that were fitted with sunlight alone absorb some of the earthshine, as noted in their
/// files.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Hash)]
pub enum Earthshine {
    /// Sunlight on the panels only: a satellite of which no lit panel is visible has no magnitude.
    Off,
    /// A spherical Lambertian Earth of albedo 0.3, integrated for each geometry to 0.001 mag.
    #[default]
    Computed,
}

impl Earthshine {
    /// Returns the name written to the provenance.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Computed => "computed",
        }
    }
}

/// Options of a predicted magnitude.
///
/// The defaults are those of Lu (2024): V in the Vega system, the Sun at 1 au, no atmosphere, with earthshine.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PhotometryOptions {
    /// Passband.
    pub band: Band,
    /// Zero point system of the magnitudes.
    pub system: MagSystem,
    /// If true, 5 log10 R is added for the Sun's distance R in au (at most ±0.037 mag), which Lu (2024) neglects.
    pub sun_distance: bool,
    /// Extinction coefficient k of the site, mag per airmass; `None` for magnitudes above the atmosphere. With
    /// extinction, a satellite on or below the observer's horizon has no magnitude.
    pub extinction_mag_per_airmass: Option<f64>,
    /// Model of earthshine for panel models.
    pub earthshine: Earthshine,
}

impl Default for PhotometryOptions {
    fn default() -> Self {
        Self {
            band: Band::V,
            system: MagSystem::Vega,
            sun_distance: false,
            extinction_mag_per_airmass: None,
            earthshine: Earthshine::default(),
        }
    }
}

impl PhotometryOptions {
    /// Returns the default options with another band and magnitude system.
    pub fn in_band(band: Band, system: MagSystem) -> Self {
        Self { band, system, ..Self::default() }
    }

    /// Returns the names and values of the options for the provenance of a result.
    pub fn statements(&self) -> Vec<(&'static str, serde_json::Value)> {
        let mut statements = vec![
            ("band", self.band.name().into()),
            ("mag_system", self.system.to_string().into()),
            ("earthshine", self.earthshine.name().into()),
        ];
        statements.extend(self.extinction_mag_per_airmass.map(|mag| ("extinction_mag_per_airmass", mag.into())));
        statements.extend(self.sun_distance.then(|| ("sun_distance", "of the day".into())));
        statements
    }
}

#[cfg(test)]
mod tests {
    use super::super::error_distribution::NormalPart;
    use super::*;

    #[test]
    fn verif_probability_of_a_normal_core_with_another_error() {
        let light = Brightness {
            magnitude: Magnitude(6.0),
            sigma_mag: 0.5,
            scatter_mag: 0.4,
            error_distribution: ErrorDistribution::NORMAL,
            source: MagnitudeSource::Prior,
            in_fitted_range: true,
            grey_reflectance: false,
        };
        // Φ(1) and Φ(-2) of a normal distribution of width 0.5 mag.
        assert!((light.probability_brighter_than(6.5) - 0.841_344_746).abs() < 1e-9);
        assert!((light.probability_brighter_than(5.0) - 0.022_750_132).abs() < 1e-9);
        assert_eq!(light.probability_brighter_than(6.0), 0.5);
        assert!((light.exceeded_with(0.022_750_132) - 5.0).abs() < 1e-6);
        // A tenth of the magnitudes is in a wing that is 2 mag brighter; only the wing is brighter than 4.5 mag.
        let mut flares = light.error_distribution;
        (flares.parts[0].share, flares.parts[1]) = (0.9, NormalPart { share: 0.1, centre: -5.0, width: 0.5 });
        let flaring = Brightness { sigma_mag: 0.4, error_distribution: flares, ..light };
        assert!((flaring.probability_brighter_than(4.5) - 0.1).abs() < 1e-2);
    }

    #[test]
    fn verif_sources_are_displayed_as_in_tables() {
        assert_eq!(MagnitudeSource::Brdf("starlink-v1.5".into()).to_string(), "brdf:starlink-v1.5");
        assert_eq!(MagnitudeSource::Phase("v2mini".into()).to_string(), "phase:v2mini");
        assert_eq!(MagnitudeSource::StandardMagnitude.to_string(), "stdmag");
        assert_eq!(MagnitudeSource::Mean("oneweb".into()).to_string(), "prior:oneweb");
        assert_eq!(MagnitudeSource::Prior.to_string(), "prior");
        let assumed = MagnitudeSource::Phase("v2mini".into()).of_assumed_kind();
        assert_eq!(assumed.to_string(), "phase:v2mini (kind assumed)");
    }
}
