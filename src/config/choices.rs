//! What can be said by one word or by a table.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Value;

use crate::images::Telescope;
use crate::schedule::Policy;

/// One value or a list of them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum OneOrMany<T> {
    /// One.
    One(T),
    /// Several.
    Many(Vec<T>),
}

impl<T> OneOrMany<T> {
    /// All of them.
    pub fn as_slice(&self) -> &[T] {
        match self {
            OneOrMany::One(value) => std::slice::from_ref(value),
            OneOrMany::Many(values) => values,
        }
    }
}

/// A quantity as it was typed: a text, or a bare number that may lack its unit.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Quantity {
    /// As text.
    Text(String),
    /// As a number.
    Number(f64),
}

impl Quantity {
    /// What would have been typed.
    pub fn text(&self) -> String {
        match self {
            Quantity::Text(text) => text.clone(),
            Quantity::Number(number) => number.to_string(),
        }
    }
}

/// A site by name, or by what a table says.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "toml::Value")]
pub enum SiteSetup {
    /// A name of the bundled table.
    Name(String),
    /// A table `[site]`.
    Table(SiteTable),
}

/// A table `[site]`: a name of the bundled table, an MPC code, or coordinates (then the name is free).
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SiteTable {
    /// Name.
    pub name: Option<String>,
    /// MPC code.
    pub mpc: Option<String>,
    /// Geodetic latitude, degrees.
    pub latitude_deg: Option<f64>,
    /// Longitude, degrees, east positive.
    pub longitude_deg: Option<f64>,
    /// Height, metres.
    pub height_m: Option<f64>,
}

/// A field by file, or by what a table says.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "toml::Value")]
pub enum FieldSetup {
    /// A JSON file.
    File(PathBuf),
    /// A table `[field]` in the form of the JSON file, or one shape's own key.
    Table(toml::Table),
}

/// A telescope by name or file, or by what a table says.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "toml::Value")]
pub enum TelescopeSetup {
    /// A preset's name, or a TOML file; in a table `[telescope]` the one key `preset`.
    Name(String),
    /// A table `[telescope]` with all keys of a telescope file.
    Table(Box<Telescope>),
}

/// A policy by file, or by what a table says.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "toml::Value")]
pub enum PolicySetup {
    /// A TOML file.
    File(PathBuf),
    /// A table `[policy]`.
    Table(Policy),
}

/// A table `[models]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ModelsSetup {
    /// Model files, each put in place of the shipped model of its name.
    pub files: Vec<PathBuf>,
    /// A table of standard magnitudes, as the flag `--qs-mag`.
    pub qs_mag: Option<PathBuf>,
    /// By name of a generation (`starlink-v1.5`, `oneweb`, ...) the name of the model that it gets instead of its usual one.
    pub generations: BTreeMap<String, String>,
}

impl TelescopeSetup {
    pub(super) fn name_mut(&mut self) -> Option<&mut String> {
        match self {
            TelescopeSetup::Name(name) => Some(name),
            TelescopeSetup::Table(_) => None,
        }
    }
}

/// True for what names a TOML file rather than something known by name.
pub(super) fn is_file_name(name: &str) -> bool {
    name.ends_with(".toml")
}

/// A table's own type, with the table's own message where it is none (an untagged enum would only say that nothing matched).
fn table<T: DeserializeOwned>(value: Value) -> Result<T, String> {
    value.try_into().map_err(|error: toml::de::Error| error.message().to_owned())
}

impl TryFrom<Value> for SiteSetup {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        match value {
            Value::String(name) => Ok(SiteSetup::Name(name)),
            value => table(value).map(SiteSetup::Table),
        }
    }
}

impl TryFrom<Value> for FieldSetup {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        match value {
            Value::String(path) => Ok(FieldSetup::File(path.into())),
            value => table(value).map(FieldSetup::Table),
        }
    }
}

impl TryFrom<Value> for TelescopeSetup {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        match value {
            Value::String(name) => Ok(TelescopeSetup::Name(name)),
            Value::Table(keys) if keys.len() == 1 && keys.contains_key("preset") => {
                let name = keys.get("preset").and_then(Value::as_str).ok_or("preset needs a name")?;
                Ok(TelescopeSetup::Name(name.to_owned()))
            }
            value => table(value).map(|telescope| TelescopeSetup::Table(Box::new(telescope))),
        }
    }
}

impl TryFrom<Value> for PolicySetup {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        match value {
            Value::String(path) => Ok(PolicySetup::File(path.into())),
            value => table(value).map(PolicySetup::Table),
        }
    }
}
