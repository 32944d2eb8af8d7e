//! Content of model files, and the ranges of values that are accepted.
//!
//! A model file is a JSON file with one model. The schema for editors and other programs is in the folder of the
//! embedded models (`models/model.schema.json`). Unknown keys are errors, so that a misspelt option is not ignored.

use serde::{Deserialize, Serialize};

use super::band::{Band, MagSystem};
use super::error::{Check, SCHEMA_VERSION};
use super::panels::PanelsSpec;
use crate::error::Error;
use crate::input::json_error;

/// Name of the panel offset of chassis and sail, a parameter that may be fitted together with the coefficients.
pub const PANEL_OFFSET: &str = "panel_offset_deg";

/// Kind of a model.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ModelKind {
    /// Chassis and sail (solar array) with five terms: `shape`, `coefficients`, `covariance`.
    TwoPanel,
    /// Any number of flat panels: `panels`, `covariance`.
    Panels,
    /// A polynomial in the phase angle: `phase_function`.
    PhaseFunction,
    /// Magnitude at 1000 km of a constellation or of a class of objects, used for every geometry: `mean_mag`.
    Mean,
    /// As `mean`, but an assumed value for unknown satellites.
    Prior,
}

/// Content of a model file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelFile {
    /// Version of the schema; 1.
    pub schema: u32,
    /// Name, of lower-case letters, digits, `.` and `-`.
    pub name: String,
    /// Other names of the model.
    #[serde(default)]
    pub aliases: Vec<String>,
    /// Title in one line.
    pub title: String,
    /// Kind of the model, which determines which optional keys are required.
    pub kind: ModelKind,
    /// Name of the band of the magnitudes, for example `V` or `g`.
    pub band: String,
    /// Magnitude system, `Vega` or `AB`.
    pub mag_system: String,
    /// Typical size of the bright part of the satellite, m. Its angular size widens the streak. It is assumed for all
    /// embedded models.
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
    /// Covariance of the coefficients c1, c2, c3, c4, c5, n_sail, n_base, and of panel_offset_deg as the eighth if it
    /// was fitted; or of the parameters of `panels` in their order. Null if unknown.
    #[serde(default)]
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Polynomial in the phase angle (`phase_function`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase_function: Option<PhasePolynomial>,
    /// Median magnitude at 1000 km of a constellation or class (`mean`, `prior`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_mag: Option<f64>,
    /// Root mean square of the residuals of the fitted points, mag; null if not published.
    pub rms_mag: Option<f64>,
    /// Half width about the model that contains 68.3 % of single measurements inside the fitted range, mag. It includes
    /// the errors of the parameters. Outside the range sigma grows with the distance from it.
    pub sigma_mag: f64,
    /// How sigma was determined.
    pub sigma_origin: String,
    /// Geometry of the fitted points; null for an average.
    pub geometry_range: Option<GeometryRange>,
    /// Source and caveats.
    pub provenance: Provenance,
}

/// Sizes of chassis and sail (solar array).
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SatelliteShape {
    /// Length of the sail, from the hinge up, m.
    pub sail_length_m: f64,
    /// Width of the sail, along the hinge, m.
    pub sail_width_m: f64,
    /// Length of the chassis, from the hinge towards the Sun, m.
    pub base_length_m: f64,
    /// Width of the chassis, along the hinge, m.
    pub base_width_m: f64,
    /// Panel offset angle, degrees; a positive offset leans the sail away from the Sun.
    pub panel_offset_deg: f64,
}

/// Coefficients of the two-panel model, Lu (2024), eqs. 2-6.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coefficients {
    /// Weight of the sail's glossy lobe.
    pub c1: f64,
    /// Diffuse albedo of the sail's front.
    pub c2: f64,
    /// Diffuse light that leaks to the sail's back.
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

/// A polynomial m(1000 km) = Σ coefficients\[i\] φ^i, with φ the angle Sun-satellite-observer in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PhasePolynomial {
    /// Coefficients of φ⁰, φ¹, …
    pub coefficients: Vec<f64>,
    /// Smallest phase angle of the fit, degrees; for smaller phase angles this value is used.
    pub min_phase_deg: f64,
    /// Largest phase angle of the fit, degrees; for larger phase angles this value is used.
    pub max_phase_deg: f64,
}

/// Ranges of the geometry of the fitted points, each as [least, greatest], degrees; null if the angle is irrelevant.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GeometryRange {
    /// Latitude of the Sun above the chassis plane.
    #[serde(default)]
    pub sun_latitude_deg: Option<[f64; 2]>,
    /// Latitude of the observer above the chassis plane.
    #[serde(default)]
    pub observer_latitude_deg: Option<[f64; 2]>,
    /// Sun-satellite-observer angle.
    #[serde(default)]
    pub phase_angle_deg: Option<[f64; 2]>,
}

/// Origin of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Publication or author of the fit.
    pub source: String,
    /// Description of the measurements.
    pub data: String,
    /// Number of fitted points; null if not published.
    pub n_points: Option<u64>,
    /// Date of the fit or of its publication, for example `2026-11`.
    pub date: String,
    /// True if a better fit is expected.
    pub provisional: bool,
    /// Caveats.
    pub notes: Vec<String>,
}

impl ModelKind {
    /// Returns the name in files.
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
    /// Reads and validates one model; errors contain `origin` (a file name).
    ///
    /// # Errors
    /// The text is not JSON, a key is unknown, missing or does not fit the kind, the schema
    /// version differs, a value is out of range, or the covariance is invalid.
    pub fn from_json(text: &str, origin: &str) -> Result<Self, Error> {
        let file: Self =
            serde_json::from_str(text).map_err(|error| json_error(&error).in_file("model file", origin))?;
        file.validate(origin)?;
        Ok(file)
    }

    /// Returns the text of the file, indented.
    pub fn to_json(&self) -> String {
        // Serialising cannot fail: all keys are strings and all numbers of a validated file are finite.
        serde_json::to_string_pretty(self).unwrap_or_default()
    }

    /// Returns names and values of the fitted parameters, in the order of the covariance.
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

    /// Returns the band and the system of the magnitudes; `None` if one of them is unknown.
    pub fn band_and_system(&self) -> Option<(Band, MagSystem)> {
        Some((self.band.parse().ok()?, self.mag_system.parse().ok()?))
    }
}

impl ModelFile {
    /// Checks every value against its range and every key against the kind.
    ///
    /// # Errors
    /// The first one that is found.
    pub fn validate(&self, origin: &str) -> Result<(), Error> {
        let check = Check { origin };
        if self.schema != SCHEMA_VERSION {
            return Err(Error::invalid("schema", self.schema, SCHEMA_VERSION.to_string()).in_file("model file", origin));
        }
        check.name("name", &self.name)?;
        self.aliases.iter().try_for_each(|alias| check.name("aliases", alias))?;
        check.filled("title", &self.title)?;
        if self.band.parse::<Band>().is_err() {
            return Err(check.text("band", &self.band, "B V R I u g r i z y G J H K W1 W2"));
        }
        if self.mag_system.parse::<MagSystem>().is_err() {
            return Err(check.text("mag_system", &self.mag_system, "Vega or AB"));
        }
        check.range("size_m", self.size_m, 0.0, 200.0)?;
        if let Some(rms_mag) = self.rms_mag {
            check.range("rms_mag", rms_mag, 0.0, 5.0)?;
        }
        check.range("sigma_mag", self.sigma_mag, 0.01, 5.0)?;
        check.filled("sigma_origin", &self.sigma_origin)?;
        check.filled("provenance.source", &self.provenance.source)?;
        check.filled("provenance.data", &self.provenance.data)?;
        check.filled("provenance.date", &self.provenance.date)?;
        self.validate_keys(&check)?;
        if let Some(shape) = &self.shape {
            shape.validate(&check)?;
        }
        if let Some(coefficients) = &self.coefficients {
            coefficients.validate(&check)?;
        }
        if let Some(panels) = &self.panels {
            panels.validate(&check)?;
        }
        if let Some(covariance) = &self.covariance {
            check.covariance(covariance, self.parameters().len())?;
        }
        if let Some(phase) = &self.phase_function {
            phase.validate(&check)?;
        }
        if let Some(mean_mag) = self.mean_mag {
            check.range("mean_mag", mean_mag, -10.0, 30.0)?;
        }
        self.geometry_range.map_or(Ok(()), |range| range.validate(&check))
    }

    /// Checks that the keys that the kind requires are given, and no others.
    fn validate_keys(&self, check: &Check) -> Result<(), Error> {
        let two_panel = self.kind == ModelKind::TwoPanel;
        let panels = self.kind == ModelKind::Panels;
        let phase = self.kind == ModelKind::PhaseFunction;
        let mean = matches!(self.kind, ModelKind::Mean | ModelKind::Prior);
        let keys = [
            ("shape", self.shape.is_some(), two_panel),
            ("coefficients", self.coefficients.is_some(), two_panel),
            ("panels", self.panels.is_some(), panels),
            ("phase_function", self.phase_function.is_some(), phase),
            ("mean_mag", self.mean_mag.is_some(), mean),
        ];
        let key_error = |problem, key| {
            Error::format(format!("kind {} {problem} the key {key:?}", self.kind.name()))
                .in_file("model file", check.origin)
        };
        for (key, present, needed) in keys {
            match (present, needed) {
                (false, true) => return Err(key_error("requires", key)),
                (true, false) => return Err(key_error("does not use", key)),
                _ => {}
            }
        }
        if self.covariance.is_some() && !(two_panel || panels) {
            return Err(key_error("does not use", "covariance"));
        }
        Ok(())
    }
}

impl SatelliteShape {
    fn validate(&self, check: &Check) -> Result<(), Error> {
        check.range("shape.sail_length_m", self.sail_length_m, 0.01, 200.0)?;
        check.range("shape.sail_width_m", self.sail_width_m, 0.01, 200.0)?;
        check.range("shape.base_length_m", self.base_length_m, 0.01, 200.0)?;
        check.range("shape.base_width_m", self.base_width_m, 0.01, 200.0)?;
        check.range("shape.panel_offset_deg", self.panel_offset_deg, -60.0, 60.0)
    }
}

impl Coefficients {
    fn validate(&self, check: &Check) -> Result<(), Error> {
        let weights = [("c1", self.c1), ("c2", self.c2), ("c3", self.c3), ("c4", self.c4), ("c5", self.c5)];
        for (key, value) in weights {
            check.range(&format!("coefficients.{key}"), value, 0.0, 10.0)?;
        }
        for (key, value) in [("n_sail", self.n_sail), ("n_base", self.n_base)] {
            check.range(&format!("coefficients.{key}"), value, 0.0, 10_000.0)?;
        }
        Ok(())
    }
}

impl PhasePolynomial {
    fn validate(&self, check: &Check) -> Result<(), Error> {
        check.range("phase_function.coefficients (number)", self.coefficients.len() as f64, 1.0, 8.0)?;
        for (i, &value) in self.coefficients.iter().enumerate() {
            check.range(&format!("phase_function.coefficients[{i}]"), value, -100.0, 100.0)?;
        }
        check.range("phase_function.max_phase_deg", self.max_phase_deg, 0.0, 180.0)?;
        // The two ends must differ.
        let below = self.max_phase_deg - 1e-6;
        check.range("phase_function.min_phase_deg", self.min_phase_deg, 0.0, below)
    }
}

impl GeometryRange {
    fn validate(&self, check: &Check) -> Result<(), Error> {
        let ranges = [
            ("sun_latitude_deg", self.sun_latitude_deg, -90.0, 90.0),
            ("observer_latitude_deg", self.observer_latitude_deg, -90.0, 90.0),
            ("phase_angle_deg", self.phase_angle_deg, 0.0, 180.0),
        ];
        for (key, range, least, greatest) in ranges {
            if let Some([from, to]) = range {
                check.range(&format!("geometry_range.{key}[0]"), from, least, greatest)?;
                check.range(&format!("geometry_range.{key}[1]"), to, from, greatest)?;
            }
        }
        Ok(())
    }
}
