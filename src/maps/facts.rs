//! What a map rests on, said once for tables, FITS headers and pictures.

use crate::output::Provenance;

/// One statement about a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact {
    /// In the provenance of a table, snake_case with the unit last.
    pub name: &'static str,
    /// In a FITS header.
    pub keyword: &'static str,
    /// What is stated.
    pub value: FactValue,
    /// For the comment of a FITS header.
    pub comment: &'static str,
}

/// Text or a number.
#[derive(Clone, Debug, PartialEq)]
pub enum FactValue {
    /// Text.
    Text(String),
    /// A number in the unit of the name.
    Real(f64),
}

impl FactValue {
    pub(super) fn text(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl Fact {
    pub(super) fn new(name: &'static str, keyword: &'static str, value: FactValue, comment: &'static str) -> Self {
        Self { name, keyword, value, comment }
    }

    /// Adds it to what an output states.
    pub fn state(&self, provenance: &mut Provenance) {
        match &self.value {
            FactValue::Text(text) => provenance.state(self.name, text.as_str()),
            FactValue::Real(number) => provenance.state(self.name, *number),
        }
    }
}

/// Without the rounding of a turn from degrees to radians and back.
pub(super) fn rounded(number: f64) -> f64 {
    (number * 1e9).round() / 1e9
}
