//! Sources: addresses, usage policies and intervals between requests.

use anyhow::anyhow;
use hifitime::{Epoch, TimeScale};
use streakcast::frames::parse_moment;

use super::arguments::{CommonFetchArguments, DaysArguments, FetchSource, RecordCheckArguments};

/// Interval for CelesTrak, seconds: it updates its data every two hours and rejects earlier requests for the same data
/// with status 403.
const CELESTRAK_WAIT_S: f64 = 7_200.0;
/// Interval for Space-Track and SatChecker, seconds. Space-Track allows one request for element sets per hour;
/// SatChecker has no rule.
const WAIT_S: f64 = 3_600.0;

/// Data set of a source.
pub struct Source {
    /// Name of the source in messages.
    pub name: &'static str,
    /// File name in the cache.
    pub file: String,
    pub url: String,
    /// Login and logout, for Space-Track.
    pub login: Option<Login>,
    /// Address of the usage policy of the source.
    pub policy: &'static str,
    /// Shortest interval between requests for the same data set, seconds.
    pub wait_s: f64,
}

pub struct Login {
    pub login_url: String,
    pub logout_url: String,
}

impl FetchSource {
    /// Returns the flags of all sources, and those that only some sources have.
    fn flags(&self) -> (&CommonFetchArguments, Option<&RecordCheckArguments>, Option<&DaysArguments>) {
        match self {
            Self::Celestrak(typed) => (&typed.common, Some(&typed.checks), Some(&typed.days)),
            Self::Supgp(typed) => (&typed.common, Some(&typed.checks), Some(&typed.days)),
            Self::SpaceTrack(typed) => (&typed.common, Some(&typed.checks), Some(&typed.days)),
            Self::Satchecker(typed) => (&typed.common, Some(&typed.checks), None),
            Self::StarlinkEphemerides(typed) => (&typed.common, None, None),
        }
    }

    pub fn common(&self) -> &CommonFetchArguments {
        self.flags().0
    }

    /// Returns true if the number of records is not compared with that of the previous file (`--accept-fewer`). The
    /// download of ephemerides does not use this method.
    pub fn accepts_fewer(&self) -> bool {
        self.flags().1.is_some_and(|checks| checks.accept_fewer)
    }

    /// Returns whether the folder with the element sets of several days is printed; `None` if the source has none.
    pub fn with_older(&self) -> Option<bool> {
        self.flags().2.map(|days| days.with_older)
    }

    pub fn source(&self) -> anyhow::Result<Source> {
        let base = |default: &str| {
            let base = self.common().base_url.as_deref().unwrap_or(default);
            base.trim_end_matches('/').to_owned()
        };
        Ok(match self {
            FetchSource::Celestrak(typed) => {
                let (group, format) = (plain("group", &typed.group)?, typed.elements_format.name());
                Source {
                    name: "CelesTrak",
                    file: format!("celestrak-{group}.{format}"),
                    url: format!(
                        "{}/NORAD/elements/gp.php?GROUP={group}&FORMAT={format}",
                        base("https://celestrak.org")
                    ),
                    login: None,
                    policy: "https://celestrak.org/usage-policy.php",
                    wait_s: CELESTRAK_WAIT_S,
                }
            }
            FetchSource::Supgp(typed) => {
                let (file, format) = (plain("file", &typed.file)?, typed.elements_format.name());
                let base = base("https://celestrak.org");
                Source {
                    name: "CelesTrak SupGP",
                    file: format!("supgp-{file}.{format}"),
                    url: format!("{base}/NORAD/elements/supplemental/sup-gp.php?FILE={file}&FORMAT={format}"),
                    login: None,
                    policy: "https://celestrak.org/usage-policy.php",
                    wait_s: CELESTRAK_WAIT_S,
                }
            }
            FetchSource::SpaceTrack(_) => {
                let base = base("https://www.space-track.org");
                Source {
                    name: "Space-Track",
                    file: "space-track-gp.csv".to_owned(),
                    // Query recommended by Space-Track for the newest element sets of all objects in orbit.
                    url: format!(
                        "{base}/basicspacedata/query/class/gp/decay_date/null-val/epoch/%3Enow-30/orderby/norad_cat_id/format/csv"
                    ),
                    login: Some(Login {
                        login_url: format!("{base}/ajaxauth/login"),
                        logout_url: format!("{base}/ajaxauth/logout"),
                    }),
                    policy: "https://www.space-track.org/documentation#/user_agree",
                    wait_s: WAIT_S,
                }
            }
            FetchSource::StarlinkEphemerides(_) => Source {
                name: "Starlink ephemerides",
                file: "starlink-ephemerides.manifest.txt".to_owned(),
                url: format!("{}/public-files/ephemerides/MANIFEST.txt", base("https://api.starlink.com")),
                login: None,
                policy: "no licence is stated; the files must not be redistributed",
                wait_s: WAIT_S,
            },
            FetchSource::Satchecker(typed) => {
                let julian_date = julian_date(parse_moment(&typed.epoch, None)?);
                let base = base("https://satchecker.cps.iau.org");
                Source {
                    name: "SatChecker",
                    file: format!("satchecker-{julian_date}.tle"),
                    url: format!("{base}/tools/tles-at-epoch/?epoch={julian_date}&format=txt"),
                    login: None,
                    policy: "https://satchecker.readthedocs.io",
                    wait_s: WAIT_S,
                }
            }
        })
    }
}

/// Returns the Julian date (UTC) rounded to an hour, so that requests for times within an hour use the same file.
fn julian_date(epoch: Epoch) -> String {
    let days = epoch.to_time_scale(TimeScale::UTC).to_jde_utc_days();
    format!("{:.4}", (days * 24.0).round() / 24.0)
}

/// Returns `name` if it can be part of an address and of a file name, otherwise an error.
fn plain<'a>(what: &str, name: &'a str) -> anyhow::Result<&'a str> {
    let is_plain = !name.is_empty()
        && name.len() <= 64
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_');
    if is_plain {
        Ok(name)
    } else {
        Err(anyhow!(
            "invalid {what} '{name}'; allowed: 1 to 64 letters, digits, - and _, for example starlink or active"
        ))
    }
}
