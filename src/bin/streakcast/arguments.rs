//! Flags that several verbs share in addition to those of [`Config`].

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use streakcast::config::Config;

use crate::output::Output;

/// Largest offset of a local clock from UTC, hours.
const MAX_UTC_OFFSET_H: f64 = 14.0;

/// Format and file of the output.
#[derive(Args)]
pub struct OutputArguments {
    /// Output format: table (default on a terminal), csv (default elsewhere), ecsv, json, jsonl, votable; optional
    /// parquet
    #[arg(long, value_name = "FORMAT", help_heading = "Output")]
    pub format: Option<String>,
    /// Output file; standard output if omitted
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
}

impl OutputArguments {
    /// Opens the output in the given format; if none is given, in that of the configuration.
    pub fn open(self, config: &Config) -> anyhow::Result<Output> {
        Output::new(self.format.as_deref().or(config.format.as_deref()), self.output)
    }
}

/// Rejects camera flags for a result that does not depend on a camera. `subject` names the result in the error.
pub fn reject_camera(flags: &Config, subject: &str) -> anyhow::Result<()> {
    let given = [
        ("--fov", flags.fov.is_some()),
        ("--field", flags.field.is_some()),
        ("--rotation", flags.rotation.is_some()),
        ("--telescope", flags.telescope.is_some()),
        ("--min-probability", flags.min_probability.is_some()),
    ];
    match given.iter().find(|(_, is_given)| *is_given) {
        Some((flag, _)) => Err(anyhow!("{flag} has no effect on {subject}; allowed: the command without it")),
        None => Ok(()),
    }
}

/// Parses an offset from UTC, hours ahead: `+01:00`, `-4:30`, `+5`, `5.75`, `Z`.
pub fn utc_offset_h(text: &str) -> Result<f64, String> {
    let hours = if text.eq_ignore_ascii_case("z") { Some(0.0) } else { signed_hours(text) };
    hours.filter(|hours| (-MAX_UTC_OFFSET_H..=MAX_UTC_OFFSET_H).contains(hours)).ok_or_else(|| {
        "not an offset from UTC; allowed: hours ahead of UTC from -14:00 to +14:00, for example +01:00 or -4.5"
            .to_owned()
    })
}

fn signed_hours(text: &str) -> Option<f64> {
    let (sign, rest) = match (text.strip_prefix('+'), text.strip_prefix(['-', '\u{2212}'])) {
        (Some(rest), _) => (1.0, rest),
        (_, Some(rest)) => (-1.0, rest),
        _ => (1.0, text),
    };
    let (hours, minutes) = rest.split_once(':').unwrap_or((rest, "0"));
    let whole = |text: &str| text.parse::<u8>().ok().filter(|_| text.bytes().all(|byte| byte.is_ascii_digit()));
    if let Some(hours) = whole(hours) {
        return Some(sign * (f64::from(hours) + f64::from(whole(minutes).filter(|minutes| *minutes < 60)?) / 60.0));
    }
    // A number with a decimal point has no minutes part.
    let is_decimal = rest.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    rest.parse::<f64>().ok().filter(|_| is_decimal).map(|hours| sign * hours)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_of_clocks() {
        for (text, hours) in [
            ("+01:00", 1.0),
            ("-4", -4.0),
            ("5:45", 5.75),
            ("Z", 0.0),
            ("-03:30", -3.5),
            ("+14:00", 14.0),
            ("-4.5", -4.5),
        ] {
            assert_eq!(utc_offset_h(text), Ok(hours), "{text}");
        }
        for text in ["", "+", "CET", "+15:00", "+1:60", "1:2:3", "+-1", "1.5:30", "inf", "1e0", "14.1"] {
            assert!(utc_offset_h(text).is_err(), "{text}");
        }
    }
}
