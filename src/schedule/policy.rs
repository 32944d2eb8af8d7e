//! Policy for verdicts: magnitude limit, largest cost of streaks, least probability, margin and longest delay.

use std::collections::BTreeSet;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::images::MagnitudeLimit;
use crate::message::Quoted;
use crate::message::listed;
use crate::passes::Pass;

/// Choice of the satellites that block the start of an exposure.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Blocking {
    /// All lit satellites that count: a start is possible if the verdict is `clear`.
    Any,
    /// Satellites that exceed a magnitude limit of the policy: a start is possible if the verdict is `clear` or
    /// `streaked`. If no magnitude limit applies to the band of the exposure, all lit satellites block.
    #[default]
    Avoid,
}

impl Blocking {
    /// Returns the name used in policies: `any` or `avoid`.
    pub fn name(self) -> &'static str {
        match self {
            Blocking::Any => "any",
            Blocking::Avoid => "avoid",
        }
    }
}

impl FromStr for Blocking {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let known = [Blocking::Any, Blocking::Avoid];
        known
            .into_iter()
            .find(|blocking| blocking.name() == text)
            .ok_or_else(|| Error::format(format!("blocking is '{}'", Quoted::new(text))).allowing("any, avoid"))
    }
}

/// Rules for verdicts. An omitted rule is not applied; the default policy has no rules.
///
/// Magnitude limits are compared with the brightest apparent magnitude in the field, in the band of the prediction.
/// Positions and magnitudes have errors, so the verdict is `avoid` if the probability that a satellite crosses and is
/// brighter than a limit is at least `min_probability`. In a table of limits by band, the band of the *exposure*
/// selects the limit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Policy {
    /// Magnitude limit; the verdict is `avoid` if a lit crossing is brighter.
    pub limit_mag: Option<MagnitudeLimit>,
    /// Limit of the surface brightness of streaks, averaged over the exposure, mag/arcsec²; the verdict is `avoid` if a
    /// lit crossing is brighter. It requires a telescope.
    pub limit_surface_brightness: Option<MagnitudeLimit>,
    /// Largest cost of streaks (`streak_cost_s`), seconds of open shutter; the verdict is `avoid` above it. It requires
    /// a telescope.
    pub max_cost_s: Option<f64>,
    /// Least probability of a crossing brighter than a limit for the verdict `avoid`, and least crossing probability of
    /// a near miss that counts. If omitted, the first is 0.5 and near misses do not count.
    pub min_probability: Option<f64>,
    /// Choice of the satellites that block the start of an exposure, for windows, delays and gates.
    pub blocking: Blocking,
    /// Time without crossings required before opening and after closing, seconds; default 0.
    pub margin_s: Option<f64>,
    /// Longest delay of an exposure, seconds; default [`Policy::DEFAULT_MAX_DELAY_S`]. For a telescope in orbit `flag`
    /// searches later starts only if it is given.
    pub max_delay_s: Option<f64>,
    /// If true, crossings in the Earth's shadow count as well: for a telescope in orbit that detects their infrared
    /// light. They are not brighter than any limit, except by the thermal emission that magnitudes in K, W1 and W2
    /// include. It has no effect at a site and is not a key of policy files.
    #[serde(skip)]
    #[doc(hidden)]
    pub include_dark: bool,
}

impl Policy {
    /// Default of the least probability of a crossing brighter than a limit for the verdict `avoid`.
    pub const DEFAULT_MIN_PROBABILITY: f64 = 0.5;
    /// Default longest delay to the next clear start, seconds.
    pub const DEFAULT_MAX_DELAY_S: f64 = 600.0;
    /// Largest value of `max_delay_s` accepted in a policy, seconds.
    pub const LONGEST_DELAY_S: f64 = 86_400.0;

    /// Creates a policy with this apparent magnitude limit and no other rule.
    pub fn limit_mag(limit_mag: f64) -> Self {
        Self { limit_mag: Some(MagnitudeLimit::All(limit_mag)), ..Self::default() }
    }

    /// Reads a policy from TOML.
    ///
    /// # Errors
    /// The syntax is invalid, a key is unknown, or a number is out of range.
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        Self::parse(text).map_err(|error| error.at("policy"))
    }

    /// Reads a policy from the TOML of a file, which its errors do not name.
    pub(crate) fn parse(text: &str) -> Result<Self, Error> {
        let policy: Policy = toml::from_str(text).map_err(|error| crate::input::toml_error(&error, text))?;
        policy.check()?;
        Ok(policy)
    }

    /// Checks the ranges of all numbers.
    ///
    /// # Errors
    /// A number is out of range.
    pub fn validate(&self) -> Result<(), Error> {
        self.check().map_err(|error| error.at("policy"))
    }

    fn check(&self) -> Result<(), Error> {
        for value in self.limit_mag.iter().flat_map(MagnitudeLimit::numbers) {
            if !(-30.0..=40.0).contains(&value) {
                return Err(Error::invalid("limit_mag", value, "-30 to 40 mag"));
            }
        }
        for value in self.limit_surface_brightness.iter().flat_map(MagnitudeLimit::numbers) {
            if !(-30.0..=60.0).contains(&value) {
                let (field, allowed) = ("limit_surface_brightness", "-30 to 60 mag/arcsec2");
                return Err(Error::invalid(field, value, allowed));
            }
        }
        let positive = [
            ("max_cost_s", self.max_cost_s, 86_400.0, "above 0, at most 86400 s"),
            ("min_probability", self.min_probability, 1.0, "above 0, at most 1"),
        ];
        for (field, value, most, allowed) in positive {
            if let Some(value) = value.filter(|value| !(*value > 0.0 && *value <= most)) {
                return Err(Error::invalid(field, value, allowed));
            }
        }
        let times = [("margin_s", self.margin_s, 3600.0), ("max_delay_s", self.max_delay_s, Self::LONGEST_DELAY_S)];
        for (field, value, longest) in times {
            if let Some(value) = value.filter(|value| !(0.0..=longest).contains(value)) {
                let allowed = if field == "margin_s" { "0 to 3600 s" } else { "0 to 86400 s" };
                return Err(Error::invalid(field, value, allowed));
            }
        }
        Ok(())
    }

    /// Returns the magnitude limit for exposures in this band; `None` if none applies.
    pub fn limit_mag_in(&self, band: Option<&str>) -> Option<f64> {
        self.limit_mag.as_ref().and_then(|limit| limit.limit_in(band))
    }

    /// Returns the length of the streak of a crossing, radians: that of the lit part of its track in the field, or with
    /// `include_dark` of all of it.
    #[doc(hidden)]
    pub fn streak_length_rad(&self, pass: &Pass) -> f64 {
        if self.include_dark { pass.track_length_rad } else { pass.streak_length_rad }
    }

    /// Returns true if there is a limit of magnitude or surface brightness.
    #[doc(hidden)]
    pub fn has_limit(&self) -> bool {
        self.limit_mag.is_some() || self.limit_surface_brightness.is_some()
    }

    /// Returns true if a limit of magnitude or surface brightness applies to exposures in this band.
    #[doc(hidden)]
    pub fn has_limit_in(&self, band: Option<&str>) -> bool {
        [&self.limit_mag, &self.limit_surface_brightness]
            .into_iter()
            .flatten()
            .any(|limit| limit.limit_in(band).is_some())
    }

    /// Returns warnings if the limits of magnitude and of surface brightness have no value for some of the bands of the
    /// exposures, or have one for a band that differs from these by its case. `None` is the band of exposures without a
    /// band.
    pub fn band_warnings(&self, bands: &BTreeSet<Option<&str>>) -> Vec<String> {
        let limits = [("limit_mag", &self.limit_mag), ("limit_surface_brightness", &self.limit_surface_brightness)];
        let warning = |(name, limit): (&str, &Option<MagnitudeLimit>)| {
            let limit = limit.as_ref()?;
            if let MagnitudeLimit::PerBand(values) = limit {
                // `Y` in place of `y`.
                let other_case =
                    values.keys().filter(|named| !bands.contains(&Some(named.as_str()))).find_map(|named| {
                        Some((named, bands.iter().flatten().find(|band| band.eq_ignore_ascii_case(named))?))
                    });
                if let Some((named, band)) = other_case {
                    return Some(format!("{name} of band {named} has no effect: the exposures have the band {band}"));
                }
            }
            let without: Vec<&str> = bands
                .iter()
                .filter(|band| limit.limit_in(**band).is_none())
                .map(|band| band.unwrap_or("none"))
                .collect();
            (!without.is_empty())
                .then(|| format!("{name} of the policy has no value for band {} and no default", listed(without)))
        };
        limits.into_iter().filter_map(warning).collect()
    }

    /// Returns the least probability of a crossing brighter than a limit for the verdict `avoid`.
    pub(super) fn avoid_probability(&self) -> f64 {
        self.min_probability.unwrap_or(Self::DEFAULT_MIN_PROBABILITY)
    }

    /// Returns `margin_s` or its default, seconds.
    pub fn margin_or_default_s(&self) -> f64 {
        self.margin_s.unwrap_or(0.0)
    }

    /// Returns `max_delay_s` or its default, seconds.
    pub fn max_delay_or_default_s(&self) -> f64 {
        self.max_delay_s.unwrap_or(Self::DEFAULT_MAX_DELAY_S)
    }

    /// Returns true if passes and costs at later starts must be computed to confirm them, because the times of
    /// crossings do not determine them.
    pub(super) fn confirms_starts(&self) -> bool {
        self.min_probability.is_some() || self.max_cost_s.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_or_tables_by_band() {
        let policy = Policy::from_toml("limit_mag = 7\nmax_delay_s = 90.0\n").unwrap();
        assert_eq!(policy.limit_mag.unwrap().limit_in(None), Some(7.0));
        let policy = Policy::from_toml("[limit_mag]\ng = 7.5\ny = 4\ndefault = 6\n").unwrap();
        let limit = policy.limit_mag.unwrap();
        assert_eq!(
            (limit.limit_in(Some("g")), limit.limit_in(Some("y")), limit.limit_in(Some("u")), limit.limit_in(None)),
            (Some(7.5), Some(4.0), Some(6.0), Some(6.0))
        );
        let policy = Policy::from_toml("[limit_mag]\ng = 7.5\n").unwrap();
        assert_eq!((policy.limit_mag_in(Some("u")), policy.limit_mag_in(Some("g"))), (None, Some(7.5)));
    }

    #[test]
    fn limits_are_parsed_from_text() {
        let limit = |text: &str| text.parse::<MagnitudeLimit>();
        assert_eq!(limit(" 7 ").unwrap(), MagnitudeLimit::All(7.0));
        let by_band = limit("g=7, y=-5.5,default=6").unwrap();
        assert_eq!((by_band.limit_in(Some("y")), by_band.limit_in(Some("r"))), (Some(-5.5), Some(6.0)));
        for text in ["bright", "g=", "=7", "g=7,", "", "g7"] {
            assert!(limit(text).unwrap_err().to_string().contains("g=7,y=5,default=6"), "{text}");
        }
        assert!(limit("g=7, g=6").unwrap_err().to_string().starts_with("band g has two limits in 'g=7, g=6'"));
    }

    #[test]
    fn invalid_policies_are_errors_on_one_line() {
        for (text, part) in [
            ("limit = 7", "line 1: unknown key 'limit'"),
            ("limit_mag = 'bright'", "line 1"),
            ("max_cost_s = 0", "max_cost_s is 0; allowed: above 0, at most 86400 s"),
            ("max_cost_s = nan", "max_cost_s is NaN"),
            ("limit_surface_brightness = 61", "limit_surface_brightness is 61; allowed: -30 to 60 mag/arcsec2"),
            ("max_lost_fraction = 0.1", "unknown key 'max_lost_fraction'"),
            ("saturation_mag = 4", "unknown key 'saturation_mag'"),
            ("\nmin_probability = 0", "min_probability is 0; allowed"),
            ("margin_s = -1", "margin_s is -1"),
            ("max_delay_s = nan", "max_delay_s is NaN"),
            ("limit_mag = {g = inf}", "limit_mag is inf"),
            ("limit_mag = ", "line 1"),
            (
                "limit_mag = 'telescope'",
                "line 1: invalid magnitude limit 'telescope'; allowed: a number, or numbers by band such as g=7,y=5,default=6",
            ),
            (
                "limit_mag = [7]",
                "line 1: invalid magnitude limit; allowed: a number, a text such as g=7,default=6, or a table",
            ),
        ] {
            let message = Policy::from_toml(text).unwrap_err().to_string();
            assert!(message.contains(part) && !message.contains('\n'), "{text}: {message}");
        }
    }
}
