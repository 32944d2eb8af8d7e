//! The telescope and its field of view.

use std::path::Path;

use crate::images::{FieldOfView, Telescope};
use crate::passes::Field;

use super::choices::{FieldSetup, TelescopeSetup, is_file_name};
use super::document::Setup;
use super::error::SetupError;
use super::resolve::read_text;
use super::units::parse_angle_deg;

const FIELDS: &str = "--fov 3.5deg, --field FILE, or a telescope with --telescope";

impl Setup {
    /// The field of view: as said, else that of the telescope.
    ///
    /// # Errors
    /// None was said, two were, or it is no field.
    pub fn field_of_view(&self) -> Result<Field, SetupError> {
        match (&self.fov, &self.field) {
            (Some(_), Some(_)) => Err(SetupError::Both { first: "--fov", second: "--field" }),
            (Some(diameter), None) => Ok(Field::circle(parse_angle_deg("fov", &diameter.text())?.to_radians())?),
            (None, Some(FieldSetup::File(path))) => Ok(Field::from_json(&read_text("field", path)?)?),
            (None, Some(FieldSetup::Table(table))) => field_of_table(table),
            (None, None) => match self.telescope()? {
                Some(telescope) => field_of_telescope(&telescope),
                None => Err(SetupError::Missing { what: "field of view", allowed: FIELDS }),
            },
        }
    }

    /// The telescope, where one was said.
    ///
    /// # Errors
    /// It is not known, or its file is none.
    pub fn telescope(&self) -> Result<Option<Telescope>, SetupError> {
        Ok(match &self.telescope {
            None => None,
            Some(TelescopeSetup::Name(name)) if is_file_name(name) => {
                Some(Telescope::from_toml(&read_text("telescope", Path::new(name))?, name)?)
            }
            Some(TelescopeSetup::Name(name)) => Some(Telescope::by_name(name)?),
            Some(TelescopeSetup::Table(telescope)) => Some(telescope.as_ref().clone()),
        })
    }
}

/// A table of one shape by its own key, or of shapes as in a field file.
fn field_of_table(table: &toml::Table) -> Result<Field, SetupError> {
    let text = serde_json::to_string(table).unwrap_or_default();
    if table.contains_key("shapes") {
        return Ok(Field::from_json(&text)?);
    }
    if let Some(path) = table.get("file").and_then(toml::Value::as_str).filter(|_| table.len() == 1) {
        return Ok(Field::from_json(&read_text("field", Path::new(path))?)?);
    }
    Ok(Field::from_json(&format!("{{\"shapes\": [{text}]}}"))?)
}

fn field_of_telescope(telescope: &Telescope) -> Result<Field, SetupError> {
    Ok(match &telescope.field {
        FieldOfView::CircleDeg(diameter) => Field::circle(diameter.to_radians())?,
        FieldOfView::RectangleDeg([width, height]) => Field::rectangle_deg(*width, *height)?,
        FieldOfView::PolygonDeg(corners) => Field::polygon_deg(corners)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup(text: &str) -> Setup {
        Setup::from_toml(text, "t.toml").unwrap()
    }

    fn message<T: std::fmt::Debug>(answer: Result<T, SetupError>) -> String {
        answer.unwrap_err().to_string()
    }

    #[test]
    fn fields_by_diameter_table_and_telescope() {
        let area = |text: &str| setup(text).field_of_view().unwrap().area_deg2();
        assert!((area("fov = '2deg'") - std::f64::consts::PI).abs() < 1e-3);
        assert!((area("[field]\nrectangle_deg = [2.0, 1.0]") - 2.0).abs() < 1e-9);
        assert!(
            (area("[field]\nshapes = [{circle_deg = 2.0}, {circle_deg = 2.0, center_deg = [3.0, 0.0]}]") - 6.282).abs()
                < 2e-3
        );
        assert!((area("telescope = 'rubin'") - 9.62).abs() < 0.01);
        assert!((area("telescope = 'rubin'\nfov = '2deg'") - std::f64::consts::PI).abs() < 1e-3);
        assert!(message(setup("").field_of_view()).contains("no field of view; say --fov 3.5deg"));
        assert!(message(setup("fov = 3.5").field_of_view()).contains("has no unit"));
    }
}
