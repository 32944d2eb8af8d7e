//! What is allowed in a model file: ranges of numbers, spellings of names, keys that belong to a kind.

use super::band::{Band, MagSystem};
use super::model_file::{
    Coefficients, GeometryRange, ModelFile, ModelFileError, ModelKind, PhasePolynomial, SCHEMA_VERSION, SatelliteShape,
};

impl ModelFile {
    /// Holds every value to its range and every key to the kind.
    ///
    /// # Errors
    /// The first [`ModelFileError`] that is found.
    pub fn validate(&self, origin: &str) -> Result<(), ModelFileError> {
        let check = Check { origin };
        if self.schema != SCHEMA_VERSION {
            return Err(ModelFileError::Schema { origin: origin.to_owned(), given: self.schema });
        }
        check.name("name", &self.name)?;
        self.aliases.iter().try_for_each(|alias| check.name("aliases", alias))?;
        check.filled("title", &self.title)?;
        if self.band.parse::<Band>().is_err() {
            return Err(check.text("band", &self.band, "B V R I u g r i z y G"));
        }
        if self.mag_system.parse::<MagSystem>().is_err() {
            return Err(check.text("mag_system", &self.mag_system, "Vega or AB"));
        }
        check.range("size_m", self.size_m, 0.0, 200.0)?;
        if let Some(rms_mag) = self.rms_mag {
            check.range("rms_mag", rms_mag, 0.0, 5.0)?;
        }
        check.range("sigma_mag", self.sigma_mag, 0.01, 5.0)?;
        check.range("sigma_outside_mag", self.sigma_outside_mag, self.sigma_mag, 5.0)?;
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

    /// Which optional keys the kind needs and which it has no use for.
    fn validate_keys(&self, check: &Check) -> Result<(), ModelFileError> {
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
        let key_error = |problem, key| ModelFileError::Key {
            origin: check.origin.to_owned(),
            kind: self.kind.name(),
            problem,
            key,
        };
        for (key, present, needed) in keys {
            match (present, needed) {
                (false, true) => return Err(key_error("needs", key)),
                (true, false) => return Err(key_error("has no use for", key)),
                _ => {}
            }
        }
        if self.covariance.is_some() && !(two_panel || panels) {
            return Err(key_error("has no use for", "covariance"));
        }
        Ok(())
    }
}

impl SatelliteShape {
    fn validate(&self, check: &Check) -> Result<(), ModelFileError> {
        check.range("shape.sail_length_m", self.sail_length_m, 0.01, 200.0)?;
        check.range("shape.sail_width_m", self.sail_width_m, 0.01, 200.0)?;
        check.range("shape.base_length_m", self.base_length_m, 0.01, 200.0)?;
        check.range("shape.base_width_m", self.base_width_m, 0.01, 200.0)?;
        check.range("shape.panel_offset_deg", self.panel_offset_deg, -60.0, 60.0)
    }
}

impl Coefficients {
    fn validate(&self, check: &Check) -> Result<(), ModelFileError> {
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
    fn validate(&self, check: &Check) -> Result<(), ModelFileError> {
        check.range("phase_function.coefficients (their number)", self.coefficients.len() as f64, 1.0, 8.0)?;
        for (i, &value) in self.coefficients.iter().enumerate() {
            check.range(&format!("phase_function.coefficients[{i}]"), value, -100.0, 100.0)?;
        }
        check.range("phase_function.max_phase_deg", self.max_phase_deg, 0.0, 180.0)?;
        // Written so that equal ends are refused too.
        let below = self.max_phase_deg - 1e-6;
        check.range("phase_function.min_phase_deg", self.min_phase_deg, 0.0, below)
    }
}

impl GeometryRange {
    fn validate(&self, check: &Check) -> Result<(), ModelFileError> {
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

/// Checks that know whose file they speak of.
pub(super) struct Check<'a> {
    origin: &'a str,
}

impl Check<'_> {
    pub(super) fn range(&self, key: &str, given: f64, least: f64, greatest: f64) -> Result<(), ModelFileError> {
        // Not a number is in no range.
        if (least..=greatest).contains(&given) {
            return Ok(());
        }
        Err(ModelFileError::OutOfRange { origin: self.origin.to_owned(), key: key.to_owned(), given, least, greatest })
    }

    /// How many of something there are.
    pub(super) fn count(&self, key: &str, given: usize, least: usize, greatest: usize) -> Result<(), ModelFileError> {
        self.range(&format!("{key}: number"), given as f64, least as f64, greatest as f64)
    }

    /// The error of a name that stands for nothing.
    pub(super) fn reference(&self, key: &str, given: &str, allowed: String) -> ModelFileError {
        ModelFileError::Reference {
            origin: self.origin.to_owned(),
            key: key.to_owned(),
            given: given.to_owned(),
            allowed,
        }
    }

    fn text(&self, key: &'static str, given: &str, allowed: &'static str) -> ModelFileError {
        ModelFileError::Text { origin: self.origin.to_owned(), key, given: given.to_owned(), allowed }
    }

    fn filled(&self, key: &'static str, given: &str) -> Result<(), ModelFileError> {
        if given.trim().is_empty() { Err(self.text(key, given, "any text that is not empty")) } else { Ok(()) }
    }

    fn name(&self, key: &'static str, given: &str) -> Result<(), ModelFileError> {
        let letter = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '.' || c == '-';
        if (1..=64).contains(&given.len()) && given.chars().all(letter) {
            return Ok(());
        }
        Err(self.text(key, given, "1 to 64 lower-case letters, digits, '.' and '-'"))
    }

    fn covariance(&self, matrix: &[Vec<f64>], size: usize) -> Result<(), ModelFileError> {
        let error = |problem: String| ModelFileError::Covariance { origin: self.origin.to_owned(), size, problem };
        if matrix.len() != size {
            return Err(error(format!("it has {} rows", matrix.len())));
        }
        if let Some((i, row)) = matrix.iter().enumerate().find(|(_, row)| row.len() != size) {
            return Err(error(format!("row {i} has {} columns", row.len())));
        }
        for (i, row) in matrix.iter().enumerate() {
            for (j, (&value, mirrored)) in row.iter().zip(matrix.iter().map(|row| row[i])).enumerate() {
                if !value.is_finite() || (i == j && value < 0.0) {
                    return Err(error(format!("element [{i}][{j}] is {value}")));
                }
                if (value - mirrored).abs() > 1e-9 * value.abs().max(mirrored.abs()) {
                    return Err(error(format!("element [{i}][{j}] is {value}, [{j}][{i}] is {mirrored}")));
                }
            }
        }
        Ok(())
    }
}
