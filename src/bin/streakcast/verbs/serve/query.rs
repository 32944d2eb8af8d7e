//! Query parameters with types and ranges. They are used to parse queries and to generate the OpenAPI document.

use std::collections::BTreeMap;

use hifitime::Epoch;
use serde_json::{Value, json};
use streakcast::frames::{is_covered, parse_instant};

use super::problem::Problem;

/// Parameter of a query.
#[derive(Copy, Clone, Debug)]
pub struct Parameter {
    pub name: &'static str,
    pub kind: Kind,
    pub required: bool,
    /// Description in one sentence, including the default.
    pub about: &'static str,
}

/// Type and range of a parameter.
#[derive(Copy, Clone, Debug)]
pub enum Kind {
    /// Number in a closed range.
    Number { least: f64, greatest: f64, unit: &'static str },
    /// Integer in a closed range.
    Count { least: u64, greatest: u64 },
    /// Time in UTC such as 2024-08-14T00:30:00.000Z, in the years 1957 to 2099.
    Moment,
    /// Julian date, UTC.
    JulianDate,
    /// Date such as 2024-08-14.
    Date,
    /// Text with at most `longest` characters.
    Text { longest: usize },
    /// One of the listed words.
    Word(&'static [&'static str]),
}

pub const TRUTH: Kind = Kind::Word(&["true", "false", "True", "False"]);

/// Range of Julian dates: the years 1957 to 2099.
const JULIAN_DATES: (f64, f64) = (2_435_839.5, 2_488_069.5);
const MOMENT_PATTERN: &str =
    r"^(19[5-9][0-9]|20[0-9]{2})-[0-1][0-9]-[0-3][0-9]T[0-2][0-9]:[0-5][0-9]:[0-5][0-9](\.[0-9]{1,9})?Z$";
const DATE_PATTERN: &str = r"^(19[5-9][0-9]|20[0-9]{2})-[0-1][0-9]-[0-3][0-9]$";

pub const fn required(name: &'static str, kind: Kind, about: &'static str) -> Parameter {
    Parameter { name, kind, required: true, about }
}

pub const fn optional(name: &'static str, kind: Kind, about: &'static str) -> Parameter {
    Parameter { name, kind, required: false, about }
}

pub const fn number(least: f64, greatest: f64, unit: &'static str) -> Kind {
    Kind::Number { least, greatest, unit }
}

impl Kind {
    fn allowed(self) -> String {
        match self {
            Kind::Number { least, greatest, unit } => {
                let without = if unit.is_empty() { "" } else { ", as a number without the unit" };
                format!("{least} to {greatest}{unit}{without}")
            }
            Kind::Count { least, greatest } => format!("whole numbers from {least} to {greatest}"),
            Kind::Moment => "UTC as 2024-08-14T00:30:00.000Z, 1957 to 2099".to_owned(),
            Kind::JulianDate => {
                format!("a Julian date (UTC) from {} to {}", JULIAN_DATES.0, JULIAN_DATES.1)
            }
            Kind::Date => "a date like 2024-08-14".to_owned(),
            Kind::Text { longest } => format!("1 to {longest} characters"),
            Kind::Word(words) => words.join(", "),
        }
    }

    fn is_allowed(self, text: &str) -> bool {
        let in_range = |least: f64, greatest: f64| {
            // The Rust parser would also accept `inf` and `nan`.
            let is_plain = text.bytes().all(|byte| byte.is_ascii_digit() || b"+-.eE".contains(&byte));
            is_plain && text.parse().is_ok_and(|number: f64| (least..=greatest).contains(&number))
        };
        match self {
            Kind::Number { least, greatest, .. } => in_range(least, greatest),
            Kind::Count { least, greatest } => {
                text.len() < 20 && text.parse().is_ok_and(|count: u64| (least..=greatest).contains(&count))
            }
            Kind::Moment => moment(text).is_some(),
            Kind::JulianDate => in_range(JULIAN_DATES.0, JULIAN_DATES.1),
            Kind::Date => date(text).is_some(),
            Kind::Text { longest } => !text.is_empty() && text.chars().count() <= longest,
            Kind::Word(words) => words.contains(&text),
        }
    }

    /// Returns the JSON Schema of the type.
    pub fn schema(self) -> Value {
        match self {
            Kind::Number { least, greatest, .. } => json!({"type": "number", "minimum": least, "maximum": greatest}),
            Kind::Count { least, greatest } => json!({"type": "integer", "minimum": least, "maximum": greatest}),
            Kind::Moment => json!({"type": "string", "pattern": MOMENT_PATTERN, "example": "2024-08-14T00:30:00.000Z"}),
            Kind::JulianDate => json!({"type": "number", "minimum": JULIAN_DATES.0, "maximum": JULIAN_DATES.1}),
            Kind::Date => json!({"type": "string", "pattern": DATE_PATTERN, "example": "2024-08-14"}),
            Kind::Text { longest } => json!({"type": "string", "minLength": 1, "maxLength": longest}),
            Kind::Word(words) => json!({"type": "string", "enum": words}),
        }
    }
}

/// Returns a time given in UTC with a `Z` at its end, in the years 1957 to 2099.
pub fn moment(text: &str) -> Option<Epoch> {
    let epoch = text.ends_with('Z').then(|| parse_instant(text, None).ok()).flatten()?;
    is_covered(epoch).then_some(epoch)
}

/// Returns noon (UTC) of a date.
fn date(text: &str) -> Option<Epoch> {
    if text.len() == 10 { moment(&format!("{text}T12:00:00Z")) } else { None }
}

/// Parsed parameters of a request.
#[derive(Clone, Debug, Default)]
pub struct Query {
    values: BTreeMap<&'static str, String>,
}

impl Query {
    /// Parses a query string.
    pub fn read(query: &str, parameters: &[Parameter]) -> Result<Self, Problem> {
        let mut values = BTreeMap::new();
        for (name, value) in form_urlencoded::parse(query.as_bytes()) {
            let Some(parameter) = parameters.iter().find(|parameter| parameter.name == name) else {
                let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name).collect();
                let allowed = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                return Err(Problem::parameter("parameter", &name, &allowed));
            };
            if !parameter.kind.is_allowed(&value) {
                return Err(Problem::parameter(parameter.name, &value, &parameter.kind.allowed()));
            }
            if values.insert(parameter.name, value.into_owned()).is_some() {
                return Err(Problem::repeated(parameter.name));
            }
        }
        if let Some(missing) =
            parameters.iter().find(|parameter| parameter.required && !values.contains_key(parameter.name))
        {
            return Err(Problem::missing(missing.name, &missing.kind.allowed()));
        }
        Ok(Self { values })
    }

    pub fn text(&self, name: &str) -> Option<&str> {
        self.values.get(name).map(String::as_str)
    }

    pub fn number(&self, name: &str) -> Option<f64> {
        self.text(name)?.parse().ok()
    }

    pub fn count(&self, name: &str) -> Option<usize> {
        self.text(name)?.parse().ok()
    }

    pub fn truth(&self, name: &str) -> Option<bool> {
        self.text(name).map(|word| word.eq_ignore_ascii_case("true"))
    }

    pub fn moment(&self, name: &str) -> Option<Epoch> {
        moment(self.text(name)?)
    }

    /// Returns noon (UTC) of a date parameter.
    pub fn date(&self, name: &str) -> Option<Epoch> {
        date(self.text(name)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMETERS: &[Parameter] = &[
        required("dec_deg", number(-90.0, 90.0, " deg"), ""),
        optional("start_utc", Kind::Moment, ""),
        optional("night", Kind::Date, ""),
        optional("samples", Kind::Count { least: 0, greatest: 500 }, ""),
        optional("lit", TRUTH, ""),
        optional("name", Kind::Text { longest: 5 }, ""),
    ];

    #[test]
    fn valid_parameters_are_read() {
        let text = "dec_deg=-3e1&start_utc=2024-08-14T00%3A30%3A00.5Z&night=2024-08-13&samples=25&lit=True&name=%C3%A9t%C3%A9+1";
        let query = Query::read(text, PARAMETERS).unwrap();
        assert_eq!((query.number("dec_deg"), query.count("samples")), (Some(-30.0), Some(25)));
        assert_eq!((query.truth("lit"), query.text("name")), (Some(true), Some("été 1")));
        assert!(query.moment("start_utc").is_some() && query.date("night").is_some());
    }

    #[test]
    fn errors_name_the_parameter() {
        for (text, parameter) in [
            ("", "dec_deg"),
            ("dec_deg=91", "dec_deg"),
            ("dec_deg=nan", "dec_deg"),
            ("dec_deg=inf", "dec_deg"),
            ("dec_deg=1&dec_deg=2", "dec_deg"),
            ("dec_deg=1&x=2", "parameter"),
            ("dec_deg=1&start_utc=2024-08-14T00:30:00", "start_utc"),
            ("dec_deg=1&start_utc=1900-08-14T00:30:00Z", "start_utc"),
            ("dec_deg=1&start_utc=%00", "start_utc"),
            ("dec_deg=1&night=2024-02-30", "night"),
            ("dec_deg=1&night=2024-2-3", "night"),
            ("dec_deg=1&samples=501", "samples"),
            ("dec_deg=1&samples=-1", "samples"),
            ("dec_deg=1&lit=1", "lit"),
            ("dec_deg=1&name=", "name"),
            ("dec_deg=1&name=123456", "name"),
        ] {
            let problem = Query::read(text, PARAMETERS).unwrap_err();
            let document: Value = serde_json::from_str(&problem.document(None)).unwrap();
            assert_eq!((problem.status, document["parameter"].as_str()), (400, Some(parameter)), "{text}");
            assert!(document["detail"].as_str().unwrap().contains("allowed: "), "{text}");
        }
    }
}
