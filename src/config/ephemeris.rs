//! Configuration of an ephemeris request.

use std::path::PathBuf;

use hifitime::Epoch;
use serde::Deserialize;

use super::document::Config;
use super::error::request;
use super::forecast::SelectionConfig;
use super::inputs::read_text;
use super::required::TIMES;
use super::values::parse_duration_s;
use crate::error::Error;
use crate::forecast::EphemerisRequest;
use crate::frames::{parse_moment, seconds_after, seconds_between};

/// Largest number of times of one request.
const MOST_TIMES: usize = 1_000_000;

/// Times and satellites of an ephemeris, in addition to [`Config`].
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct EphemerisConfig {
    /// Satellites.
    #[serde(flatten)]
    #[cfg_attr(feature = "cli", command(flatten))]
    pub selection: SelectionConfig,
    /// Times, for example 2024-08-14T23:30:00Z
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "TIME",
            num_args = 1..,
            value_delimiter = ',',
            conflicts_with_all = ["times_file", "start", "end", "step"]
        )
    )]
    pub times: Vec<String>,
    /// File of times, one a line; lines that begin with # are omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", conflicts_with_all = ["start", "end", "step"]))]
    pub times_file: Option<PathBuf>,
    /// First time
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true))]
    pub start: Option<String>,
    /// Last time, included if it is a whole number of steps after the first
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true))]
    pub end: Option<String>,
    /// Time between two rows with its unit, for example 10s or 1min
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME"))]
    pub step: Option<String>,
    /// Only positions at or above this altitude, degrees; all if omitted, also below the horizon
    #[cfg_attr(feature = "cli", arg(long, value_name = "DEG", allow_hyphen_values = true))]
    pub min_altitude: Option<f64>,
}

impl EphemerisConfig {
    /// Checks the values and converts them to a request.
    ///
    /// # Errors
    /// A generation is unknown, times are missing or invalid or more than a million, or the altitude is out of range.
    pub fn resolve(&self, config: &Config) -> Result<EphemerisRequest, Error> {
        let selection = self.selection.resolve()?;
        if let Some(altitude) = self.min_altitude.filter(|altitude| !(-90.0..=90.0).contains(altitude)) {
            return Err(Error::invalid("--min-altitude", format_args!("{altitude} deg"), "-90 to 90 deg"));
        }
        Ok(EphemerisRequest {
            times: self.epochs(config)?,
            selection,
            min_altitude_rad: self.min_altitude.map(f64::to_radians),
            photometry: config.photometry()?,
        })
    }

    fn epochs(&self, config: &Config) -> Result<Vec<Epoch>, Error> {
        let scale = config.time_scale()?;
        let epochs: Vec<Epoch> = match (&self.times_file, &self.start, &self.end, &self.step) {
            (None, None, None, None) => {
                self.times.iter().map(|text| parse_moment(text, scale)).collect::<Result<_, _>>()?
            }
            (Some(path), None, None, None) if self.times.is_empty() => {
                let text = read_text("times", path)?;
                let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
                let read = |(number, line): (usize, &str)| {
                    parse_moment(line, scale).map_err(|error| error.in_line("times", path, number))
                };
                let is_time = |(_, line): &(usize, &str)| !line.is_empty() && !line.starts_with('#');
                lines.filter(is_time).map(read).collect::<Result<_, _>>()?
            }
            (None, Some(start), Some(end), Some(step)) if self.times.is_empty() => {
                let (first, last) = (parse_moment(start, scale)?, parse_moment(end, scale)?);
                steps(first, last, parse_duration_s("step", step)?)?
            }
            _ => Vec::new(),
        };
        if epochs.is_empty() {
            return Err(TIMES.missing());
        }
        Ok(epochs)
    }
}

/// Returns the times from `first` to `last` in steps of `step_s` seconds.
fn steps(first: Epoch, last: Epoch, step_s: f64) -> Result<Vec<Epoch>, Error> {
    let span_s = seconds_between(first, last);
    if span_s < 0.0 {
        return Err(Error::invalid("--end", format_args!("{:.3} s before --start", -span_s), "not before --start"));
    }
    if step_s <= 0.0 {
        return Err(Error::invalid("--step", "0 s", "above 0 s"));
    }
    // The tolerance includes the last time in spite of rounding.
    let count = (span_s / step_s + 1e-6).floor() + 1.0;
    if count > MOST_TIMES as f64 {
        let message = format!("--step is {step_s} s, which gives {count:.0} times; allowed: at most {MOST_TIMES}");
        return Err(request(message));
    }
    Ok((0..count as usize).map(|number| seconds_after(first, step_s * number as f64)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolve(json: &str) -> Result<EphemerisRequest, Error> {
        let config = Config::from_toml("shells = 'oneweb'\nmpc = 'X05'", "t.toml").unwrap();
        serde_json::from_str::<EphemerisConfig>(json).unwrap().resolve(&config)
    }

    #[test]
    fn times_of_steps_and_lists() {
        let span = r#""start": "2026-08-14T00:00:00Z", "end": "2026-08-14T00:00:01Z""#;
        let times = |step: &str| resolve(&format!(r#"{{{span}, "step": "{step}"}}"#)).unwrap().times;
        assert_eq!((times("0.1s").len(), times("0.3s").len(), times("2s").len()), (11, 4, 1));
        assert_eq!(seconds_between(times("0.1s")[0], times("0.1s")[10]), 1.0);
        let listed = resolve(r#"{"times": ["2026-08-14T00:00:05Z", "2026-08-14T00:00:00Z"]}"#).unwrap().times;
        assert_eq!(seconds_between(listed[1], listed[0]), 5.0);
    }

    #[test]
    fn errors_name_what_is_allowed() {
        let span = r#""start": "2026-08-14T00:00:00Z", "end": "2026-08-15T00:00:00Z""#;
        for (json, part) in [
            ("{}".to_owned(), "missing times; specify --times"),
            (format!("{{{span}}}"), "missing times"),
            (format!(r#"{{{span}, "step": "0s"}}"#), "allowed: above 0 s"),
            (format!(r#"{{{span}, "step": "10"}}"#), "10"),
            (format!(r#"{{{span}, "step": "0.01s"}}"#), "which gives 8640001 times; allowed: at most 1000000"),
            (r#"{"times": ["2026-08-14"], "min_altitude": 91}"#.to_owned(), "allowed: -90 to 90 deg"),
            (r#"{"times": ["yesterday"]}"#.to_owned(), "yesterday"),
            (r#"{"times": ["2026-08-14T00:00:00Z"], "generation": ["x"]}"#.to_owned(), "unknown generation 'x'"),
            (r#"{"times_file": "no-such"}"#.to_owned(), "no-such"),
        ] {
            let message = resolve(&json).unwrap_err().to_string();
            assert!(message.contains(part), "{json}: {message}");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("times.txt");
        std::fs::write(&path, "\u{feff}# times\n2026-08-14T00:00:00Z\n\nnever\n").unwrap();
        let message = resolve(&format!(r#"{{"times_file": "{}"}}"#, path.display())).unwrap_err().to_string();
        assert!(message.contains("times.txt, line 4: "), "{message}");
    }
}
