//! Policy for verdicts: magnitude limits, largest pixel loss, least probability, margin and longest delay.

use std::collections::{BTreeMap, BTreeSet};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::error::ScheduleError;
use crate::images::Telescope;
use crate::message::listed;

/// Magnitude limit: one number for all bands, one number for each band, or the limits of the telescope file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "invalid magnitude limit; allowed: a number, a table of numbers by band, or (saturation_mag, crosstalk_mag) \"telescope\""
)]
pub enum MagnitudeLimit {
    /// One limit for all exposures.
    All(f64),
    /// Limits by the band of the exposure. The key `default` applies to all other bands.
    PerBand(BTreeMap<String, f64>),
    /// The limits of the telescope file, by the band of the exposure, written as the word `telescope`. Allowed only
    /// for saturation and crosstalk.
    OfTelescope(OfTelescope),
}

/// The word `telescope` as a value in TOML.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OfTelescope {
    /// The limits of the telescope file apply.
    Telescope,
}

impl FromStr for MagnitudeLimit {
    type Err = ScheduleError;

    /// Parses one number, `7`, or limits by band, `g=7,y=5,default=6`.
    fn from_str(text: &str) -> Result<Self, ScheduleError> {
        let number = |text: &str| text.trim().parse::<f64>().ok();
        if let Some(limit) = number(text) {
            return Ok(MagnitudeLimit::All(limit));
        }
        let pairs = text.split(',').map(|part| {
            let (band, limit) = part.split_once('=')?;
            Some((band.trim().to_owned(), number(limit)?)).filter(|(band, _)| !band.is_empty())
        });
        let mut limits = BTreeMap::new();
        for pair in pairs {
            let (band, limit) = pair.ok_or_else(|| ScheduleError::PolicyLimit { given: text.to_owned() })?;
            if limits.insert(band.clone(), limit).is_some() {
                return Err(ScheduleError::PolicyBand { band, given: text.to_owned() });
            }
        }
        Ok(MagnitudeLimit::PerBand(limits))
    }
}

impl MagnitudeLimit {
    /// Returns the limit for an exposure in this band. Returns `None` if the table has neither the band nor `default`,
    /// and for the limits of the telescope file.
    pub fn of(&self, band: Option<&str>) -> Option<f64> {
        match self {
            MagnitudeLimit::All(limit) => Some(*limit),
            MagnitudeLimit::PerBand(limits) => {
                band.and_then(|band| limits.get(band)).or_else(|| limits.get("default")).copied()
            }
            MagnitudeLimit::OfTelescope(_) => None,
        }
    }

    /// Returns all numbers of the limit; empty for the limits of the telescope file.
    pub(crate) fn numbers(&self) -> Vec<f64> {
        match self {
            MagnitudeLimit::All(limit) => vec![*limit],
            MagnitudeLimit::PerBand(limits) => limits.values().copied().collect(),
            MagnitudeLimit::OfTelescope(_) => Vec::new(),
        }
    }
}

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
    type Err = ScheduleError;

    fn from_str(text: &str) -> Result<Self, ScheduleError> {
        let known = [Blocking::Any, Blocking::Avoid];
        known
            .into_iter()
            .find(|blocking| blocking.name() == text)
            .ok_or_else(|| ScheduleError::PolicyBlocking { given: text.to_owned() })
    }
}

/// Effect on the camera if a magnitude limit is exceeded.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum LimitKind {
    /// Pixels of the streak saturate.
    Saturation,
    /// Crosstalk is too strong to be corrected.
    Crosstalk,
}

impl LimitKind {
    /// Returns this limit from a telescope file; `None` if it has none for the band.
    pub(super) fn limit_mag(self, telescope: &Telescope, band: &str) -> Option<f64> {
        let limits = telescope.limits.get(band)?;
        match self {
            LimitKind::Saturation => limits.trail_saturation_mag,
            LimitKind::Crosstalk => limits.crosstalk_mag,
        }
    }
}

/// Rules for verdicts. An omitted rule is not applied; the default policy has no rules.
///
/// Magnitude limits are compared with the brightest apparent magnitude in the field, in the band of the prediction.
/// Positions and magnitudes have errors, so the verdict is `avoid` if the probability that a satellite crosses and is
/// brighter than a limit is at least `min_probability`. In a table of limits by band, the band of the *exposure*
/// selects the limit. The word `telescope` as saturation or crosstalk limit stands for the limits of the telescope
/// file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Policy {
    /// Magnitude limit; the verdict is `avoid` if a lit crossing is brighter.
    pub limit_mag: Option<MagnitudeLimit>,
    /// Largest expected fraction of pixels lost, (0, 1]; the verdict is `avoid` above it.
    pub max_lost_fraction: Option<f64>,
    /// Saturation limit, magnitudes; the verdict is `avoid` if a lit crossing is brighter.
    pub saturation_mag: Option<MagnitudeLimit>,
    /// Limit of correctable crosstalk, magnitudes; the verdict is `avoid` if a lit crossing is brighter.
    pub crosstalk_mag: Option<MagnitudeLimit>,
    /// Least probability of a crossing brighter than a limit for the verdict `avoid`, and least crossing probability of
    /// a near miss that counts. If omitted, the first is 0.5 and near misses do not count.
    pub min_probability: Option<f64>,
    /// Choice of the satellites that block the start of an exposure, for windows, delays and gates.
    pub blocking: Blocking,
    /// Time without crossings required before opening and after closing, seconds; default 0.
    pub margin_s: Option<f64>,
    /// Longest delay of an exposure, seconds; default [`Policy::DEFAULT_MAX_DELAY_S`].
    pub max_delay_s: Option<f64>,
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
    pub fn from_toml(text: &str) -> Result<Self, ScheduleError> {
        let policy: Policy = toml::from_str(text)
            .map_err(|error| ScheduleError::PolicySyntax(crate::input::toml_error(&error, text)))?;
        policy.validate()?;
        Ok(policy)
    }

    /// Checks the ranges of all numbers.
    ///
    /// # Errors
    /// A number is out of range.
    pub fn validate(&self) -> Result<(), ScheduleError> {
        if matches!(self.limit_mag, Some(MagnitudeLimit::OfTelescope(_))) {
            let what = "limit_mag is \"telescope\"; allowed: a number or a table by band; only saturation_mag and crosstalk_mag can be \"telescope\"";
            return Err(ScheduleError::PolicySyntax(what.to_owned()));
        }
        for (field, limit) in self.magnitude_limits() {
            for value in limit.numbers() {
                if !(-30.0..=40.0).contains(&value) {
                    return Err(ScheduleError::PolicyOutOfRange { field, value, allowed: "-30 to 40 mag" });
                }
            }
        }
        let fractions = [("max_lost_fraction", self.max_lost_fraction), ("min_probability", self.min_probability)];
        for (field, value) in fractions {
            if let Some(value) = value.filter(|value| !(*value > 0.0 && *value <= 1.0)) {
                return Err(ScheduleError::PolicyOutOfRange { field, value, allowed: "above 0, at most 1" });
            }
        }
        let times = [("margin_s", self.margin_s, 3600.0), ("max_delay_s", self.max_delay_s, Self::LONGEST_DELAY_S)];
        for (field, value, longest) in times {
            if let Some(value) = value.filter(|value| !(0.0..=longest).contains(value)) {
                let allowed = if field == "margin_s" { "0 to 3600 s" } else { "0 to 86400 s" };
                return Err(ScheduleError::PolicyOutOfRange { field, value, allowed });
            }
        }
        Ok(())
    }

    /// Returns the key of the first limit that is taken from the telescope file; `None` if there is none.
    pub fn limit_of_telescope(&self) -> Option<&'static str> {
        self.kinds_of_telescope().next().map(|(name, _)| name)
    }

    /// Returns the keys of the limits that are taken from the telescope file, each with the limits by band. A table is
    /// empty if the file has no limits of that kind.
    pub fn limits_of_telescope(&self, telescope: &Telescope) -> Vec<(&'static str, MagnitudeLimit)> {
        let limits = telescope.limits.keys();
        self.kinds_of_telescope()
            .map(|(name, kind)| {
                let numbers = limits.clone().filter_map(|band| Some((band.clone(), kind.limit_mag(telescope, band)?)));
                (name, MagnitudeLimit::PerBand(numbers.collect()))
            })
            .collect()
    }

    fn kinds_of_telescope(&self) -> impl Iterator<Item = (&'static str, LimitKind)> {
        let limits = [
            ("saturation_mag", LimitKind::Saturation, &self.saturation_mag),
            ("crosstalk_mag", LimitKind::Crosstalk, &self.crosstalk_mag),
        ];
        limits
            .into_iter()
            .filter(|(.., limit)| matches!(limit, Some(MagnitudeLimit::OfTelescope(_))))
            .map(|(name, kind, _)| (name, kind))
    }

    /// Returns true if the policy has any magnitude limit.
    pub fn has_magnitude_limit(&self) -> bool {
        self.magnitude_limits().next().is_some()
    }

    /// Magnitude limits by key.
    fn magnitude_limits(&self) -> impl Iterator<Item = (&'static str, &MagnitudeLimit)> {
        [
            ("limit_mag", &self.limit_mag),
            ("saturation_mag", &self.saturation_mag),
            ("crosstalk_mag", &self.crosstalk_mag),
        ]
        .into_iter()
        .filter_map(|(name, limit)| Some((name, limit.as_ref()?)))
    }

    /// Returns true if a magnitude limit applies to exposures in this band.
    pub fn limits_band(&self, band: Option<&str>, telescope: Option<&Telescope>) -> bool {
        let of_telescope = telescope.map(|telescope| self.limits_of_telescope(telescope)).unwrap_or_default();
        let mut limits =
            self.magnitude_limits().map(|(_, limit)| limit).chain(of_telescope.iter().map(|(_, limit)| limit));
        limits.any(|limit| limit.of(band).is_some())
    }

    /// Returns a warning for each limit that has no value for some of the bands of the exposures. `None`
    /// is the band of exposures without a band.
    pub fn band_warnings(&self, bands: &BTreeSet<Option<&str>>, telescope: Option<&Telescope>) -> Vec<String> {
        let warning = |name: &str, limit: &MagnitudeLimit, end: &str| {
            let without: Vec<&str> =
                bands.iter().filter(|band| limit.of(**band).is_none()).map(|band| band.unwrap_or("none")).collect();
            (!without.is_empty())
                .then(|| format!("{name} of the policy has no value for band {}{end}", listed(without)))
        };
        let of_telescope = telescope.map(|telescope| self.limits_of_telescope(telescope)).unwrap_or_default();
        self.magnitude_limits()
            .filter(|(_, limit)| !matches!(limit, MagnitudeLimit::OfTelescope(_)))
            .filter_map(|(name, limit)| warning(name, limit, " and no default"))
            .chain(
                of_telescope.iter().filter_map(|(name, limit)| warning(name, limit, " in the file of the telescope")),
            )
            .collect()
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_or_tables_by_band() {
        let policy = Policy::from_toml("limit_mag = 7\nmax_delay_s = 90.0\n").unwrap();
        assert_eq!(policy.limit_mag.unwrap().of(None), Some(7.0));
        let policy =
            Policy::from_toml("[limit_mag]\ng = 7.5\ny = 4\ndefault = 6\n[saturation_mag]\ng = 3.2\n").unwrap();
        let limit = policy.limit_mag.unwrap();
        assert_eq!(
            (limit.of(Some("g")), limit.of(Some("y")), limit.of(Some("u")), limit.of(None)),
            (Some(7.5), Some(4.0), Some(6.0), Some(6.0))
        );
        assert_eq!(policy.saturation_mag.unwrap().of(Some("u")), None);
    }

    #[test]
    fn limits_are_parsed_from_text() {
        let limit = |text: &str| text.parse::<MagnitudeLimit>();
        assert_eq!(limit(" 7 ").unwrap(), MagnitudeLimit::All(7.0));
        let by_band = limit("g=7, y=-5.5,default=6").unwrap();
        assert_eq!((by_band.of(Some("y")), by_band.of(Some("r"))), (Some(-5.5), Some(6.0)));
        for text in ["bright", "g=", "=7", "g=7,", "", "g7"] {
            assert!(limit(text).unwrap_err().to_string().contains("g=7,y=5,default=6"), "{text}");
        }
        assert!(limit("g=7, g=6").unwrap_err().to_string().starts_with("band g has two limits in 'g=7, g=6'"));
    }

    #[test]
    fn invalid_policies_are_errors_on_one_line() {
        for (text, part) in [
            ("limit = 7", "line 1: unknown field `limit`"),
            ("limit_mag = 'bright'", "line 1"),
            ("max_lost_fraction = 1.5", "max_lost_fraction is 1.5; allowed: above 0, at most 1"),
            ("\nmin_probability = 0", "min_probability is 0; allowed"),
            ("margin_s = -1", "margin_s is -1"),
            ("max_delay_s = nan", "max_delay_s is NaN"),
            ("limit_mag = {g = inf}", "limit_mag is inf"),
            ("limit_mag = ", "line 1"),
            ("limit_mag = 'telescope'", "only saturation_mag and crosstalk_mag"),
            (
                "saturation_mag = 'camera'",
                "line 1: invalid magnitude limit; allowed: a number, a table of numbers by band, or",
            ),
        ] {
            let message = Policy::from_toml(text).unwrap_err().to_string();
            assert!(message.contains(part) && !message.contains('\n'), "{text}: {message}");
        }
    }
}
