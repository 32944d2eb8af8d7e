//! Model files: what they hold, and what is allowed in them.
//!
//! A model is data. Files are JSON, one model each; the schema for editors and other programs stands beside the
//! shipped ones (`models/model.schema.json`). Unknown keys are errors, so that a misspelt option is never silently
//! ignored.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::band::{Band, MagSystem};
use super::panels::PanelsSpec;

/// The schema version that this code reads and writes.
pub const SCHEMA_VERSION: u32 = 1;

/// The panel offset of chassis and sail, which may be fitted beside the coefficients.
pub const PANEL_OFFSET: &str = "panel_offset_deg";

/// What a model computes with.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ModelKind {
    /// Chassis and sail with five terms: `shape`, `coefficients`, `covariance`.
    TwoPanel,
    /// Any number of flat panels: `panels`, `covariance`.
    Panels,
    /// A polynomial in the phase angle: `phase_function`.
    PhaseFunction,
    /// The mean at 1000 km of a constellation or class of objects, taken for every geometry: `mean_mag`.
    Mean,
    /// As `mean`, but a guess: nothing is known of the satellite.
    Prior,
}

/// One model as it stands in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelFile {
    /// Version of the schema; 1.
    pub schema: u32,
    /// Lower-case letters, digits, `.` and `-`.
    pub name: String,
    /// Other names it answers to.
    #[serde(default)]
    pub aliases: Vec<String>,
    /// One line for people.
    pub title: String,
    /// What it computes with; decides which of the optional keys must be there.
    pub kind: ModelKind,
    /// Band of the magnitudes: `V`, `g`, …
    pub band: String,
    /// `Vega` or `AB`.
    pub mag_system: String,
    /// Typical extent across the sky of the part that shines, m: it widens a streak. Assumed for all shipped models.
    pub size_m: f64,
    /// Sizes of the panels (`two_panel`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<SatelliteShape>,
    /// Coefficients of the five terms (`two_panel`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coefficients: Option<Coefficients>,
    /// Panels, their laws and attitudes (`panels`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub panels: Option<PanelsSpec>,
    /// Covariance of the coefficients: c1, c2, c3, c4, c5, n_sail, n_base, and where it was fitted too panel_offset_deg as the eighth; or of the
    /// parameters of `panels` in their order; null while none is known.
    #[serde(default)]
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Polynomial in the phase angle (`phase_function`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase_function: Option<PhasePolynomial>,
    /// Mean magnitude at 1000 km (`mean`, `prior`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_mag: Option<f64>,
    /// Root mean square of the residuals on the fitted points, mag; null where none was published.
    pub rms_mag: Option<f64>,
    /// One sigma of a single measurement about the model inside the fitted range, mag; what the covariance of the
    /// parameters does to the prediction comes on top.
    pub sigma_mag: f64,
    /// One sigma outside of it, mag; not less than `sigma_mag`.
    pub sigma_outside_mag: f64,
    /// Where the two sigmas come from.
    pub sigma_origin: String,
    /// The geometry of the points it rests on; null where it rests on an average.
    pub geometry_range: Option<GeometryRange>,
    /// Whose data, which publication, what to know.
    pub provenance: Provenance,
}

/// Sizes of chassis and sail.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SatelliteShape {
    /// Sail, from the hinge up, m.
    pub sail_length_m: f64,
    /// Sail, along the hinge, m.
    pub sail_width_m: f64,
    /// Chassis, from the hinge towards the Sun, m.
    pub base_length_m: f64,
    /// Chassis, along the hinge, m.
    pub base_width_m: f64,
    /// Panel offset angle, degrees; positive leans the sail away from the Sun.
    pub panel_offset_deg: f64,
}

/// Coefficients of Lu (2024), eqs. 2-6.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coefficients {
    /// Weight of the sail's glossy lobe.
    pub c1: f64,
    /// Diffuse albedo of the sail's front.
    pub c2: f64,
    /// Diffuse leak to the sail's back.
    pub c3: f64,
    /// Weight of the chassis' glossy lobe.
    pub c4: f64,
    /// Diffuse albedo of the chassis.
    pub c5: f64,
    /// Exponent of the sail's lobe.
    pub n_sail: f64,
    /// Exponent of the chassis' lobe.
    pub n_base: f64,
}

/// m(1000 km) = Σ coefficients\[i\] φ^i, φ the angle Sun-satellite-observer in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PhasePolynomial {
    /// Of φ⁰, φ¹, …
    pub coefficients: Vec<f64>,
    /// The phase is clamped to this from below, degrees.
    pub min_phase_deg: f64,
    /// The phase is clamped to this from above, degrees.
    pub max_phase_deg: f64,
}

/// The geometry of the points that a model rests on, each as [least, greatest], degrees; null where it does not matter.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GeometryRange {
    /// Of the Sun above the chassis plane.
    #[serde(default)]
    pub sun_latitude_deg: Option<[f64; 2]>,
    /// Of the observer above the chassis plane.
    #[serde(default)]
    pub observer_latitude_deg: Option<[f64; 2]>,
    /// Angle Sun-satellite-observer.
    #[serde(default)]
    pub phase_angle_deg: Option<[f64; 2]>,
}

/// Where a model comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Publication or maker of the fit.
    pub source: String,
    /// The measurements it rests on.
    pub data: String,
    /// How many points were fitted; null where not published.
    pub n_points: Option<u64>,
    /// When the fit was made or published: `2026-11`, `2022-10`.
    pub date: String,
    /// True while a better fit is known to be due.
    pub provisional: bool,
    /// What a careful user should know.
    pub notes: Vec<String>,
}

/// Why a model file cannot be used. `origin` is the file's name.
#[derive(Debug, Error)]
pub enum ModelFileError {
    /// Not JSON, a key missing, unknown or of the wrong type; the message names the key, the line and the column.
    #[error("model file {origin}: {source}")]
    Json {
        /// The file.
        origin: String,
        /// What and where.
        source: serde_json::Error,
    },
    /// Written for another version of the schema.
    #[error("model file {origin}: schema is {given}, this version reads {SCHEMA_VERSION}")]
    Schema {
        /// The file.
        origin: String,
        /// As it stands there.
        given: u32,
    },
    /// A number outside what is allowed, or not finite.
    #[error("model file {origin}: {key} is {given}, allowed is {least} to {greatest}")]
    OutOfRange {
        /// The file.
        origin: String,
        /// The key, with its path.
        key: String,
        /// As it stands there.
        given: f64,
        /// Least allowed value.
        least: f64,
        /// Greatest allowed value.
        greatest: f64,
    },
    /// A text that is not one of the allowed ones.
    #[error("model file {origin}: {key} is {given:?}, allowed is {allowed}")]
    Text {
        /// The file.
        origin: String,
        /// The key.
        key: &'static str,
        /// As it stands there.
        given: String,
        /// What may stand there.
        allowed: &'static str,
    },
    /// A key that the kind needs is missing, or one stands there that the kind has no use for.
    #[error("model file {origin}: kind {kind} {problem} the key {key:?}")]
    Key {
        /// The file.
        origin: String,
        /// As in files.
        kind: &'static str,
        /// `needs` or `has no use for`.
        problem: &'static str,
        /// The key.
        key: &'static str,
    },
    /// A name that stands for nothing in this file.
    #[error("model file {origin}: {key} is {given:?}, allowed: {allowed}")]
    Reference {
        /// The file.
        origin: String,
        /// The key, with its path.
        key: String,
        /// As it stands there.
        given: String,
        /// What may stand there.
        allowed: String,
    },
    /// The covariance is not a symmetric matrix of the parameters with a diagonal that is not negative.
    #[error(
        "model file {origin}: covariance must be {size} x {size} (the coefficients in their order), finite and \
         symmetric, with a diagonal of at least 0: {problem}"
    )]
    Covariance {
        /// The file.
        origin: String,
        /// Number of parameters.
        size: usize,
        /// What is wrong.
        problem: String,
    },
}

impl ModelKind {
    /// As it stands in files.
    pub fn name(self) -> &'static str {
        match self {
            ModelKind::TwoPanel => "two_panel",
            ModelKind::Panels => "panels",
            ModelKind::PhaseFunction => "phase_function",
            ModelKind::Mean => "mean",
            ModelKind::Prior => "prior",
        }
    }
}

impl ModelFile {
    /// Reads and validates one model; `origin` (a file name) is what errors call it.
    ///
    /// # Errors
    /// [`ModelFileError`]: text that is not JSON, unknown or missing keys, another schema version, values out of
    /// range, keys that do not fit the kind, a covariance that is none.
    pub fn from_json(text: &str, origin: &str) -> Result<Self, ModelFileError> {
        let file: Self =
            serde_json::from_str(text).map_err(|source| ModelFileError::Json { origin: origin.to_owned(), source })?;
        file.validate(origin)?;
        Ok(file)
    }

    /// The file's text again, indented.
    pub fn to_json(&self) -> String {
        // No map with keys other than strings and no number that is not finite is in a validated file.
        serde_json::to_string_pretty(self).unwrap_or_default()
    }

    /// Names and values of what was fitted, in the order of the covariance; none where nothing was.
    pub fn parameters(&self) -> Vec<(&str, f64)> {
        if let Some(c) = &self.coefficients {
            let mut parameters = vec![
                ("c1", c.c1),
                ("c2", c.c2),
                ("c3", c.c3),
                ("c4", c.c4),
                ("c5", c.c5),
                ("n_sail", c.n_sail),
                ("n_base", c.n_base),
            ];
            let with_offset = self.covariance.as_ref().is_some_and(|rows| rows.len() > parameters.len());
            parameters.extend(self.shape.filter(|_| with_offset).map(|shape| (PANEL_OFFSET, shape.panel_offset_deg)));
            return parameters;
        }
        let panels = self.panels.iter().flat_map(|panels| &panels.parameters);
        panels.map(|parameter| (parameter.name.as_str(), parameter.value)).collect()
    }

    /// The band and system of its magnitudes, if they are known ones.
    pub fn band_and_system(&self) -> Option<(Band, MagSystem)> {
        Some((self.band.parse().ok()?, self.mag_system.parse().ok()?))
    }
}
