//! Configuration of a forecast request.

use std::collections::BTreeSet;

use hifitime::Epoch;
use serde::Deserialize;

use super::document::Config;
#[cfg(feature = "cli")]
use super::document::norad_id;
use super::error::request;
use crate::constants::DAY_S;
use crate::elements::Generation;
use crate::error::Error;
use crate::forecast::{ForecastRequest, PassOrder, Selection};
use crate::frames::{parse_instant, parse_moment, seconds_between};
use crate::output::format_utc;
use crate::photometry::clear_sky_extinction_mag;
use crate::schedule::night_of;

/// Longest time range of one request, days.
const LONGEST_DAYS: f64 = 31.0;

/// Satellites of a request; all if nothing is given.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct SelectionConfig {
    /// Only satellites with these NORAD catalogue numbers
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "ID", num_args = 1.., value_delimiter = ',', value_parser = norad_id)
    )]
    pub norad: Vec<u32>,
    /// Only satellites with one of these names (ISS,HST) or words in their names, in upper or lower case
    #[cfg_attr(feature = "cli", arg(long, value_name = "TEXT", num_args = 1.., value_delimiter = ','))]
    pub name: Vec<String>,
    /// Only satellites of these generations, for example starlink-v2mini,oneweb
    #[cfg_attr(feature = "cli", arg(long, value_name = "KIND", num_args = 1.., value_delimiter = ','))]
    pub generation: Vec<String>,
}

impl SelectionConfig {
    /// Returns true if any satellites are selected.
    pub fn is_given(&self) -> bool {
        *self != Self::default()
    }

    /// Returns the selection of satellites by generation, name, or catalogue number.
    ///
    /// # Errors
    /// A generation is unknown.
    pub fn resolve(&self) -> Result<Selection, Error> {
        let kind = |name: &String| {
            Generation::by_name(name).ok_or_else(|| {
                let known = Generation::ALL.map(Generation::name).join(", ");
                request(format!("unknown generation '{name}'")).allowing(known)
            })
        };
        Ok(Selection {
            generations: self.generation.iter().map(kind).collect::<Result<_, _>>()?,
            names: self.name.clone(),
            norad_ids: self.norad.clone(),
        })
    }
}

/// Time range of a request: a night, or start and end. The default `tonight` is that of the command line; the library
/// has none.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct TimeRangeConfig {
    /// Night that begins on this evening, local date of the site, for example 2024-08-14; tonight if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "DATE", value_parser = parse_night, conflicts_with_all = ["start", "end"]))]
    pub night: Option<String>,
    /// Start of the time range (of windows: earliest shutter opening), for example 2024-08-14T23:30:00Z
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true, requires = "end"))]
    pub start: Option<String>,
    /// End of the time range, at most 31 days later (of windows: latest shutter closing)
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true, requires = "start"))]
    pub end: Option<String>,
}

impl TimeRangeConfig {
    /// Sets the night if neither it nor a start is given.
    pub fn or_night(self, night: &str) -> Self {
        let night = self.night.or_else(|| self.start.is_none().then(|| night.to_owned()));
        Self { night, ..self }
    }

    /// Returns start and end, by [`time_range`].
    ///
    /// # Errors
    /// Same as [`time_range`].
    pub fn resolve(&self, config: &Config) -> Result<(Epoch, Epoch), Error> {
        time_range(self.night.as_deref(), self.start.as_deref(), self.end.as_deref(), config)
    }
}

/// Time range and filters of a forecast, in addition to [`Config`]. Omitted keys have the defaults of the command line.
///
/// ```
/// let forecast: streakcast::config::ForecastConfig =
///     serde_json::from_str(r#"{"night": "2024-08-14", "max_mag": 5}"#)?;
/// assert_eq!((forecast.min_altitude, forecast.sun_altitude_deg), (10.0, Some(-6.0)));
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct ForecastConfig {
    /// Night, or start and end.
    #[serde(flatten)]
    #[cfg_attr(feature = "cli", command(flatten))]
    pub range: TimeRangeConfig,
    /// Only passes that are probably brighter than this, in the band of --band
    #[cfg_attr(feature = "cli", arg(long, value_name = "MAG", allow_hyphen_values = true, help_heading = "Filters"))]
    pub max_mag: Option<f64>,
    /// With --max-mag: smallest probability of being brighter, 0 to 1; with 0 all passes are listed
    #[cfg_attr(feature = "cli", arg(long, value_name = "P", default_value_t = 0.5, help_heading = "Filters"))]
    pub min_p_brighter: f64,
    /// Magnitudes above the atmosphere, and the same limit in twilight as by night [default: clear air, or
    /// --extinction]
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Filters"))]
    pub no_atmosphere: bool,
    /// Order of the passes: time, or brightness (the most probably visible first) [default: brightness with --max-mag]
    #[cfg_attr(feature = "cli", arg(long, value_name = "ORDER", value_parser = ["time", "brightness"], help_heading = "Output"))]
    pub sort: Option<String>,
    /// Altitude of rise and set, degrees
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "DEG", default_value_t = 10.0, allow_hyphen_values = true, help_heading = "Filters")
    )]
    pub min_altitude: f64,
    /// Only passes culminating at or above this altitude, degrees
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true, help_heading = "Filters")
    )]
    pub min_culmination: f64,
    /// Highest altitude of the Sun at the site for a visible pass, degrees
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "DEG", default_value = "-6", allow_hyphen_values = true, help_heading = "Filters")
    )]
    pub sun_altitude_deg: Option<f64>,
    /// Satellites.
    #[serde(flatten)]
    #[cfg_attr(feature = "cli", command(flatten, next_help_heading = "Filters"))]
    pub selection: SelectionConfig,
    /// Include passes in the Earth's shadow and by daylight
    #[cfg_attr(feature = "cli", arg(long, num_args = 0, default_missing_value = "true", help_heading = "Filters"))]
    pub include_dark: Option<bool>,
    /// Points along each pass from rise to set; 61 for light curves if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Output"))]
    pub samples: Option<usize>,
}

impl Default for ForecastConfig {
    fn default() -> Self {
        Self {
            range: TimeRangeConfig::default(),
            max_mag: None,
            min_p_brighter: 0.5,
            no_atmosphere: false,
            sort: None,
            min_altitude: 10.0,
            min_culmination: 0.0,
            sun_altitude_deg: Some(-6.0),
            selection: SelectionConfig::default(),
            include_dark: None,
            samples: None,
        }
    }
}

impl ForecastConfig {
    /// Checks the values and converts them to a request and a selection of satellites. `self` determines whether passes
    /// in the shadow are included, or else `config`. `default_samples` is the number of points along each pass if
    /// neither of them sets it. Without an extinction in `config`, that of clear air at the height of the site is
    /// applied.
    ///
    /// # Errors
    /// A generation or the order is unknown, a number is out of range, an extinction is given with `no_atmosphere`, or
    /// the errors of [`time_range`].
    pub fn resolve(&self, config: &Config, default_samples: usize) -> Result<(ForecastRequest, Selection), Error> {
        let selection = self.selection.resolve()?;
        let (start, end) = self.range.resolve(config)?;
        let mut photometry = config.photometry()?;
        if self.no_atmosphere {
            if photometry.extinction_mag_per_airmass.is_some() {
                return Err(request("no-atmosphere and extinction exclude each other; specify one of them"));
            }
        } else if photometry.extinction_mag_per_airmass.is_none()
            && let Ok(site) = config.site()
        {
            photometry.extinction_mag_per_airmass = Some(clear_sky_extinction_mag(photometry.band, site.height_m));
        }
        let by_brightness = if self.max_mag.is_some() { PassOrder::Brightness } else { PassOrder::Time };
        let order = self.sort.as_deref().map_or(Ok(by_brightness), |name| {
            PassOrder::by_name(name)
                .ok_or_else(|| request(format!("invalid sort '{name}'")).allowing("time, brightness"))
        })?;
        let request = ForecastRequest {
            start,
            end,
            max_sun_altitude_rad: self.sun_altitude_deg.map(f64::to_radians),
            min_altitude_rad: self.min_altitude.to_radians(),
            min_culmination_rad: self.min_culmination.to_radians(),
            max_magnitude: self.max_mag,
            min_probability: self.min_p_brighter,
            twilight: !self.no_atmosphere,
            order,
            include_dark: self.include_dark.or(config.include_dark).unwrap_or(false),
            samples: self.samples.or(config.samples).unwrap_or(default_samples),
            photometry,
        };
        request.check()?;
        Ok((request, selection))
    }
}

/// Returns the date of an evening as `2024-08-14`, from this form or `2024-8-14`, `20240814`, `2024/8/14`, `14.8.2024`.
/// The word `tonight`, which the command line replaces, remains.
///
/// # Errors
/// Text of another form, in which day and month may be ambiguous, or a day that does not exist.
pub fn parse_night(text: &str) -> Result<String, String> {
    let wrong = || {
        "not a night; allowed: tonight, or the local date of the evening as year, month and day, for example 2024-08-14"
            .to_owned()
    };
    let night = text.trim();
    if night == "tonight" {
        return Ok(night.to_owned());
    }
    let mut parts: Vec<&str> = match night {
        digits if digits.len() == 8 && digits.bytes().all(|byte| byte.is_ascii_digit()) => {
            vec![&digits[..4], &digits[4..6], &digits[6..]]
        }
        other => other.split(['-', '/', '.']).collect(),
    };
    // Dates with points begin with the day.
    if night.contains('.') {
        parts.reverse();
    }
    let separators = night.chars().filter(|mark| !mark.is_ascii_digit());
    let is_number = |part: &&str| part.bytes().all(|byte| byte.is_ascii_digit());
    match parts[..] {
        [year, month, day]
            if year.len() == 4
                && [month, day].iter().all(|part| (1..=2).contains(&part.len()))
                && parts.iter().all(is_number)
                && separators.collect::<BTreeSet<_>>().len() < 2 =>
        {
            let date = format!("{year}-{month:0>2}-{day:0>2}");
            parse_instant(&format!("{date}T12:00:00Z"), None).map_err(|_| wrong())?;
            Ok(date)
        }
        _ => Err(wrong()),
    }
}

/// Returns start and end of the time range. A night lasts from local mean noon to the next noon at the site, and is
/// given by the local date of its evening.
///
/// # Errors
/// A date or time is invalid or missing, the range is longer than 31 days, or its end is before its start.
pub fn time_range(
    night: Option<&str>,
    start: Option<&str>,
    end: Option<&str>,
    config: &Config,
) -> Result<(Epoch, Epoch), Error> {
    let (from, to) = match (night, start, end) {
        (Some(night), None, None) => {
            let evening =
                parse_night(night).ok().and_then(|date| parse_instant(&format!("{date}T12:00:00Z"), None).ok());
            let evening = evening.ok_or_else(|| {
                request(format!("invalid night '{night}'"))
                    .allowing("the local date of the evening, for example 2024-08-14")
            })?;
            night_of(evening, config.site()?.longitude_rad)
        }
        (Some(_), ..) => {
            return Err(request("--night and --start or --end exclude each other; specify one of them"));
        }
        (None, Some(start), Some(end)) => {
            let scale = config.time_scale()?;
            (parse_moment(start, scale)?, parse_moment(end, scale)?)
        }
        _ => return Err(Error::missing("time range", "--night 2024-08-14, or --start and --end")),
    };
    let days = seconds_between(from, to) / DAY_S;
    if !(0.0..=LONGEST_DAYS).contains(&days) {
        let (from, to) = (format_utc(from, 0), format_utc(to, 0));
        return Err(Error::invalid(
            "the time range",
            format_args!("{from} to {to}"),
            "0 to 31 days, the end not before the start",
        ));
    }
    Ok((from, to))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nights_in_unambiguous_forms() {
        for text in ["2026-04-25", "2026-4-25", "20260425", "25.04.2026", "25.4.2026", "2026/04/25", " 2026-04-25 "] {
            assert_eq!(parse_night(text).as_deref(), Ok("2026-04-25"), "{text}");
        }
        assert_eq!(parse_night("tonight").as_deref(), Ok("tonight"));
        for text in [
            "today",
            "now",
            "25/04/2026",
            "04-25-2026",
            "2026.04.25",
            "2026-02-30",
            "2026-13-01",
            "26-04-25",
            "2026-04",
            "2026-04/25",
            "2026-04-25T22:00",
            "",
            "2026-+4-25",
            "202604251",
        ] {
            let error = parse_night(text).expect_err(text);
            assert!(error.contains("tonight") && error.contains("2024-08-14"), "{text}: {error}");
        }
    }

    /// Night and selection are keys of the request, as the Python package writes it; unknown keys are errors.
    #[test]
    fn keys_of_groups_are_keys_of_the_request() {
        let text = r#"{"max_mag": null, "min_altitude": 10.0, "sun_altitude_deg": null, "generation": [], "name": ["ISS"],
                      "norad": [25544], "include_dark": false, "samples": 0, "night": "2026-08-14"}"#;
        let forecast: ForecastConfig = serde_json::from_str(text).unwrap();
        assert_eq!((forecast.range.night.as_deref(), forecast.sun_altitude_deg), (Some("2026-08-14"), None));
        assert_eq!(
            (&forecast.selection.norad[..], &forecast.selection.name[..]),
            (&[25_544][..], &["ISS".to_owned()][..])
        );
        assert!(serde_json::from_str::<ForecastConfig>(r#"{"nite": "2026-08-14"}"#).is_err());
        assert!(serde_json::from_str::<ForecastConfig>(r#"{"norad": ["x"]}"#).is_err());
    }
}
