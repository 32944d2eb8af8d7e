//! Tables with access by column name, from a result or from a file that a verb has written.

use std::path::Path;

use anyhow::{anyhow, bail};
use serde_json::{Map, Value};
use streakcast::config::Config;
use streakcast::frames::mjd_utc;
use streakcast::frames::parse_moment;
use streakcast::geometry::Site;
use streakcast::input::{TableRow, TableRows, json_error};
use streakcast::output::{Provenance, Table, Value as Cell, format_utc};

/// Table with cells as text, as in CSV. Missing values are empty.
pub struct Columns {
    origin: String,
    names: Vec<String>,
    /// Rows: line number in the file (or row number), for messages, and cells.
    rows: Vec<(usize, Vec<String>)>,
    provenance: Map<String, Value>,
}

impl Columns {
    /// Returns a result as columns.
    pub fn from_table(table: &Table, provenance: &Provenance) -> Self {
        let cells = |row: &Vec<Cell>| table.columns.iter().zip(row).map(|(column, cell)| column.text(cell)).collect();
        Self {
            origin: "the result".to_owned(),
            names: table.columns.iter().map(|column| column.name.to_owned()).collect(),
            rows: table.rows.iter().enumerate().map(|(index, row)| (index + 1, cells(row))).collect(),
            provenance: provenance.entries().map(|(name, value)| (name.to_owned(), value.clone())).collect(),
        }
    }

    /// Reads a CSV, ECSV or JSON file. In a JSON document, the array `section` is the table.
    pub fn read(path: &Path, section: &str) -> anyhow::Result<Self> {
        Self::read_first(path, &[section])
    }

    /// Same as [`Columns::read`], but in a JSON document the first of `sections` that it contains is the table.
    pub fn read_first(path: &Path, sections: &[&str]) -> anyhow::Result<Self> {
        let origin = path.display().to_string();
        let text = streakcast::input::read_to_string(path).map_err(|error| anyhow!("table {origin}: {error}"))?;
        let columns = match text.trim_start().chars().next() {
            Some('{' | '[') => Self::from_json(&origin, &text, sections)?,
            Some(_) => Self::from_csv(&origin, text)?,
            None => bail!("table {origin} is empty; allowed: CSV, ECSV or JSON"),
        };
        Ok(columns)
    }

    fn from_csv(origin: &str, text: String) -> anyhow::Result<Self> {
        let mut provenance = Map::new();
        for line in text.lines().filter_map(|line| line.strip_prefix("# ")) {
            if let Some((name, value)) = line.split_once(": ")
                && let Ok(value) = serde_json::from_str::<Value>(value)
            {
                match (name, value) {
                    ("meta", Value::Object(mut meta)) => {
                        provenance.extend(meta.remove("provenance").and_then(object).unwrap_or_default());
                    }
                    (name, value) => drop(provenance.insert(name.to_owned(), value)),
                }
            }
        }
        let failed = |error: std::io::Error| anyhow!("table {origin}: {error}");
        let table = TableRows::new(text).map_err(failed)?;
        let names = table.names().to_vec();
        let row = |row: TableRow| (row.line as usize, row.cells().map(str::to_owned).collect());
        let rows = table.map(|read| read.map(row)).collect::<Result<_, _>>().map_err(failed)?;
        Ok(Self { origin: origin.to_owned(), names, rows, provenance })
    }

    fn from_json(origin: &str, text: &str, sections: &[&str]) -> anyhow::Result<Self> {
        let read = serde_json::Deserializer::from_str(text).into_iter::<Value>().collect::<Result<Vec<_>, _>>();
        let mut values = read.map_err(|error| anyhow!("table {origin} is not JSON: {}", json_error(&error)))?;
        let allowed = sections.join("' or '");
        // The first line of JSON lines is the provenance; each other line is a row.
        let first = values.first().and_then(Value::as_object);
        let is_about = first.is_some_and(|first| first.len() == 1 && first.contains_key("provenance"));
        let (mut document, rows) = if values.len() == 1 && !is_about {
            match values.remove(0) {
                Value::Array(rows) => (Map::new(), rows),
                Value::Object(mut document) => match sections.iter().find_map(|section| document.remove(*section)) {
                    Some(Value::Array(rows)) => (document, rows),
                    _ => bail!("table {origin} has no such array; allowed: an array '{allowed}'"),
                },
                _ => bail!(
                    "table {origin} is neither an object nor an array; allowed: an object with an array '{allowed}', or an array of objects"
                ),
            }
        } else {
            let about = if is_about { object(values.remove(0)).unwrap_or_default() } else { Map::new() };
            (about, values)
        };
        let mut names: Vec<String> = Vec::new();
        for key in rows.iter().filter_map(Value::as_object).flat_map(Map::keys) {
            if !names.contains(key) {
                names.push(key.clone());
            }
        }
        let cell = |row: &Value, name: &String| match row.get(name) {
            None | Some(Value::Null) => String::new(),
            Some(Value::String(text)) => text.clone(),
            Some(other) => other.to_string(),
        };
        let rows = rows.iter().enumerate();
        let rows = rows.map(|(index, row)| (index + 1, names.iter().map(|name| cell(row, name)).collect())).collect();
        let provenance = document.remove("provenance").and_then(object).unwrap_or_default();
        Ok(Self { origin: origin.to_owned(), names, rows, provenance })
    }

    /// Returns the name of the table for messages.
    pub fn origin(&self) -> &str {
        &self.origin
    }

    pub fn len(&self) -> usize {
        self.rows.len()
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    pub fn has(&self, name: &str) -> bool {
        self.names.iter().any(|known| known == name)
    }

    /// Returns a value of the provenance; `None` if it is missing.
    pub fn stated(&self, name: &str) -> Option<&Value> {
        self.provenance.get(name)
    }

    /// Returns the sentence for a caption that some satellites are simulated; empty if all are real.
    pub fn simulation_note(&self) -> &'static str {
        let shells = self.stated("shells").and_then(Value::as_array);
        match (shells.is_some_and(|shells| !shells.is_empty()), self.stated("elements").is_some()) {
            (true, true) => " Satellites of shells are simulated.",
            (true, false) => " All satellites are simulated.",
            (false, _) => "",
        }
    }

    /// Returns the site of the configuration, or else that of the table, which has precedence over the home file.
    pub fn site_with(&self, config: &Config, site: Option<Site>) -> Option<Site> {
        match self.site() {
            Some(of_table) if config.takes_site_of_frame() => Some(of_table),
            of_table => site.or(of_table),
        }
    }

    /// Returns the configuration without the time zone of the home file if the site is that of the table.
    pub fn time_zone_with(&self, config: Config) -> Config {
        let is_of_table = self.site().is_some() && config.takes_site_of_frame();
        let is_home = is_of_table && config.home.gives_time_zone;
        Config { time_zone: config.time_zone.clone().filter(|_| !is_home), ..config }
    }

    /// Returns the site in the provenance.
    pub fn site(&self) -> Option<Site> {
        let site = self.stated("site")?;
        let number = |name: &str| site.get(name).and_then(Value::as_f64);
        let name = site.get("name").and_then(Value::as_str).unwrap_or_default();
        Site::new_deg(name, number("latitude_deg")?, number("longitude_deg")?, number("height_m")?).ok()
    }

    /// Returns the name of the site or of the telescope in orbit; `None` if the provenance has no observer.
    pub fn observer_name(&self) -> Option<String> {
        let name = |what: &str| self.stated(what)?.get("name")?.as_str().map(str::to_owned);
        self.site().map(|site| site.name).or_else(|| name("observer"))
    }

    /// Returns the subtitle of a picture: observer, and the range of times (MJD, UTC; NaN is ignored).
    pub fn place_and_time(&self, moments: impl IntoIterator<Item = f64>) -> String {
        place_and_time(self.observer_name(), moments)
    }

    /// Returns the limiting magnitude in the options of the table or in its policy; `None` if it depends on the band or
    /// is missing.
    pub fn limit_mag(&self) -> Option<f64> {
        let options = self.stated("options")?;
        options.get("policy").unwrap_or(options).get("limit_mag")?.as_f64()
    }

    /// Returns the whole provenance.
    pub fn provenance(&self) -> Provenance {
        let mut provenance = Provenance::new();
        self.provenance.iter().for_each(|(name, value)| provenance.state(name, value.clone()));
        provenance
    }

    /// Returns the cells of a column.
    pub fn texts(&self, name: &str) -> anyhow::Result<Vec<&str>> {
        // JSON without rows has no names of columns.
        if self.rows.is_empty() && self.names.is_empty() {
            return Ok(Vec::new());
        }
        let index = self.names.iter().position(|known| known == name).ok_or_else(|| {
            anyhow!("missing column {name} in the table {}, which has {}", self.origin, self.names.join(", "))
        })?;
        Ok(self.rows.iter().map(|(_, row)| row.get(index).map_or("", String::as_str)).collect())
    }

    /// Returns the numbers of a column; NaN for an empty cell.
    pub fn numbers(&self, name: &str) -> anyhow::Result<Vec<f64>> {
        self.each(name, "a number", |text| match text {
            "" => Some(f64::NAN),
            "true" | "True" => Some(1.0),
            "false" | "False" => Some(0.0),
            text => text.parse().ok(),
        })
    }

    /// Returns the numbers of a column; NaN for an empty cell, and for all rows if the table lacks the column.
    pub fn numbers_or_nan(&self, name: &str) -> anyhow::Result<Vec<f64>> {
        if self.has(name) { self.numbers(name) } else { Ok(vec![f64::NAN; self.len()]) }
    }

    /// Returns false for rows whose geometry is outside that of the fitted measurements; empty if the table does not
    /// state it. Rows without a magnitude have no statement and count as true.
    pub fn fitted(&self) -> anyhow::Result<Vec<bool>> {
        const NAME: &str = "in_fitted_range";
        if !self.has(NAME) {
            return Ok(Vec::new());
        }
        self.numbers(NAME).map(|marks| marks.into_iter().map(|mark| mark != 0.0).collect())
    }

    /// Returns the times of a column, MJD (UTC); NaN for an empty cell.
    pub fn moments(&self, name: &str) -> anyhow::Result<Vec<f64>> {
        self.each(name, "a time like 2024-08-14T00:30:00.000Z", |text| match text {
            "" => Some(f64::NAN),
            text => parse_moment(text, None).ok().map(mjd_utc),
        })
    }

    fn each(&self, name: &str, allowed: &str, meaning: impl Fn(&str) -> Option<f64>) -> anyhow::Result<Vec<f64>> {
        let values = self.texts(name)?.into_iter().zip(&self.rows).map(|(text, (line, _))| {
            meaning(text).ok_or_else(|| {
                anyhow!(
                    "table {}, line {line}: invalid {name} '{text}'; allowed: {allowed}, or an empty cell",
                    self.origin
                )
            })
        });
        values.collect()
    }
}

/// Joins the name of an observer and a range of times (MJD, UTC; NaN is ignored), either of which may be missing.
pub fn place_and_time(observer: Option<String>, moments: impl IntoIterator<Item = f64>) -> String {
    let (first, last) = moments
        .into_iter()
        .filter(|mjd| mjd.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), mjd| (first.min(mjd), last.max(mjd)));
    let text = |mjd: f64| format_utc(hifitime::Epoch::from_mjd_utc(mjd), 0).trim_end_matches('Z').replace('T', " ");
    let time = (first <= last).then(|| {
        let (first, last) = (text(first), text(last));
        match first.split_once(' ').zip(last.split_once(' ')) {
            _ if first == last => format!("{first} UTC"),
            Some(((day, _), (other, clock))) if day == other => format!("{first} to {clock} UTC"),
            _ => format!("{first} to {last} UTC"),
        }
    });
    observer.into_iter().chain(time).collect::<Vec<_>>().join(", ")
}

fn object(value: Value) -> Option<Map<String, Value>> {
    if let Value::Object(object) = value { Some(object) } else { None }
}
