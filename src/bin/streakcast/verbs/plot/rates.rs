//! What both maps of streaks an exposure have in common: over a site's sky, and among the stars.

use anyhow::anyhow;
use serde_json::Value;
use streakcast::output::Column;

use super::columns::Columns;

pub const STREAKS: Column =
    Column::real("streaks_per_exposure", "", 5, "Mean number of lit satellites that cross an exposure.");
pub const BRIGHT: Column =
    Column::real("bright_per_exposure", "", 5, "The same of those brighter than the limit; empty without one.");

/// A table of either, read.
pub struct Rates {
    pub nside: u32,
    pub cells: Vec<u64>,
    /// Of bright ones alone where a limit was said.
    pub rate: Vec<f64>,
    /// ` brighter than 7 mag`, or nothing.
    pub bright: String,
    pub site: String,
    options: Value,
}

impl Rates {
    /// `allowed` is what writes such tables.
    pub fn of(columns: &Columns, allowed: &str) -> anyhow::Result<Self> {
        let options = columns.stated("options").cloned().unwrap_or_default();
        let number = |name: &str| options.get(name).and_then(Value::as_f64);
        let nside = number("nside").ok_or_else(|| lacking("nside", allowed))? as u32;
        let limit = number("limit_mag");
        let name = columns.stated("site").and_then(|site| site.get("name")).and_then(Value::as_str);
        Ok(Self {
            nside,
            cells: columns.numbers("healpix_cell")?.into_iter().map(|cell| cell as u64).collect(),
            rate: columns.numbers(if limit.is_some() { BRIGHT.name } else { STREAKS.name })?,
            bright: limit.map(|limit| format!(" brighter than {limit} mag")).unwrap_or_default(),
            site: name.unwrap_or_default().to_owned(),
            options,
        })
    }

    /// What the table says of how it was made.
    pub fn option(&self, name: &str) -> Option<&Value> {
        self.options.get(name)
    }

    /// The same of a number; not a number where it is not said.
    pub fn number(&self, name: &str) -> f64 {
        self.option(name).and_then(Value::as_f64).unwrap_or(f64::NAN)
    }

    /// An angle with a true minus sign, degrees; nothing where it is not said.
    pub fn angle(&self, name: &str, decimals: Option<usize>) -> String {
        let Some(angle) = self.option(name).and_then(Value::as_f64) else { return String::new() };
        let text = decimals.map_or_else(|| angle.to_string(), |decimals| format!("{angle:.decimals$}"));
        text.replace('-', "−")
    }
}

/// A table that does not say what a picture needs.
pub fn lacking(what: &str, allowed: &str) -> anyhow::Error {
    anyhow!("this table does not say its {what}; allowed: the data of {allowed}")
}
