//! The questions that the keys of a configuration answer: of several layers, the topmost that has any of the keys of a
//! question answers it alone.

use std::path::PathBuf;

use super::document::{Config, SiteConfig};
use super::paths::Paths;

/// Keys of a configuration that answer one question, and the keys that also answer it. They are taken together: of
/// several layers, the topmost that has any of them answers the question alone.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Question {
    /// Keys that only answer this question.
    pub keys: &'static [&'static str],
    /// Keys that answer this question in addition to their own: a telescope has a field of view, a policy has limits.
    pub others: &'static [&'static str],
}

impl Question {
    /// Returns true if any of these keys answers the question.
    pub fn is_answered_by(&self, keys: &[&str]) -> bool {
        self.keys.iter().chain(self.others).any(|key| keys.contains(key))
    }
}

/// Returns the key of a field.
macro_rules! key {
    (site.named) => {
        "site"
    };
    (exposure.duration) => {
        "exposure"
    };
    ($key:ident) => {
        stringify!($key)
    };
    ($group:ident.$key:ident) => {
        stringify!($key)
    };
}

/// Declares all keys by their fields, those of one question in brackets; after `or` a field that also answers it.
macro_rules! questions {
    ($([$($key:ident$(.$inner:ident)?),+] $(or $other:ident$(.$part:ident)?)?),+ $(,)?) => {
        impl Config {
            /// Questions that the keys answer.
            pub const QUESTIONS: &'static [Question] = &[$(Question {
                keys: &[$(key!($key$(.$inner)?)),+],
                others: &[$(key!($other$(.$part)?))?],
            }),+];

            /// Returns the keys that are given.
            pub fn given(&self) -> Vec<&'static str> {
                // The time scale of a file is in another field than that of a flag.
                let mut given: Vec<&str> = self.default_time_scale.iter().map(|_| "time_scale").collect();
                $($(if !is_omitted(&self.$key$(.$inner)?) {
                    given.push(key!($key$(.$inner)?));
                })+)+
                given
            }

            /// Calls a function for the path of each file.
            pub(super) fn visit_paths(&mut self, visit: &mut dyn FnMut(&mut PathBuf)) {
                $($(self.$key$(.$inner)?.visit_paths(visit);)+)+
            }

            /// Returns this configuration without a key.
            pub(super) fn without(&self, omitted: &str) -> Config {
                let mut rest = self.clone();
                $($(if omitted == key!($key$(.$inner)?) {
                    rest.$key$(.$inner)? = Default::default();
                })+)+
                rest
            }

            /// Returns this configuration, with `base` for all questions that it does not answer. For example, `mpc`
            /// replaces the coordinates of `base`.
            pub fn over(mut self, base: Config) -> Config {
                self = self.at_height_of(&base);
                let base = if self.site.is_given() { base.without_limits() } else { base };
                let given = self.given();
                let mut questions = Self::QUESTIONS.iter();
                $(if questions.next().is_some_and(|question| !question.is_answered_by(&given)) {
                    $(self.$key$(.$inner)? = base.$key$(.$inner)?;)+
                })+
                self.default_time_scale = self.default_time_scale.or(base.default_time_scale);
                self
            }
        }
    };
}

questions! {
    [elements, shells], [accept_bad_checksums], [qs_mag], [model], [models], [learned], [measured], [drag], [shadow],
    [site.named, site.mpc, site.lat, site.lon, site.height, observer_elements, observer_norad, limb_height_km],
    [max_zenith_angle], [min_sun_angle], [min_limb_angle],
    [fov, field] or telescope, [telescope], [bright_share] or telescope, [rotation],
    [light.band], [light.mag_system], [light.earthshine], [extinction], [sun_distance],
    [rules.policy], [rules.limit_mag] or rules.policy, [rules.limit_surface_brightness] or rules.policy,
    [min_probability] or rules.policy,
    [rules.blocking] or rules.policy, [rules.max_delay] or rules.policy,
    [time_scale], [time_zone], [eop], [run.threads], [run.quiet, run.verbose],
    [exposure.start], [exposure.duration], [exposure.target, exposure.ra, exposure.dec],
    [include_dark], [samples], [format],
}

impl Config {
    /// Returns the configuration with the site of `base` if only its height is given.
    fn at_height_of(mut self, base: &Config) -> Self {
        const SITE: [&str; 7] = ["site", "mpc", "lat", "lon", "observer_elements", "observer_norad", "limb_height_km"];
        let given = self.given();
        if self.site.height.is_some() && !SITE.iter().any(|key| given.contains(key)) {
            self.site = SiteConfig { height: self.site.height, ..base.site.clone() };
        }
        self
    }

    /// Returns the configuration without the limits of a telescope in orbit, which do not apply to a site.
    pub(super) fn without_limits(self) -> Self {
        Self { max_zenith_angle: None, min_sun_angle: None, min_limb_angle: None, ..self }
    }

    /// Returns the accepted keys of a configuration file, except for the tables of verbs.
    pub fn keys() -> impl Iterator<Item = &'static str> {
        Self::QUESTIONS.iter().flat_map(|question| question.keys).copied()
    }
}

fn is_omitted<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[cfg(test)]
mod tests {
    #[cfg(feature = "cli")]
    use super::super::document::ExposureConfig;
    use super::super::document::RulesConfig;
    use super::super::values::Quantity;
    use super::*;
    use crate::schedule::MagnitudeLimit;

    #[test]
    fn every_listed_key_is_a_key() {
        // No key accepts a table inside a list, so every key of `Config` gives an error about the type of its value. A
        // listed key that `Config` lacks gives the error of an unknown key.
        for key in Config::keys() {
            let error = Config::from_toml(&format!("{key} = [[{{}}]]"), "t.toml").expect_err(key).to_string();
            assert!(!error.contains("unknown"), "{key}: {error}");
        }
    }

    #[cfg(feature = "cli")]
    #[test]
    fn every_flag_is_a_listed_key() {
        use clap::Args;
        let flags = Config::augment_args(clap::Command::new("all"));
        let flags = ExposureConfig::augment_args(RulesConfig::augment_args(flags));
        for flag in flags.get_arguments().filter_map(clap::Arg::get_long) {
            let key = flag.trim_start_matches("no-").replace('-', "_");
            assert!(["config", "home"].contains(&key.as_str()) || Config::keys().any(|known| known == key), "{key}");
        }
    }

    #[test]
    fn values_that_belong_together_are_taken_together() {
        let base = Config {
            site: SiteConfig { lat: Some(1.0), lon: Some(2.0), height: Some(3.0), ..SiteConfig::default() },
            fov: Some(Quantity("1deg".into())),
            ..Config::default()
        };
        let flags = Config {
            site: SiteConfig { mpc: Some("X05".into()), ..SiteConfig::default() },
            rules: RulesConfig { limit_mag: Some(MagnitudeLimit::All(6.0)), ..RulesConfig::default() },
            ..Config::default()
        };
        let both = flags.over(base);
        assert_eq!((both.site.lat, both.site.height, both.site.mpc.as_deref()), (None, None, Some("X05")));
        assert_eq!(both.rules.limit_mag, Some(MagnitudeLimit::All(6.0)));
        assert!(both.fov.is_some());
    }
}
